//! The failures of the publication's Fig. 14 as example motions: each is named, placed, and has a remedy that was
//! computed.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

use serde_json::Value;

/// Designs an infeasible example: what is said of it, and the remedies in its summary by their changes.
fn refused(name: &str) -> (String, Vec<(String, f64)>) {
    let here = env!("CARGO_MANIFEST_DIR");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = assert_cmd::Command::new(env!("CARGO_BIN_EXE_mpcgear"))
        .args(["--quiet", "design", "-o"])
        .arg(&out)
        .arg(format!("{here}/examples/infeasible/{name}.toml"))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{said}");
    let summary = std::fs::read(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!(summary["feasible"], false);
    let remedies = summary["remedies"].as_array().unwrap().iter();
    let remedies = remedies.map(|r| {
        let change = r["change"].as_str().unwrap();
        (change.to_owned(), r["value"].as_f64().unwrap())
    });
    (said, remedies.collect())
}

fn has(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "{part:?} is not in:\n{said}");
    }
}

#[test]
fn a_range_that_is_too_large_is_named_with_the_amplitude_that_works() {
    let (said, remedies) = refused("range_too_large_3r");
    has(
        &said,
        &[
            "the motion range is so large",
            "it leans farthest at φ = ",
            "(45.0°)",
        ],
    );
    has(
        &said,
        &["tooth ", "hit the other gear's hub", "% of the amplitude"],
    );
    let share = remedies
        .iter()
        .find(|(change, _)| change == "amplitude")
        .unwrap()
        .1;
    assert!((0.3..0.95).contains(&share), "{share}");
}

#[test]
fn a_path_that_is_too_sharp_is_named_with_the_amplitude_that_works() {
    let (said, remedies) = refused("sharp_path_3r");
    has(
        &said,
        &[
            "turns too sharply",
            "it changes fastest at φ = ",
            "fold over themselves",
        ],
    );
    has(&said, &["fails by itself in", "% of the amplitude"]);
    assert!(remedies.iter().any(|(change, _)| change == "amplitude"));
}

#[test]
fn twelve_teeth_on_six_are_named_with_the_size_and_the_number_that_work() {
    let (said, remedies) = refused("twelve_to_six_3r");
    has(
        &said,
        &[
            "12 teeth on the driver and 6 on the follower",
            "not their mates",
        ],
    );
    has(&said, &["φ = ", "bands", "z = "]);
    let value = |name: &str| {
        remedies
            .iter()
            .find(|(change, _)| change == name)
            .unwrap()
            .1
    };
    assert_eq!(value("gear.driver_teeth"), 6.0);
    assert!(value("gear.center_distance_mm") > 25.0);
}
