//! Laws of motions: exact derivatives, rows hit, smooth over the seam, closed forms.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

use std::f64::consts::TAU;
use std::path::Path;

use mpcgear::motion::{
    Class, Formula, Keyframe, Keyframes, Motion, MotionFile, MotionSource, Path as Curve, Table,
};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

/// Compares the derivatives of `motion` at `phi` with central differences of pose and twist.
fn assert_derivatives(motion: &Motion, phi: f64, tolerance: f64) {
    let h = 1e-5;
    let state = motion.state(phi);
    let (before, after) = (motion.state(phi - h), motion.state(phi + h));
    let rate = (after.pose.rotation - before.pose.rotation) / (2.0 * h);
    let skew: Matrix3<f64> = rate * state.pose.rotation.transpose();
    let omega = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
    let near = |name: &str, exact: Vector3<f64>, difference: Vector3<f64>| {
        let error = (exact - difference).norm();
        assert!(
            error < tolerance * (1.0 + exact.norm()),
            "{name} at {phi}: {exact:?} {difference:?} differ by {error:e}"
        );
    };
    let velocity = (after.pose.translation - before.pose.translation) / (2.0 * h);
    near("omega", state.omega, omega);
    near("velocity", state.velocity(state.pose.translation), velocity);
    near(
        "omega_rate",
        state.omega_rate,
        (after.omega - before.omega) / (2.0 * h),
    );
    near(
        "v_origin_rate",
        state.v_origin_rate,
        (after.v_origin - before.v_origin) / (2.0 * h),
    );
}

fn example(name: &str) -> (MotionFile, Motion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/{name}.toml"));
    MotionFile::read(&path).unwrap_or_else(|e| panic!("{e}"))
}

/// Names of all motion files in `examples/`.
fn examples() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn every_example_is_a_motion_with_exact_derivatives() {
    let names = examples();
    assert!(names.len() >= 5, "{names:?}");
    for name in names {
        let (file, motion) = example(&name);
        assert_eq!(file.name, name);
        for i in 0..50 {
            assert_derivatives(&motion, 0.13 * f64::from(i) - 0.7, 1e-6);
        }
    }
}

#[test]
fn closed_form_of_the_uniform_motion() {
    let (_, motion) = example("uniform_1r");
    for phi in [-1.0, 0.0, 2.0, 9.0] {
        let state = motion.state(phi);
        let expected = Rotation3::from_axis_angle(&Vector3::z_axis(), -phi);
        assert!((state.pose.rotation - expected.matrix()).norm() < 1e-15);
        assert_eq!(state.omega, -Vector3::z());
        assert_eq!(state.omega_rate, Vector3::zeros());
        assert_eq!(state.v_origin, Vector3::zeros());
    }
}

#[test]
fn closed_form_of_the_trefoil() {
    let (_, motion) = example("trefoil");
    let k = 10f64.to_radians().tan() / 3.0;
    for i in 0..100 {
        let phi = 0.07 * f64::from(i);
        let axis = Vector3::new(
            k * (phi.sin() + 2.0 * (2.0 * phi).sin()),
            k * (phi.cos() - 2.0 * (2.0 * phi).cos()),
            1.0,
        );
        let swing = Rotation3::rotation_between(&Vector3::z(), &axis).unwrap();
        let expected = swing * Rotation3::from_axis_angle(&Vector3::z_axis(), -phi);
        let got = motion.state(phi).pose.rotation;
        assert!((got - expected.matrix()).norm() < 1e-14, "{phi}");
        assert_eq!(motion.joint_centre(phi), Vector3::zeros());
    }
}

#[test]
fn closed_form_of_the_wobble_lift() {
    let (_, motion) = example("wobble_lift_3r1t");
    for i in 0..20 {
        let phi = 0.4 * f64::from(i);
        let tilt = motion
            .state(phi)
            .pose
            .rotation
            .column(2)
            .angle(&Vector3::z());
        assert!((tilt.to_degrees() - 5.0).abs() < 1e-9);
        assert!((motion.joint_centre(phi).z - 1.3 * phi.sin()).abs() < 1e-14);
    }
}

/// A smooth motion of class 3R1T with given tilt amplitudes (rad), and lift (mm).
fn wobble(phi: f64, tilt: [f64; 4], lift: f64) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let vector = Vector3::new(
        tilt[0] * phi.sin() + tilt[1] * (2.0 * phi).cos(),
        tilt[2] * phi.cos() + tilt[3] * (2.0 * phi).sin(),
        0.1 * phi.sin(),
    );
    let own = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -phi);
    let rotation = UnitQuaternion::from_scaled_axis(vector) * own;
    (rotation, Vector3::new(0.0, 0.0, lift * phi.cos()))
}

