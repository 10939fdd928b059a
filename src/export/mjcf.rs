//! `NAME.xml`: the gears as a MuJoCo model (MJCF) in which they move by their contacts alone.
//!
//! m, kg, s and rad. A tooth is a chain of capsules: balls of the flank's radius whose centres lie
//! on the sweep of the flank circle's centre ([`crate::solid::section`]). What is not modelled is
//! said at the head of the file.

use nalgebra::Vector3;
use serde::Serialize;

use super::{File, Source, freecad, tables, template};
use crate::design::{Design, Gear};
use crate::load::{Material, wrench};
use crate::motion::Class;
use crate::solid::{Solids, sweep};
use crate::{Error, Result};

/// Most capsules of a tooth. Their chords leave the curve of a tooth by some 10 µm.
const MOST_CAPSULES: usize = 16;

/// Shorter capsules are left out, mm: MuJoCo refuses those without a length.
const SHORTEST: f64 = 1e-3;

/// Steps of the target motion over one period.
const TARGET_STEPS: u32 = 360;

#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    generator: String,
    class: String,
    gravity: String,
    middle: String,
    extent: String,
    radius: String,
    friction: f64,
    target: Vec<String>,
    bodies: [Body; 2],
}

#[derive(Serialize)]
struct Body {
    name: &'static str,
    /// Pose at φ = 0 in Σ; the origin is where the joints are.
    position: String,
    rotation: String,
    joints: Vec<String>,
    /// Cylinder that has the body's mass.
    hub: String,
    hub_radius: String,
    mass: String,
    payload: Option<Payload>,
    /// A place halfway between the axes, seen from this one's.
    pitch_point: String,
    teeth: Vec<Capsule>,
}

#[derive(Serialize)]
struct Payload {
    place: String,
    radius: String,
    mass: String,
}

#[derive(Serialize)]
struct Capsule {
    name: String,
    ends: String,
}

