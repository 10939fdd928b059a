//! The generated scripts in real OpenSCAD: no warning, one closed body, the volume of our mesh.
//!
//! Without OpenSCAD the tests say so and pass, unless MPCGEAR_REQUIRE_CAD=1 (as in `.ci/run`).

mod openscad_run;
mod synthetic;

use std::path::PathBuf;

use mpcgear::export::{self, Source, folder, tables::Summary};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::Solids;
use openscad_run::{Run, installed};

/// Largest difference between OpenSCAD's volume and ours.
const VOLUME_TOLERANCE: f64 = 0.005;

/// The output folder of the synthetic design of `class`, with the solids it was made from.
fn folder_of(class: Class) -> (PathBuf, Solids) {
    let (mut design, motion) = synthetic::uniform(class);
    let solids = Solids::build(&design, &motion).expect("builds");
    design.recipe = solids.recipe.clone();
    let files = files(&design, &motion, &solids);
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("openscad-{class}"));
    folder::publish(&out, &files).expect("writable");
    (out, solids)
}

fn files(
    design: &mpcgear::design::Design,
    motion: &Motion,
    solids: &Solids,
) -> Vec<mpcgear::export::File> {
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
    let (out, solids) = folder_of(class);
    for body in &solids.bodies {
        let script = out.join(format!("openscad/{}.scad", body.name));
        let mesh = Run::new(&script).stl("default").one_closed_body();
        let (ours, theirs) = (body.mesh.volume(), mesh.volume());
        assert!(
            (theirs / ours - 1.0).abs() < VOLUME_TOLERANCE,
            "{class} {}: OpenSCAD {theirs:.2} mm³, embedded kernel {ours:.2} mm³",
            body.name
        );
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