/// `count` rows of a motion and the first again at the end; `flip` decides on quaternion signs.
fn table(
    count: usize,
    at: impl Fn(f64) -> (UnitQuaternion<f64>, Vector3<f64>),
    flip: impl Fn(usize) -> bool,
) -> Table {
    let rows = (0..=count)
        .map(|i| {
            let phi = TAU * i as f64 / count as f64;
            let (q, p) = at(phi % TAU);
            let sign = if flip(i) { -1.0 } else { 1.0 };
            let q = [q.w, q.i, q.j, q.k].map(|c| sign * c);
            [phi.to_degrees(), p.x, p.y, p.z, q[0], q[1], q[2], q[3]]
        })
        .collect();
    Table { rows }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn tables_hit_their_rows_and_follow_the_motion(
        tilt in prop::array::uniform4(-0.12f64..0.12),
        lift in -2.0f64..2.0,
        flips in prop::collection::vec(any::<bool>(), 49),
    ) {
        let at = |phi| wobble(phi, tilt, lift);
        let source = MotionSource::Table(table(48, at, |i| flips[i]));
        let motion = Motion::new(Class::R3T1, &source).unwrap_or_else(|e| panic!("{e}"));
        for i in 0..96 {
            let phi = TAU * f64::from(i) / 96.0;
            let (q, p) = at(phi);
            let state = motion.state(phi);
            let tolerance = if i % 2 == 0 { 1e-12 } else { 1e-5 };
            let error = (state.pose.rotation - q.to_rotation_matrix().matrix()).norm();
            prop_assert!(error < tolerance, "{} at {}", error, phi);
            prop_assert!((state.pose.translation - p).norm() < tolerance);
            assert_derivatives(&motion, phi + 0.01, 1e-6);
        }
    }

    #[test]
    fn formulas_have_exact_derivatives(
        tilt in prop::array::uniform4(-0.2f64..0.2),
        lift in -2.0f64..2.0,
        phi in -7.0f64..7.0,
    ) {
        let [a, b, c, d] = tilt;
        let source = MotionSource::Formula(Formula {
            own_turn: format!("-phi + {}*tanh(sin(phi))", b.abs()),
            rotation: Some([
                format!("({a})*sin(phi) + ({b})*cos(2*phi)"),
                format!("({c})*cos(phi)^3 + ({d})*sin(2*phi)"),
                format!("({d})*exp(cos(phi))"),
            ]),
            translation: ["0".into(), "0".into(), format!("({lift})*cos(phi)")],
            ..Formula::default()
        });
        let motion = Motion::new(Class::R3T1, &source).unwrap_or_else(|e| panic!("{e}"));
        assert_derivatives(&motion, phi, 1e-6);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn keyframes_hit_their_poses(
        poses in prop::collection::vec((prop::array::uniform3(-6.0f64..6.0), -1.0f64..1.0), 5..12),
        own in prop::sample::select(vec!["-phi", "-phi + 0.2*sin(phi)"]),
    ) {
        let count = poses.len();
        let keyframes: Vec<Keyframe> = poses
            .iter()
            .enumerate()
            .map(|(i, (rotation, z))| Keyframe {
                phi_deg: 20.0 + 360.0 * i as f64 / count as f64,
                position: [0.0, 0.0, *z],
                rotation_deg: Some(*rotation),
                quaternion: None,
            })
            .collect();
        let source = MotionSource::Keyframes(Keyframes {
            own_turn: own.to_owned(),
            keyframes: keyframes.clone(),
        });
        let motion = Motion::new(Class::R3T1, &source).unwrap_or_else(|e| panic!("{e}"));
        for keyframe in keyframes {
            let phi = keyframe.phi_deg.to_radians();
            let vector = Vector3::from(keyframe.rotation_deg.unwrap()).map(f64::to_radians);
            let angle = if own == "-phi" { -phi } else { -phi + 0.2 * phi.sin() };
            let expected = Rotation3::new(vector)
                * Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
            let pose = motion.state(phi).pose;
            prop_assert!((pose.rotation - expected.matrix()).norm() < 1e-12);
            prop_assert!((pose.translation.z - keyframe.position[2]).abs() < 1e-12);
            assert_derivatives(&motion, phi + 0.1, 1e-6);
        }
    }

    #[test]
    fn paths_lead_the_axis_through_their_points(
        phase in -3.0f64..3.0,
        (a, b) in (1.0f64..6.0, 1.0f64..6.0),
    ) {
        let radius: f64 = 40.0;
        let at = |phi: f64| {
            let (x, y) = (a * phi.cos(), b * (phi + phase).sin());
            Vector3::new(x, y, (radius * radius - x * x - y * y).sqrt())
        };
        let lift = |phi: f64| phi.sin();
        for (class, radius_mm, lift_mm) in [(Class::R3, None, 0.0), (Class::R3T1, Some(40.0), 1.0)] {
            let points = (0..24).map(|i| {
                let phi = TAU * f64::from(i) / 24.0;
                let p = at(phi);
                vec![phi.to_degrees(), p.x, p.y, p.z + lift_mm * lift(phi)]
            });
            let source = MotionSource::Path(Curve {
                points: points.collect(),
                own_turn: "-phi".to_owned(),
                radius_mm,
            });
            let motion = Motion::new(class, &source).unwrap_or_else(|e| panic!("{e}"));
            for i in 0..48 {
                let phi = TAU * f64::from(i) / 48.0;
                let pose = motion.user_pose(phi);
                let tip = pose.apply(Vector3::new(0.0, 0.0, radius));
                let tolerance = if i % 2 == 0 { 1e-9 } else { 1e-4 };
                let error = (tip - at(phi) - Vector3::new(0.0, 0.0, lift_mm * lift(phi))).norm();
                prop_assert!(error < tolerance, "{class} {error:e}");
                assert_derivatives(&motion, phi + 0.05, 1e-6);
            }
        }
    }
}

#[test]
fn a_path_on_a_cylinder_turns_and_lifts() {
    let points = (0..16).map(|i| {
        let phi = TAU * f64::from(i) / 16.0;
        vec![
            phi.to_degrees(),
            9.0 * phi.cos(),
            -9.0 * phi.sin(),
            30.0 + phi.sin(),
        ]
    });
    let source = MotionSource::Path(Curve {
        points: points.collect(),
        own_turn: "-phi".to_owned(),
        radius_mm: None,
    });
    let motion = Motion::new(Class::R1T1, &source).unwrap_or_else(|e| panic!("{e}"));
    for i in 0..40 {
        let phi = 0.2 * f64::from(i);
        let state = motion.state(phi);
        assert!((state.omega + Vector3::z()).norm() < 1e-12);
        assert!((state.pose.translation.z - phi.sin()).abs() < 1e-5);
    }
}

#[test]
fn points_without_phases_are_passed_at_constant_speed() {
    let points = (0..30).map(|i| {
        let a = TAU * f64::from(i) / 30.0;
        vec![4.0 * a.cos(), 4.0 * a.sin(), 30.0]
    });
    let source = MotionSource::Path(Curve {
        points: points.collect(),
        own_turn: "-phi".to_owned(),
        radius_mm: None,
    });
    let motion = Motion::new(Class::R3, &source).unwrap_or_else(|e| panic!("{e}"));
    let axis = motion.state(1.0).pose.rotation.column(2).into_owned();
    let expected = Vector3::new(4.0 * 1f64.cos(), 4.0 * 1f64.sin(), 30.0).normalize();
    assert!((axis - expected).norm() < 1e-6);
}

/// A body frame whose hub axis is its x axis: the hub is found, and the user's poses come back.
#[test]
fn a_turned_body_frame_is_aligned_with_the_hub() {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 1.4);
    let at = |phi| {
        let (q, _) = wobble(phi, [0.1, 0.05, -0.1, 0.08], 0.0);
        (q * turned, Vector3::zeros())
    };
    let motion = Motion::new(Class::R3, &MotionSource::Table(table(48, at, |_| false)))
        .unwrap_or_else(|e| panic!("{e}"));
    for i in 0..48 {
        let phi = TAU * f64::from(i) / 48.0;
        let tilt = motion.state(phi).pose.rotation[(2, 2)].acos();
        assert!(tilt < 0.3, "{tilt}");
        let error = motion.user_pose(phi).rotation - at(phi).0.to_rotation_matrix().matrix();
        assert!(error.norm() < 1e-12, "{}", error.norm());
        assert_derivatives(&motion, phi + 0.03, 1e-6);
    }
}

