//! `mpcgear check` as users call it: files in, table and exit code out.

mod known;

use std::fmt::Write;
use std::path::Path;
use std::process::Output;

use mpcgear::design::Design;
use mpcgear::export::{Source, stl};
use mpcgear::motion::Class;
use mpcgear::solid::{Mesh, Solids};
use serde_json::Value;

/// An output folder with a sound design and its meshes.
fn folder() -> (tempfile::TempDir, Mesh) {
    let mut design = known::revolute();
    let motion = known::motion(Class::R1);
    let solids = Solids::build(&design, &motion).expect("builds");
    design.recipe = solids.recipe.clone();
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let folder = tempfile::tempdir().expect("a folder");
    let meshes = folder.path().join("meshes");
    std::fs::create_dir(&meshes).expect("made");
    for body in &solids.bodies {
        let bytes = stl::binary(&source.placed(body)).expect("stl");
        std::fs::write(meshes.join(format!("{}.stl", body.name)), bytes).expect("written");
    }
    save(&design, folder.path());
    let driver = source.placed(&solids.bodies[0]);
    (folder, driver)
}

fn save(design: &Design, folder: &Path) {
    let text = mpcgear::design::file::text(design).expect("json");
    std::fs::write(folder.join("design.json"), text).expect("written");
}

/// The mesh as ASCII STL, every corner through `place`.
fn ascii(mesh: &Mesh, place: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut text = String::from("solid part\n");
    for t in &mesh.triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for &i in t {
            let [x, y, z] = place(mesh.vertices[i as usize]).map(|c| c as f32);
            writeln!(text, "vertex {x:e} {y:e} {z:e}").expect("text");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid part\n"
}

fn check(folder: &Path, arguments: &[&str]) -> Output {
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_mpcgear"))
        .current_dir(folder)
        .args(["check", "."])
        .args(arguments)
        .output()
        .expect("runs")
}

#[test]
fn meshes_of_other_programs_are_checked_in_place_of_the_designs() {
    let (folder, driver) = folder();
    std::fs::write(folder.path().join("good.stl"), ascii(&driver, |p| p)).expect("written");
    let output = check(
        folder.path(),
        &["--json", "--effort", "0.1", "--driver", "good.stl"],
    );
    let answer: Value = serde_json::from_slice(&output.stdout).expect("json");
    let claims = answer["claims"].as_array().expect("claims");
    let failed: Vec<&Value> = claims.iter().filter(|c| c["holds"] != true).collect();
    assert_eq!(failed, Vec::<&Value>::new());
    assert_eq!(
        (output.status.code(), &answer["holds"]),
        (Some(0), &true.into())
    );
    assert_eq!(answer["meshes"][0]["from"], "good.stl");
    assert_eq!(answer["touching"].as_array().map(Vec::len), Some(20));
    let apart = claims
        .iter()
        .find(|c| c["name"] == "driver and follower stay apart")
        .expect("a claim");
    assert!(apart["value"].as_f64().is_some_and(|gap| gap > 0.05));
    assert!(apart["spot"]["phi_deg"].is_number() && apart["spot"]["tooth"].is_number());

    // Mirrored: every facet has to be turned over as well, or it were inside out.
    let turned = Mesh {
        vertices: driver.vertices.clone(),
        triangles: driver
            .triangles
            .iter()
            .map(|&[a, b, c]| [a, c, b])
            .collect(),
    };
    let mirrored = ascii(&turned, |[x, y, z]| [x, -y, z]);
    std::fs::write(folder.path().join("mirrored.stl"), mirrored).expect("written");
    let output = check(
        folder.path(),
        &["--effort", "0.1", "--driver", "mirrored.stl"],
    );
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("FAILS driver and follower stay apart"),
        "{text}"
    );
    assert!(text.contains("holds closed meshes"), "{text}");
}

#[test]
fn bad_input_is_refused_and_a_draft_without_teeth_fails() {
    let (folder, driver) = folder();
    let text = ascii(&driver, |p| p);
    let whole = stl::binary(&driver).expect("stl");
    let inches = ascii(&driver, |p| p.map(|c| c / 25.4));
    for (name, bytes) in [
        ("bad.stl", b"no mesh".as_slice()),
        ("nothing.stl", b""),
        ("empty.stl", b"solid part\nendsolid part\n"),
        ("cut.stl", &text.as_bytes()[..text.len() / 2]),
        ("cut_binary.stl", &whole[..whole.len() / 2]),
        ("inches.stl", inches.as_bytes()),
    ] {
        std::fs::write(folder.path().join(name), bytes).expect("written");
        let output = check(folder.path(), &["--driver", name]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {message}");
        assert!(message.contains(name), "{message}");
        assert_eq!(message.contains("another unit"), name == "inches.stl");
    }
    for arguments in [
        &["--driver", "bad.stl"][..],
        &["--follower", "missing.stl"],
        &["--printer", "200x200"],
        &["--printer", "1x2xfoox3"],
        &["--tolerance", "-1"],
    ] {
        let output = check(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty());
    }
    let mut draft = known::revolute();
    draft.sub_gear_pairs.clear();
    draft.closure.clear();
    let empty = tempfile::tempdir().expect("a folder");
    save(&draft, empty.path());
    let output = check(empty.path(), &[]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("undecided") && !text.lines().any(|line| line.starts_with("holds")),
        "{text}"
    );
}
