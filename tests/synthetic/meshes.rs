//! Simple solids around the synthetic teeth: enough to look at, not a mechanism to build.

use std::f64::consts::TAU;

use mpcgear::design::{Design, Gear};
use mpcgear::motion::{Motion, MotionState};
use mpcgear::solid::Mesh;
use nalgebra::Vector3;

use super::L;

const SIDES: u32 = 14;

/// Bodies at φ = 0 in Σ: label and mesh of driver, follower, support.
pub fn bodies(design: &Design, motion: &Motion) -> [(&'static str, Mesh); 3] {
    let reach = if design.sub_gear_pairs.len() > 2 {
        (-32.0, 32.0)
    } else {
        (2.0, 34.0)
    };
    let mut driver = teeth(design, Gear::Driver);
    append(&mut driver, &drum(-L, 9.0, reach));
    append(
        &mut driver,
        &drum(-L, 4.0, (reach.0 - 10.0, reach.1 + 18.0)),
    );
    let mut follower = teeth(design, Gear::Follower);
    append(&mut follower, &drum(0.0, 7.0, (4.0, reach.1)));
    append(&mut follower, &drum(0.0, 3.0, (-4.0, reach.1 + 12.0)));
    if reach.0 < 0.0 {
        append(&mut follower, &drum(0.0, 7.0, (reach.0, -4.0)));
    }
    let mut support = block([-50.0, -20.0, reach.0 - 10.0], [30.0, 20.0, reach.0 - 4.0]);
    append(
        &mut support,
        &block([-50.0, -8.0, reach.0 - 4.0], [-42.0, 8.0, reach.1 + 8.0]),
    );
    append(
        &mut support,
        &block([22.0, -8.0, reach.0 - 4.0], [30.0, 8.0, 3.0]),
    );
    [
        ("driver", driver.moved(&MotionState::driver(L, 0.0).pose)),
        ("follower", follower.moved(&motion.state(0.0).pose)),
        ("support", support),
    ]
}

fn append(mesh: &mut Mesh, other: &Mesh) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(&other.vertices);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
}

/// Tubes of the flank radius along the contact curves.
fn teeth(design: &Design, gear: Gear) -> Mesh {
    let radius = design.section.flank_radius;
    let mut mesh = Mesh::default();
    for tooth in design.sub_gear_pairs.iter().flat_map(|p| &p.teeth) {
        let rings: Vec<Vec<[f64; 3]>> = tooth
            .stations
            .iter()
            .map(|s| {
                let (p, n, t) = s.frame(gear);
                let b = t.cross(&n);
                let centre = p + n * (radius + 0.5 * design.section.clearance);
                (0..SIDES)
                    .map(|i| {
                        let (sin, cos) = (f64::from(i) * TAU / f64::from(SIDES)).sin_cos();
                        (centre + (n * cos + b * sin) * radius).into()
                    })
                    .collect()
            })
            .collect();
        append(&mut mesh, &loft(&rings));
    }
    mesh
}

/// Closed mesh through rings of equal length.
fn loft(rings: &[Vec<[f64; 3]>]) -> Mesh {
    let sides = rings[0].len() as u32;
    let mut mesh = Mesh {
        vertices: rings.iter().flatten().copied().collect(),
        triangles: Vec::new(),
    };
    for r in 0..rings.len() as u32 - 1 {
        for i in 0..sides {
            let (a, b) = (r * sides + i, r * sides + (i + 1) % sides);
            mesh.triangles
                .extend([[a, b, b + sides], [a, b + sides, a + sides]]);
        }
    }
    let top = (rings.len() as u32 - 1) * sides;
    for i in 1..sides - 1 {
        mesh.triangles
            .extend([[0, i + 1, i], [top, top + i, top + i + 1]]);
    }
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

fn drum(x: f64, radius: f64, (low, high): (f64, f64)) -> Mesh {
    let ring = |z: f64| -> Vec<[f64; 3]> {
        (0..48)
            .map(|i| {
                let angle = f64::from(i) * TAU / 48.0;
                [x + radius * angle.cos(), radius * angle.sin(), z]
            })
            .collect()
    };
    loft(&[ring(low), ring(high)])
}

fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corner = |z: f64| {
        vec![
            [low[0], low[1], z],
            [high[0], low[1], z],
            [high[0], high[1], z],
            [low[0], high[1], z],
        ]
    };
    loft(&[corner(low[2]), corner(high[2])])
}

/// Middle of a mesh's bounding box.
pub fn middle(mesh: &Mesh) -> Vector3<f64> {
    let (low, high) = mesh.bounds();
    (low + high) * 0.5
}
