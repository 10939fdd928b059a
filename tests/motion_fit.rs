//! `mpcgear motion fit`: motions that are known are found again behind noise, gaps and outliers.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Output;

use mpcgear::motion::fit::{Fit, Tolerance, fit};
use mpcgear::motion::{Class, Measured, Motion, MotionFile, MotionSource};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

const L: f64 = 25.0;
const TOLERANCE: Tolerance = Tolerance { mm: 0.2, deg: 0.5 };

/// Noise of a measurement: position (mm) and rotation (rad), standard deviation of each component.
const NOISE: (f64, f64) = (0.04, 0.0015);

/// One measured pose: phase (deg), rotation, position.
type Pose = (f64, UnitQuaternion<f64>, Vector3<f64>);

/// Tilts with two harmonics, slides with three, turns unevenly.
fn truth(class: Class) -> Motion {
    let spherical = match class.is_spherical() {
        true => json!(["0.15*cos(phi)", "0.1*sin(2*phi)", "0.2*sin(phi)"]),
        false => json!(["0", "0", "0.2*sin(phi)"]),
    };
    let lift = match class.slides() {
        true => "1.5*sin(phi) + 0.4*cos(3*phi)",
        false => "0",
    };
    let source = json!({
        "kind": "formula", "rotation": spherical, "translation": ["0", "0", lift]
    });
    let source: MotionSource = serde_json::from_value(source).unwrap();
    Motion::new(class, &source).unwrap()
}

/// Poses of the truth at every `step` degrees up to a whole period.
fn poses(class: Class, step: usize) -> Vec<Pose> {
    let motion = truth(class);
    (0..=360 / step)
        .map(|i| {
            let degrees = (i * step) as f64;
            let pose = motion.user_pose(degrees.to_radians());
            (degrees, pose.quaternion(), pose.translation)
        })
        .collect()
}

fn noisy(mut poses: Vec<Pose>, seed: u64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // Twelve uniform draws have variance one.
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let mut three = |size: f64| Vector3::from_fn(|_, _| size * normal());
    for (_, rotation, position) in &mut poses {
        *position += three(NOISE.0);
        *rotation = UnitQuaternion::from_scaled_axis(three(NOISE.1)) * *rotation;
    }
    poses
}

fn csv(poses: &[Pose]) -> String {
    let mut text = "phi_deg,x,y,z,qw,qx,qy,qz\n".to_owned();
    for (phi, q, p) in poses {
        let [w, i, j, k] = [q.w, q.i, q.j, q.k];
        writeln!(text, "{phi},{},{},{},{w},{i},{j},{k}", p.x, p.y, p.z).unwrap();
    }
    text
}

fn fitted(poses: &[Pose], tolerance: Tolerance) -> mpcgear::Result<Fit> {
    let measured = Measured::from_csv(&csv(poses), "noisy.csv")?;
    fit(&measured, (None, tolerance), L)
}

/// Root mean squares of the distances of a motion from the truth: mm and rad.
fn error(fit: &Fit, class: Class) -> (f64, f64) {
    let (mut mm, mut rad) = (0.0, 0.0);
    for (phi, rotation, position) in poses(class, 1) {
        let pose = fit.motion.user_pose(f64::to_radians(phi));
        mm += (pose.translation - position).norm_squared();
        rad += pose.quaternion().angle_to(&rotation).powi(2);
    }
    let count = 361.0;
    ((mm / count).sqrt(), (rad / count).sqrt())
}

