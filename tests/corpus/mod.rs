//! A sound mechanism and ways to spoil it.

#![allow(dead_code)]

use std::ops::ControlFlow;
use std::sync::OnceLock;

use manifold_rust::manifold::Manifold;
use mpcgear::design::{Design, Gear};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::assembly::{Carrier, SolidBody};
use mpcgear::solid::kernel::Solid;
use mpcgear::solid::{Mesh, Solids};
use mpcgear::verify::{Check, CheckInput, Claim, Effort, Printer, check};
use nalgebra::Vector3;

use crate::known;

/// A sound 1R mechanism, built once.
pub fn sound() -> &'static (Design, Vec<SolidBody>) {
    static SOUND: OnceLock<(Design, Vec<SolidBody>)> = OnceLock::new();
    SOUND.get_or_init(|| {
        let design = known::revolute();
        let bodies = bodies_of(&design);
        (design, bodies)
    })
}

pub fn bodies_of(design: &Design) -> Vec<SolidBody> {
    Solids::build(design, &known::motion(design.class))
        .expect("builds")
        .bodies
}

pub fn checked(design: &Design, motion: &Motion, bodies: &[SolidBody]) -> Check {
    let input = CheckInput {
        design,
        motion,
        bodies,
        pieces: &[],
        printer: Printer::of(&design.settings.fit),
        // 40 phases are four in each tooth's share of the turn.
        effort: Effort {
            steps: 120,
            escape_phases: 40,
            directions: 2,
            play_phases: 10,
        },
    };
    check(&input, &mut |_, _| ControlFlow::Continue(())).expect("checks")
}

pub fn failed(check: &Check) -> Vec<&str> {
    check
        .claims
        .iter()
        .filter(|c| !c.holds)
        .map(|c| c.name.as_str())
        .collect()
}

/// Checks the sound design on meshes of which one was changed.
pub fn with_mesh(carrier: Carrier, change: impl Fn(&Mesh) -> Mesh) -> Check {
    let (design, bodies) = sound();
    let mut bodies = bodies.clone();
    for body in bodies.iter_mut().filter(|b| b.carrier == carrier) {
        body.mesh = change(&body.mesh);
    }
    checked(design, &known::motion(Class::R1), &bodies)
}

/// Checks the sound design on bodies that were built from a changed design.
pub fn built_from(change: impl Fn(&mut Design)) -> Check {
    let (design, bodies) = sound();
    let mut spoiled = design.clone();
    change(&mut spoiled);
    // Only the driver is spoiled; the rest fits the sound design.
    let mut mixed = bodies.clone();
    mixed[0] = bodies_of(&spoiled).swap_remove(0);
    assert_eq!(mixed[0].carrier, Carrier::Driver);
    checked(design, &known::motion(Class::R1), &mixed)
}

/// A small ball in the driver frame.
pub fn ball(centre: Vector3<f64>, radius: f64) -> Solid {
    centred(Manifold::sphere(radius, 32), centre)
}

/// An upright square post on `foot`: half width and height.
pub fn post(foot: Vector3<f64>, (half, height): (f64, f64)) -> Solid {
    let size = manifold_rust::linalg::Vec3::new(2.0 * half, 2.0 * half, height);
    centred(
        Manifold::cube(size, true),
        foot + 0.5 * height * Vector3::z(),
    )
}

/// A shape around the origin, moved to `centre`.
fn centred(shape: Manifold, centre: Vector3<f64>) -> Solid {
    let gl = shape.get_mesh_gl64(-1);
    let mesh = Mesh {
        vertices: gl
            .vert_properties
            .chunks(gl.num_prop as usize)
            .map(|v| [v[0] + centre.x, v[1] + centre.y, v[2] + centre.z])
            .collect(),
        triangles: gl
            .tri_verts
            .chunks(3)
            .map(|t| [t[0] as u32, t[1] as u32, t[2] as u32])
            .collect(),
    };
    Solid::new(&mesh, "shape").expect("sound")
}

pub fn joined(mesh: &Mesh, solid: &Solid) -> Mesh {
    Solid::new(mesh, "body")
        .expect("sound")
        .union(solid)
        .one_body("body")
        .expect("one body")
}

/// Contact point and normal into the driver in the middle of tooth `j` of pair `k`.
pub fn middle(k: usize, j: usize) -> (Vector3<f64>, Vector3<f64>) {
    let stations = &sound().0.sub_gear_pairs[k].teeth[j].stations;
    let (p, n, _) = stations[stations.len() / 2].frame(Gear::Driver);
    (p, n)
}

pub fn claim<'a>(check: &'a Check, name: &str) -> &'a Claim {
    check.claims.iter().find(|c| c.name == name).expect(name)
}