/// The model of a design, one file.
///
/// # Errors
/// [`Error::Internal`] when a gear has no body or no teeth, or the template fails.
pub fn file(source: &Source, solids: &Solids) -> Result<File> {
    let design = source.design;
    let load = &design.settings.load;
    let start = source.motion.state(0.0).pose;
    let drive = design.settings.gear.drive();
    let length = drive.center_distance();
    let turn = start.quaternion();
    let mut driver = body(design, solids, Gear::Driver)?;
    driver.position = metres([-length, 0.0, 0.0]);
    driver.joints =
        vec![r#"<joint name="driver" type="hinge" axis="0 0 1" armature="2e-3"/>"#.into()];
    let mut follower = body(design, solids, Gear::Follower)?;
    follower.position = metres(start.translation.into());
    follower.rotation = format!(
        "{:.12} {:.12} {:.12} {:.12}",
        turn.w, turn.i, turn.j, turn.k
    );
    // MuJoCo wants axes in the body's frame: z of Σ.
    let z = start.rotation.transpose() * Vector3::z();
    follower.joints = joints(design.class, z);
    follower.payload = (load.mass_g > 0.0).then(|| {
        let mass = load.mass_g * 1e-3;
        // A ball of steel: it gives the payload its inertia.
        let volume = mass / Material::Steel.density();
        let radius = (0.75 * volume / std::f64::consts::PI).cbrt();
        Payload {
            place: metres(load.point_mm),
            radius: format!("{radius:.6}"),
            mass: format!("{mass}"),
        }
    });
    let gravity = wrench::gravity(load);
    let target = tables::poses_of_turn(source.motion, drive, TARGET_STEPS);
    let text = template::render(
        "mjcf",
        Page {
            name: &design.name,
            generator: super::maker(design),
            class: design.class.to_string(),
            gravity: format!("{:.6} {:.6} {:.6}", gravity.x, gravity.y, gravity.z),
            middle: metres([-0.5 * length, 0.0, 0.0]),
            extent: format!("{}", 4e-3 * length),
            radius: format!("{:.9}", 1e-3 * design.section.bead_radius()),
            friction: load.friction,
            target: target
                .iter()
                .map(|row| {
                    let place = metres([row.x, row.y, row.z]);
                    format!("{place} {} {} {} {}", row.qw, row.qx, row.qy, row.qz)
                })
                .collect(),
            bodies: [driver, follower],
        },
    )?;
    Ok(File::new(format!("{}.xml", freecad::stem(design)), text))
}

/// The joints of the follower; `z` is the axis of Σ in the follower's frame at φ = 0.
fn joints(class: Class, z: Vector3<f64>) -> Vec<String> {
    let axis = format!("{:.12} {:.12} {:.12}", z.x, z.y, z.z);
    let slide = format!(r#"<joint name="follower_slide" type="slide" axis="{axis}"/>"#);
    let turn = match class.is_spherical() {
        true => r#"<joint name="follower_ball" type="ball"/>"#.into(),
        false => format!(r#"<joint name="follower_hinge" type="hinge" axis="{axis}"/>"#),
    };
    // MuJoCo moves along the first joint first.
    class
        .slides()
        .then_some(slide)
        .into_iter()
        .chain([turn])
        .collect()
}

/// A gear at rest in its own frame, its origin moved to its axis, without its joints.
fn body(design: &Design, solids: &Solids, gear: Gear) -> Result<Body> {
    let load = &design.settings.load;
    let (name, material, towards) = match gear {
        Gear::Driver => ("driver", load.driver_material, 0.5),
        Gear::Follower => ("follower", load.follower_material, -0.5),
    };
    let missing = |what: &str| Error::Internal(format!("mjcf: the {name} has no {what}"));
    let length = design.settings.gear.center_distance_mm;
    let axis = sweep::axis_point(gear, length);
    let depth = 0.5 * design.section.clearance + design.section.bead_radius();
    let mut teeth = Vec::new();
    let mut centres = Vec::new();
    let drive = design.settings.gear.drive();
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        let numbers = 0..sweep::copies(drive, gear) * pair.teeth.len();
        for number in numbers {
            let tooth = &pair.teeth[number % pair.teeth.len()];
            let copy = drive.copy(number / pair.teeth.len());
            let line: Vec<Vector3<f64>> = sweep::thinned(tooth.stations.len(), MOST_CAPSULES + 1)
                .into_iter()
                .map(|i| {
                    let (p, n, _) = tooth.stations[i].frame(gear);
                    copy.apply(p + depth * n) - axis
                })
                .collect();
            let ends = line.windows(2).filter(|w| (w[1] - w[0]).norm() > SHORTEST);
            for (i, w) in ends.enumerate() {
                teeth.push(Capsule {
                    name: format!("{}_{}_{}", k + 1, number + 1, i + 1),
                    ends: format!("{} {}", metres(w[0].into()), metres(w[1].into())),
                });
            }
            centres.extend(line);
        }
    }
    let nearest = centres.iter().map(|c| c.xy().norm()).reduce(f64::min);
    let nearest = nearest.ok_or_else(|| missing("teeth"))?;
    let heights = || centres.iter().map(|c| c.z);
    let low = heights().fold(f64::INFINITY, f64::min);
    let high = heights().fold(f64::NEG_INFINITY, f64::max).max(low + 1.0);
    let solid = solids.bodies.iter().find(|b| b.name == name);
    let volume = solid.ok_or_else(|| missing("body"))?.mesh.volume();
    Ok(Body {
        name,
        position: String::new(),
        rotation: "1 0 0 0".into(),
        joints: Vec::new(),
        hub: format!("{} {}", metres([0.0, 0.0, low]), metres([0.0, 0.0, high])),
        hub_radius: format!("{:.6}", 1e-3 * nearest.max(1.0)),
        // mm³ to m³.
        mass: format!("{:.6}", volume * 1e-9 * material.density()),
        payload: None,
        pitch_point: metres([towards * length, 0.0, 0.5 * (low + high)]),
        teeth,
    })
}

/// A vector in mm as m, to a nanometre.
fn metres(v: [f64; 3]) -> String {
    let [x, y, z] = v.map(|x| 1e-3 * x + 0.0);
    format!("{x:.9} {y:.9} {z:.9}")
}
