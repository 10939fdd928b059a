//! The generated scripts in real OpenSCAD: no warning, one closed body, the volume of our mesh.
//!
//! Without OpenSCAD the tests say so and pass, unless MPCGEAR_REQUIRE_CAD=1 (as in `.ci/run`).

mod openscad_run;
mod synthetic;

use std::path::{Path, PathBuf};
use std::process::Command;

use mpcgear::design::Design;
use mpcgear::disk::Folder;
use mpcgear::export::{self, Source, tables::Summary};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::Solids;
use openscad_run::{Run, installed, manifold};

/// Largest difference between OpenSCAD's volume and ours.
const VOLUME_TOLERANCE: f64 = 0.005;

/// Teeth per band for CGAL, which takes 20 s for a part with all of them.
const TEETH: usize = 4;

/// The output folder of the synthetic design of `class`, with the solids it was made from.
fn folder_of(class: Class, teeth: usize) -> (PathBuf, Solids) {
    folder_with(synthetic::uniform(class), teeth)
}

fn folder_with((mut design, motion): (Design, Motion), teeth: usize) -> (PathBuf, Solids) {
    for pair in &mut design.sub_gear_pairs {
        pair.teeth.truncate(teeth);
    }
    let solids = Solids::build(&design, &motion).expect("builds");
    design.recipe = solids.recipe.clone();
    let files = files(&design, &motion, &solids);
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join(format!("openscad-{}-{teeth}", design.name));
    Folder::claim(&out)
        .and_then(|out| out.publish(&files))
        .expect("writable");
    (out, solids)
}

fn files(design: &Design, motion: &Motion, solids: &Solids) -> Vec<mpcgear::export::File> {
    let source = Source {
        design,
        motion,
        solids: Some(solids),
    };
    export::files(&source, &Summary::of(design)).expect("exports")
}

fn every_part_is_sound(class: Class) {
    if !installed() {
        return;
    }
    sound(folder_of(class, TEETH));
}

/// Every part in OpenSCAD against our mesh.
fn sound((out, solids): (PathBuf, Solids)) {
    for body in &solids.bodies {
        let script = out.join(format!("openscad/{}.scad", body.name));
        let mesh = Run::new(&script).stl("default").one_closed_body();
        let (ours, theirs) = (body.mesh.volume(), mesh.volume());
        assert!(
            (theirs / ours - 1.0).abs() < VOLUME_TOLERANCE,
            "{} {}: OpenSCAD {theirs:.2} mm³, embedded kernel {ours:.2} mm³",
            out.display(),
            body.name
        );
    }
}

#[test]
fn a_driver_with_more_teeth_is_sound() {
    if installed() {
        sound(folder_with(synthetic::unequal(Class::R1), 2));
    }
}

#[test]
fn parts_of_1r_are_sound() {
    every_part_is_sound(Class::R1);
}

#[test]
fn parts_of_1r1t_are_sound() {
    every_part_is_sound(Class::R1T1);
}

#[test]
fn parts_of_3r_are_sound() {
    every_part_is_sound(Class::R3);
}

#[test]
fn parts_of_3r1t_are_sound() {
    every_part_is_sound(Class::R3T1);
}

/// Parts with all their teeth, with the backend that current snapshots of OpenSCAD have.
fn every_part_is_sound_with_manifold(class: Class) {
    let Some(manifold) = manifold() else {
        return;
    };
    let (out, solids) = folder_of(class, usize::MAX);
    for body in &solids.bodies {
        let script = out.join(format!("openscad/{}.scad", body.name));
        for set in [None, Some("draft"), Some("fdm_0.4")] {
            let run = Run::with(&manifold, &script);
            let run = match set {
                Some(name) => run.set_of(&script.with_file_name("parameters.json"), name),
                None => run,
            };
            // A printer's set lays the pieces side by side.
            let pieces = solids.pieces.iter().filter(|p| p.body == body.name);
            let count = if set == Some("fdm_0.4") {
                pieces.count()
            } else {
                1
            };
            let mesh = run.stl("manifold").closed_bodies(count);
            let (ours, theirs) = (body.mesh.volume(), mesh.volume());
            assert!(
                set.is_some() || (theirs / ours - 1.0).abs() < VOLUME_TOLERANCE,
                "{class} {}: OpenSCAD {theirs:.2} mm³, embedded kernel {ours:.2} mm³",
                body.name
            );
        }
    }
}

