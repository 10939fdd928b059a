//! `mpcgear motion show`: what it says of motions whose answer is known.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

use std::fs;
use std::process::Output;

use mpcgear::motion::survey::{Survey, survey};
use mpcgear::motion::{Class, Motion, MotionFile, MotionSource};
use serde_json::{Value, json};
use tempfile::TempDir;

const L: f64 = 25.0;

fn surveyed(class: Class, mut formula: Value) -> Survey {
    formula["kind"] = "formula".into();
    let source: MotionSource = serde_json::from_value(formula).unwrap();
    let motion = Motion::new(class, &source).unwrap();
    survey(&motion, L, [0.0, 0.0, 60.0].into())
}

/// A cone of `degrees` that goes round once per turn.
fn cone(degrees: f64) -> Value {
    let (s, c) = degrees.to_radians().sin_cos();
    json!({ "axis": [format!("{s}*cos(phi)"), format!("{s}*sin(phi)"), format!("{c}")] })
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() < within, "{a} is not {b}");
}

fn folder(motion: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my.toml"), motion).unwrap();
    folder
}

fn run(folder: &TempDir, arguments: &[&str]) -> Output {
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_mpcgear"))
        .current_dir(folder.path())
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn a_cone_tilts_by_its_angle_and_its_point_goes_round_a_circle() {
    let cone = surveyed(Class::R3, cone(8.0));
    let angle = 8f64.to_radians();
    for sample in &cone.samples {
        near(sample.tilt_deg, 8.0, 1e-9);
        near(sample.point_mm[2], 60.0 * angle.cos(), 1e-9);
    }
    near(cone.tilt_max_deg, 8.0, 1e-9);
    near(
        cone.path_mm,
        std::f64::consts::TAU * 60.0 * angle.sin(),
        1e-2,
    );
    near(cone.net_turns, -1.0, 1e-9);
    assert_eq!(cone.least_class, Class::R3);
}

#[test]
fn a_stroke_has_the_speed_and_sharpness_of_its_derivatives() {
    let stroke = surveyed(
        Class::R3T1,
        json!({ "translation": ["0", "0", "3*sin(2*phi)"] }),
    );
    near(stroke.slide_mm[0], -3.0, 1e-9);
    near(stroke.slide_mm[1], 3.0, 1e-9);
    near(stroke.slide_speed_max_mm_rad, 6.0, 1e-9);
    near(stroke.sharpness.most_mm_rad2, 12.0, 1e-9);
    near(stroke.turn_speed_max, 1.0, 1e-9);
    near(stroke.lead_max_deg, 0.0, 1e-9);
}

#[test]
fn an_uneven_turn_is_as_sharp_as_the_pitch_radius_times_its_second_derivative() {
    let uneven = surveyed(Class::R1, json!({ "own_turn": "-phi + 0.3*sin(phi)" }));
    near(uneven.lead_max_deg, 0.3f64.to_degrees(), 1e-9);
    near(uneven.turn_speed_max, 1.3, 1e-9);
    near(uneven.sharpness.most_mm_rad2, 0.3 * L / 2.0, 1e-9);
    let turn = |degrees: usize| uneven.samples[degrees].turn_deg;
    near(turn(270), -270.0 - 0.3f64.to_degrees(), 1e-9);
    near(turn(360), -360.0, 1e-9);
}

#[test]
fn the_least_class_takes_the_motion_and_no_smaller_one_does() {
    let lift = json!(["0", "0", "2*sin(phi)"]);
    let mut lifted = cone(5.0);
    lifted["translation"] = lift.clone();
    for (formula, least) in [
        (json!({ "own_turn": "-phi + 0.2*sin(phi)" }), Class::R1),
        (json!({ "translation": lift }), Class::R1T1),
        (cone(5.0), Class::R3),
        (lifted, Class::R3T1),
    ] {
        assert_eq!(surveyed(Class::R3T1, formula.clone()).least_class, least);
        let mut source = formula;
        source["kind"] = "formula".into();
        let source: MotionSource = serde_json::from_value(source).unwrap();
        for class in Class::ALL {
            let holds = (class.is_spherical() || !least.is_spherical())
                && (class.slides() || !least.slides());
            assert_eq!(
                Motion::new(class, &source).is_ok(),
                holds,
                "{least} {class}"
            );
        }
    }
}

#[test]
fn every_example_turns_once_against_the_driver() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples");
    let paths = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let files: Vec<_> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "toml"))
        .collect();
    assert!(files.len() >= 8);
    for path in files {
        let (_, motion) = MotionFile::read(&path).unwrap();
        if !motion.cycle().wraps() {
            continue; // there and back its turn is free
        }
        let survey = survey(&motion, L, [0.0, 0.0, 60.0].into());
        // A motion that goes there and back may turn by whatever it likes.
        if motion.cycle().wraps() {
            near(survey.net_turns, -1.0, 1e-6);
        }
        assert!(survey.lead_max_deg < 180.0, "{}", path.display());
    }
}