#[test]
fn splines_are_smooth_over_the_seam() {
    let at = |phi| wobble(phi, [0.1, 0.05, -0.1, 0.08], 1.0);
    let motion = Motion::new(Class::R3T1, &MotionSource::Table(table(12, at, |_| false))).unwrap();
    for seam in [0.0, TAU, TAU / 12.0] {
        let (a, b) = (motion.state(seam - 1e-9), motion.state(seam + 1e-9));
        assert!((a.pose.rotation - b.pose.rotation).norm() < 1e-8);
        assert!((a.omega - b.omega).norm() < 1e-7);
        assert!((a.omega_rate - b.omega_rate).norm() < 1e-7);
        assert!((a.v_origin_rate - b.v_origin_rate).norm() < 1e-6);
    }
}

#[test]
fn a_zero_rotation_vector_is_no_singularity() {
    let source = MotionSource::Formula(Formula {
        rotation: Some(["0.2*sin(phi)".into(), "0.1*sin(phi)".into(), "0".into()]),
        ..Formula::default()
    });
    let motion = Motion::new(Class::R3, &source).unwrap();
    for phi in [0.0, 1e-9, 0.02, 0.0447, 0.0448, std::f64::consts::PI] {
        assert_derivatives(&motion, phi, 1e-7);
    }
}

#[test]
fn sources_survive_json() {
    let at = |phi| wobble(phi, [0.1, 0.05, -0.1, 0.08], 1.0);
    for source in [
        MotionSource::Table(table(9, at, |i| i % 2 == 0)),
        MotionSource::Formula(Formula::default()),
        example("pick_and_place_3r").0.source,
        example("polisher_path_3r").0.source,
    ] {
        let text = serde_json::to_string(&source).unwrap();
        assert_eq!(serde_json::from_str::<MotionSource>(&text).unwrap(), source);
    }
}