#[test]
fn parts_of_1r_are_sound_with_manifold() {
    every_part_is_sound_with_manifold(Class::R1);
}

#[test]
fn parts_of_1r1t_are_sound_with_manifold() {
    every_part_is_sound_with_manifold(Class::R1T1);
}

#[test]
fn parts_of_3r_are_sound_with_manifold() {
    every_part_is_sound_with_manifold(Class::R3);
}

#[test]
fn parts_of_3r1t_are_sound_with_manifold() {
    every_part_is_sound_with_manifold(Class::R3T1);
}

/// The assembly at a driver angle as OpenSCAD's tree of plain solids, without a complaint.
fn assembly_tree(out: &Path, values: &[(&str, &str)]) -> String {
    let script = out.join("openscad/assembly.scad");
    let tree = out.join("openscad/assembly.csg");
    let values = values.iter().map(|(name, value)| format!("{name}={value}"));
    let output = Command::new("openscad")
        .args(["--hardwarnings", "-D", "quality=\"draft\"", "-o"])
        .arg(&tree)
        .args(values.flat_map(|value| ["-D".into(), value]))
        .arg(&script)
        .output()
        .expect("openscad runs");
    let said = String::from_utf8_lossy(&output.stderr);
    let complaint = ["ERROR", "WARNING"].iter().any(|word| said.contains(word));
    assert!(output.status.success() && !complaint, "{said}");
    std::fs::read_to_string(tree).expect("a tree")
}

#[test]
fn the_assembly_places_every_body_where_the_motion_has_it() {
    if !installed() {
        return;
    }
    for class in [Class::R1, Class::R3T1] {
        let (out, solids) = folder_of(class, 1);
        let (_, motion) = synthetic::uniform(class);
        for angle in [0.0, 100.0] {
            let tree = assembly_tree(&out, &[("angle", &angle.to_string())]);
            let colours = tree.matches("color(").count();
            assert_eq!(colours, solids.bodies.len(), "one colour per body");
            // The follower's pose is a matrix of its own right inside its colour.
            let rotation = motion.state(f64::to_radians(angle)).pose.rotation;
            let row = format!("{:.4}", rotation[(0, 0)]);
            let found = tree.lines().any(|line| {
                let numbers: Vec<f64> = line
                    .split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)))
                    .filter_map(|word| word.parse().ok())
                    .collect();
                let near = |i: usize, j: usize, value: f64| {
                    numbers
                        .get(4 * i + j)
                        .is_some_and(|x| (x - value).abs() < 1e-4)
                };
                line.trim_start().starts_with("multmatrix")
                    && (0..3).all(|i| (0..3).all(|j| near(i, j, rotation[(i, j)])))
            });
            assert!(found, "{class}: no follower turned by {row} at {angle}°");
        }
    }
}

#[test]
fn the_assembly_hides_and_takes_apart() {
    if !installed() {
        return;
    }
    let (out, solids) = folder_of(Class::R3, 1);
    let whole = assembly_tree(&out, &[]);
    for body in &solids.bodies {
        let name = format!("show_{}", body.name);
        let less = assembly_tree(&out, &[(&name, "false")]);
        let colours = less.matches("color(").count();
        assert_eq!(colours, solids.bodies.len() - 1, "{name}");
    }
    // Half way apart, driver and follower are moved by 1.5 times the distance of their axes.
    let apart = assembly_tree(&out, &[("exploded", "0.5")]);
    assert_eq!(whole.lines().count(), apart.lines().count());
    let moved = whole.lines().zip(apart.lines()).filter(|(a, b)| a != b);
    let moved: Vec<&str> = moved.map(|(_, line)| line).collect();
    assert!((2..=3).contains(&moved.len()), "{moved:?}");
    assert!(
        moved
            .iter()
            .all(|line| line.contains("multmatrix") && line.contains("-37.5"))
    );
}
