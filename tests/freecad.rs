//! FreeCAD files of synthetic designs, judged by running FreeCAD.

mod synthetic;

use std::path::Path;

use mpcgear::design::Design;
use mpcgear::export::freecad::{self, Headless};
use mpcgear::motion::Class;
use mpcgear::solid::Solids;

const DATE: &str = "2026-01-01";

/// Teeth per band of the tests' designs: enough to have neighbours, few enough for a quick FreeCAD.
const TEETH: usize = 2;

/// A synthetic design with its recipe, and its solids.
fn built(class: Class, teeth: usize) -> (Design, Solids) {
    let (mut design, motion) = synthetic::uniform(class);
    for pair in &mut design.sub_gear_pairs {
        pair.teeth.truncate(teeth);
    }
    let solids = Solids::build(&design, &motion).expect("builds");
    design.recipe = solids.recipe.clone();
    (design, solids)
}

/// Whether FreeCAD is here; without it the test is skipped, unless MPCGEAR_REQUIRE_CAD=1.
fn freecad_is_here() -> bool {
    let found = std::process::Command::new("freecadcmd")
        .arg("--version")
        .output()
        .is_ok();
    let required = std::env::var("MPCGEAR_REQUIRE_CAD").is_ok_and(|v| v == "1");
    assert!(found || !required, "freecadcmd is not installed");
    if !found {
        eprintln!("skipped: freecadcmd is not installed");
    }
    found
}

/// Runs the macro of a class and compares every part's volume with the embedded kernel's mesh.
fn macro_agrees_with_the_mesh(class: Class) {
    if !freecad_is_here() {
        return;
    }
    let (design, solids) = built(class, TEETH);
    let folder = tempfile::tempdir().expect("folder");
    let headless = Headless {
        program: Path::new("freecadcmd"),
        folder: folder.path(),
        thorough: true,
    };
    let made = freecad::run(&design, DATE, &headless).expect("runs");
    assert_eq!(made.volumes.len(), solids.bodies.len());
    for body in &solids.bodies {
        let (_, volume) = made
            .volumes
            .iter()
            .find(|(name, _)| *name == body.name)
            .expect("part");
        let mesh = body.mesh.volume();
        let off = (volume - mesh).abs() / mesh;
        println!("{class} {}: FreeCAD {volume:.2}, mesh {mesh:.2}, {:.3} %", body.name, 100.0 * off);
        assert!(off < 0.005, "{}: {volume} in FreeCAD, {mesh} as mesh", body.name);
    }
}

#[test]
fn macro_of_1r_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R1);
}

#[test]
fn macro_of_1r1t_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R1T1);
}

#[test]
fn macro_of_3r_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R3);
}

#[test]
fn macro_of_3r1t_agrees_with_the_mesh() {
    macro_agrees_with_the_mesh(Class::R3T1);
}

#[test]
fn writes_sample_macros() {
    for class in Class::ALL {
        let (design, _) = built(class, 10);
        let text = freecad::macro_text(&design, DATE).expect("renders");
        std::fs::write(format!("/tmp/fc/{}.FCMacro", freecad::stem(&design)), text).unwrap();
        std::fs::write(format!("/tmp/fc/{}.json", freecad::stem(&design)), serde_json::to_string(&design).unwrap()).unwrap();
    }
}