#[test]
fn noise_is_removed_in_every_class() {
    for class in Class::ALL {
        let fit = fitted(&noisy(poses(class, 2), 7), TOLERANCE).unwrap();
        let report = &fit.report;
        assert_eq!(report.class, class);
        assert!(report.outliers.is_empty(), "{:?}", report.outliers);
        assert!(report.largest.mm <= TOLERANCE.mm && report.largest.deg <= TOLERANCE.deg);
        assert!(report.rms.mm <= report.largest.mm);
        // Three components of noise each; most of it is gone.
        let (mm, rad) = error(&fit, class);
        assert!(mm < 0.4 * NOISE.0 * 3f64.sqrt(), "{class}: {mm} mm");
        assert!(rad < 0.4 * NOISE.1 * 3f64.sqrt(), "{class}: {rad} rad");
        let before = report.sharpness_before.unwrap().most_mm_rad2;
        assert!(report.sharpness_after.most_mm_rad2 < 0.2 * before);
    }
}

#[test]
fn exact_poses_come_back_with_the_harmonics_they_have() {
    let tight = Tolerance {
        mm: 1e-6,
        deg: 1e-6,
    };
    let fit = fitted(&poses(Class::R3T1, 5), tight).unwrap();
    assert_eq!(fit.report.harmonics, 3);
    assert_eq!(fit.report.class, Class::R3T1);
    assert!(!fit.report.drift_removed);
    let (mm, rad) = error(&fit, Class::R3T1);
    assert!(mm < 1e-7 && rad < 1e-8, "{mm} mm, {rad} rad");
}

#[test]
fn an_outlier_is_named_by_its_line_and_changes_nothing() {
    let clean = noisy(poses(Class::R3, 3), 3);
    let mut spoiled = clean.clone();
    spoiled[50].2.z += 4.0;
    spoiled[51].1 = UnitQuaternion::identity();
    spoiled[90].1 = UnitQuaternion::from_scaled_axis(Vector3::x() * 0.3) * spoiled[90].1;
    let fit = fitted(&spoiled, TOLERANCE).unwrap();
    let lines: Vec<u64> = fit.report.outliers.iter().map(|o| o.line).collect();
    assert_eq!(lines, [52, 53, 92]);
    let off = &fit.report.outliers;
    assert!((off[0].deviation.mm - 4.0).abs() < 0.2, "{off:?}");
    assert!((off[2].deviation.deg - 0.3f64.to_degrees()).abs() < 0.5);
    let (mm, rad) = error(&fit, Class::R3);
    assert!(mm < NOISE.0 && rad < NOISE.1, "{mm} mm, {rad} rad");
}

#[test]
fn a_table_that_does_not_quite_close_is_closed() {
    let mut drifting = poses(Class::R1T1, 5);
    for (phi, _, position) in &mut drifting {
        position.z += 0.38 * *phi / 360.0;
    }
    let measured = Measured::from_csv(&csv(&drifting), "drift.csv").unwrap();
    let fit = fit(&measured, (None, TOLERANCE), L).unwrap();
    let report = &fit.report;
    assert!((report.closing_gap.unwrap().mm - 0.38).abs() < 1e-9);
    assert!(report.drift_removed);
    assert!((report.largest.mm - 0.19).abs() < 0.01, "{report:?}");
    let rows = &fit.table.rows;
    assert_eq!(rows[0][1..4], rows[360][1..4]);
    // A closed table of so many rows is a motion, which the drifting one is not.
    let source = MotionSource::Table(fit.table.clone());
    assert!(Motion::new(Class::R1T1, &source).is_ok());
}