#[test]
fn the_sharpness_is_the_one_that_design_reports() {
    let motion = "class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi + 0.95*sin(phi)\"\n\
                  [search]\neffort = 0.02\n";
    let folder = folder(motion);
    let designed = run(&folder, &["design", "my.toml", "-o", "out", "--draft"]);
    assert_eq!(designed.status.code(), Some(3));
    let shown: Value =
        serde_json::from_slice(&run(&folder, &["--json", "motion", "show", "my.toml"]).stdout)
            .unwrap();
    let sharp = &shown["sharpness"];
    let phrase = format!(
        "φ = {:.0}° ({:.1} mm/rad²",
        sharp["phi_deg"].as_f64().unwrap(),
        sharp["most_mm_rad2"].as_f64().unwrap()
    );
    let said = text(&designed.stderr);
    assert!(said.contains(&phrase), "{phrase} is not in {said}");
    assert_eq!(shown["verdict"], "may work");
}

#[test]
fn a_plain_turn_written_as_3r_needs_1r_only() {
    let folder = folder("name = \"plain\"\nclass = \"3R\"\n[motion]\nkind = \"formula\"\n");
    let output = run(&folder, &["motion", "show", "my.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let line = |name: &str| {
        said.lines()
            .find(|l| l.starts_with(name))
            .unwrap()
            .to_string()
    };
    assert!(line("Class of the file").contains("3R"));
    assert!(line("Least class").contains(" 1R "), "{said}");
    assert!(line("Net turn").contains("-1.000"), "{said}");
}

#[test]
fn a_bad_file_is_refused_as_by_design() {
    let folder = folder("class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi + x\"\n");
    let designed = run(&folder, &["design", "my.toml", "-o", "out"]);
    let shown = run(&folder, &["motion", "show", "my.toml"]);
    assert_eq!(shown.status.code(), Some(2));
    assert_eq!(text(&shown.stderr), text(&designed.stderr));
    assert_eq!(text(&shown.stdout), "");
}

#[test]
fn the_course_is_a_row_per_degree_with_what_the_survey_says() {
    let folder = folder(
        "class = \"1R1T\"\n[motion]\nkind = \"formula\"\ntranslation = [\"0\", \"0\", \"3*sin(phi)\"]\n",
    );
    let output = run(&folder, &["motion", "show", "my.toml", "--csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut reader = csv::Reader::from_reader(output.stdout.as_slice());
    let columns = reader.headers().unwrap().clone();
    let at = |name: &str| columns.iter().position(|c| c == name).unwrap();
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|row| row.unwrap().iter().map(|c| c.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 361);
    let quarter = &rows[90];
    near(quarter[at("phi_deg")], 90.0, 1e-6);
    near(quarter[at("slide_mm")], 3.0, 1e-6);
    near(quarter[at("turn_deg")], -90.0, 1e-6);
    near(quarter[at("slide_speed_mm_rad")], 0.0, 1e-6);
    near(quarter[at("sharpness_mm_rad2")], 3.0, 1e-6);
    near(rows[0][at("slide_speed_mm_rad")], 3.0, 1e-6);
}