#[test]
fn a_corner_is_no_outlier() {
    // A rest of 60° in the middle of a stroke, entered with a corner.
    let mut corner = poses(Class::R1T1, 5);
    for (phi, _, position) in &mut corner {
        let beyond = ((*phi - 180.0).abs() - 30.0).max(0.0);
        position.z = 0.03 * beyond.min(60.0) - 1.0;
    }
    let fit = fitted(&corner, Tolerance { mm: 0.1, deg: 0.5 }).unwrap();
    assert!(fit.report.outliers.is_empty(), "{:?}", fit.report.outliers);
    assert!(fit.report.harmonics > 3);
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_mpcgear"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

const FIT: [&str; 5] = ["motion", "fit", "noisy.csv", "--tolerance", "0.2mm,0.5deg"];

#[test]
fn what_is_written_is_the_motion_that_was_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let poses = noisy(poses(Class::R3T1, 2), 1);
    fs::write(folder.path().join("noisy.csv"), csv(&poses)).unwrap();
    let output = run(folder.path(), &[&["--json"], &FIT[..]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let written = ["noisy.csv", "noisy_fitted.csv", "noisy_fitted.toml"];
    assert_eq!(names(folder.path()), written);
    assert_eq!(
        answer["files"],
        json!(["noisy_fitted.toml", "noisy_fitted.csv"])
    );
    let (file, motion) = MotionFile::read(&folder.path().join("noisy_fitted.toml")).unwrap();
    assert_eq!(file.class, Class::R3T1);
    assert_eq!(answer["class"], "3R1T");
    let expected = fitted(&poses, TOLERANCE).unwrap();
    for phi in [0.1, 2.0, 5.5] {
        assert_eq!(motion.user_pose(phi), expected.motion.user_pose(phi));
    }
    // Neither file is written over, and none is written where one is there.
    fs::remove_file(folder.path().join("noisy_fitted.toml")).unwrap();
    let again = run(folder.path(), &FIT);
    assert_eq!(again.status.code(), Some(2));
    assert_eq!(names(folder.path()), written[..2]);
}

#[test]
fn a_tolerance_that_cannot_be_met_is_refused_with_one_that_can() {
    let folder = tempfile::tempdir().unwrap();
    let text = csv(&noisy(poses(Class::R3T1, 4), 5));
    fs::write(folder.path().join("noisy.csv"), text).unwrap();
    let with = |tolerance: &str| {
        let output = run(
            folder.path(),
            &["motion", "fit", "noisy.csv", "--tolerance", tolerance],
        );
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let (code, said) = with("0.02mm,0.02deg");
    assert_eq!(code, Some(2), "{said}");
    assert_eq!(names(folder.path()), ["noisy.csv"]);
    let hint = said.split("--tolerance ").nth(1).unwrap();
    let (wider, _) = hint.split_once(' ').unwrap();
    assert!(said.contains("noisy.csv line "), "{said}");
    let (code, said) = with(wider);
    assert_eq!(code, Some(0), "{wider}: {said}");
}

#[test]
fn what_is_no_motion_of_a_gear_is_refused_by_name() {
    let measured = |poses: &[Pose]| Measured::from_csv(&csv(poses), "bad.csv");
    let refusal = |poses: &[Pose]| {
        fit(&measured(poses).unwrap(), (None, TOLERANCE), L)
            .unwrap_err()
            .to_string()
    };
    let mut still = poses(Class::R1, 5);
    for pose in &mut still {
        pose.1 = UnitQuaternion::identity();
    }
    assert!(refusal(&still).contains("net turn"), "{}", refusal(&still));
    let mut aside = poses(Class::R3, 5);
    for pose in &mut aside {
        pose.2.x += 12.0;
    }
    let said = refusal(&aside);
    assert!(said.contains("12.00 mm aside of the z axis"), "{said}");
    let said = measured(&poses(Class::R1, 5)[..50])
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("no pose between φ = 245.0° and 360.0°"),
        "{said}"
    );
    let said = measured(&poses(Class::R1, 60)).unwrap_err().to_string();
    assert!(said.contains("7 rows, allowed 8 to 20000"), "{said}");
}

#[test]
fn the_example_of_the_documentation_says_so() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/measured/wrist.csv");
    let measured = Measured::from_csv(&fs::read_to_string(folder).unwrap(), "wrist.csv").unwrap();
    let report = fit(&measured, (None, TOLERANCE), L).unwrap().report;
    assert_eq!((report.class, report.harmonics), (Class::R3T1, 3));
    assert!(report.drift_removed);
    assert_eq!(report.outliers.len(), 1);
    assert_eq!(report.outliers[0].line, 43);
    assert_eq!(report.sharpness_after.verdict(), "usually works");
}
