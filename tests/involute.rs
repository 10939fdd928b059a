//! The standard pair of spur gears: textbook values, closed forms, and gears that turn in each other.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

mod synthetic;

use std::f64::consts::PI;

use mpcgear::export::{reference, stl};

use mpcgear::involute::strength::{form_factor, loss_factor, stress};
use mpcgear::involute::{PRESSURE_ANGLE, Pair, body, least_shift, profile, shift_sum};
use mpcgear::load::Material;
use mpcgear::motion::{Class, Pose};
use mpcgear::solid::kernel::Solid;
use nalgebra::{Rotation3, Vector3};

/// A pair without profile shift of module 1.
fn plain(teeth: [usize; 2]) -> Pair {
    let distance = (teeth[0] + teeth[1]) as f64 / 2.0;
    Pair::new((1.0, distance), teeth.map(|z| (z, 0.0)), (10.0, 0.0))
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() < within, "{a} is not {b}");
}

#[test]
fn contact_ratios_are_those_of_textbooks() {
    near(plain([20, 20]).contact_ratio(), 1.557, 1e-3);
    near(plain([20, 40]).contact_ratio(), 1.635, 1e-3);
    // Of two racks: 4 / (π sin 2α).
    let racks = 4.0 / (PI * (2.0 * PRESSURE_ANGLE).sin());
    near(plain([100_000, 100_000]).contact_ratio(), racks, 1e-3);
    near(racks, 1.981, 1e-3);
}

#[test]
fn shift_and_undercut_follow_their_formulas() {
    near(least_shift(17), 0.006, 1e-3);
    near(shift_sum(2.0, 40.0, [20, 20]).unwrap(), 0.0, 1e-9);
    // Working angle 22.44° at a tenth of a module more on 20 and 20 teeth and x₁ + x₂ from inv 22.44°.
    let sum = shift_sum(1.0, 20.35, [20, 20]).unwrap();
    let angle = (20.0 * PRESSURE_ANGLE.cos() / 20.35f64).acos();
    let inv = |a: f64| a.tan() - a;
    near(
        2.0 * sum * PRESSURE_ANGLE.tan() / 40.0,
        inv(angle) - inv(PRESSURE_ANGLE),
        1e-12,
    );
    assert!(shift_sum(1.0, 19.9, [20, 20]).is_none());
}

#[test]
fn normals_of_the_flank_touch_the_base_circle_and_are_a_base_pitch_apart() {
    let pair = Pair::standard(25.0, 1, (10.0, 0.0)).unwrap();
    let flank = profile::flank(&pair, 0);
    let base = pair.base_radius(0);
    let involute = &flank[10..];
    for w in involute.windows(3).skip(1) {
        let tangent = (w[2] - w[0]).normalize();
        // The normal's distance from the axis.
        near(w[1].dot(&tangent).abs(), base, 2e-3 * base);
    }
    let outermost = flank.last().unwrap();
    near(outermost.norm(), pair.wheels[0].tip_radius, 1e-9);
    // Fillet and involute meet without a step or a corner.
    let [a, b, c, d] = [8, 9, 10, 11].map(|i| flank[i]);
    assert!((c - b).norm() < 3.0 * (b - a).norm());
    assert!((c - b).angle(&(d - c)) < 0.25);
    near(
        pair.base_pitch(),
        2.0 * PI * base / pair.wheels[0].teeth as f64,
        1e-9,
    );
}

#[test]
fn the_form_factor_is_in_the_chart_of_the_norm() {
    // DIN 3990-3: Y_Fa of 20 teeth about 2.9, of 100 about 2.2 (profile with ρ = 0.38 m a little less).
    let pair = plain([20, 100]);
    let (small, large) = (form_factor(&pair, 0), form_factor(&pair, 1));
    assert!((2.7..3.0).contains(&small), "{small}");
    assert!((2.1..2.35).contains(&large), "{large}");
    let shifted = Pair::new((1.0, 20.47), [(20, 0.25), (20, 0.25)], (10.0, 0.0));
    assert!(form_factor(&shifted, 0) < small);
}

#[test]
fn pressure_is_that_of_two_cylinders_and_losses_those_of_the_formula() {
    let pair = plain([20, 20]);
    let steel = [Material::Steel; 2];
    let found = stress(&pair, 1000.0, steel, 0.1);
    near(found.force, 1000.0 / (10.0 * PRESSURE_ANGLE.cos()), 1e-9);
    // 0.418 √(F E / (b R)) for equal steels.
    let radius = 0.5 * 10.0 * PRESSURE_ANGLE.sin();
    let hertz = 0.418 * (found.force * 210_000.0 / (10.0 * radius)).sqrt();
    near(found.pressure, hertz, 1e-3 * hertz);
    // Twice the torque: √2 of the pressure, twice the root stress.
    let twice = stress(&pair, 2000.0, steel, 0.1);
    near(twice.pressure, 2f64.sqrt() * found.pressure, 1e-9 * hertz);
    near(twice.root, 2.0 * found.root, 1e-9);
    let e = pair.contact_ratio() / 2.0;
    near(
        loss_factor(&pair),
        PI / 10.0 * (1.0 - 2.0 * e + 2.0 * e * e),
        1e-12,
    );
    near(found.efficiency, 1.0 - 0.1 * loss_factor(&pair), 1e-12);
}

fn turned(pair: &Pair, i: usize, angle: f64) -> Solid {
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner();
    let axis = [-pair.center_distance, 0.0][i] * Vector3::x();
    let pose = Pose {
        rotation,
        translation: axis - rotation * axis,
    };
    Solid::new(&body::mesh(pair, i).moved(&pose), "gear").unwrap()
}

#[test]
fn the_gears_turn_in_each_other_with_the_backlash_between_them() {
    let backlash = 0.12;
    for (distance, copies) in [(25.0, 1), (36.0, 2)] {
        let pair = Pair::standard(distance, copies, (2.0, backlash)).unwrap();
        assert!(pair.contact_ratio() >= 1.2);
        let shared = |angle: f64, aside: f64| {
            let driver = turned(&pair, 0, angle);
            let follower = turned(&pair, 1, -angle * copies as f64 + aside);
            driver.intersection(&follower).volume()
        };
        let play = 0.5 * backlash / pair.base_radius(1);
        for angle in [0.0, 0.05, 0.11, 0.2] {
            near(shared(angle, 0.0), 0.0, 1e-6);
            for side in [-1.0, 1.0] {
                near(shared(angle, 0.8 * side * play), 0.0, 2e-3);
                assert!(shared(angle, 1.4 * side * play) > 5e-3, "{angle} {side}");
            }
        }
    }
}

#[test]
fn a_hundred_sizes_have_a_standard_pair() {
    for i in 0..100 {
        let distance = 12.0 + 1.7 * f64::from(i);
        for copies in [1, 2, 3] {
            let pair = Pair::standard(distance, copies, (10.0, 0.1)).unwrap();
            let sum: f64 = (0..2).map(|k| pair.pitch_radius(k)).sum();
            near(sum, distance, 1e-9);
        }
    }
}

#[test]
fn a_design_at_a_constant_ratio_is_compared_and_others_are_refused() {
    let (design, motion) = synthetic::uniform(Class::R1);
    let found = reference::of(&design, &motion).unwrap();
    near(found.pair.center_distance, 25.0, 1e-9);
    near(found.pair.face_width, found.own.height, 1e-9);
    // Both hold the same torque: no contact of ours has a longer arm than L/2.
    assert!(found.own.force >= reference::TORQUE / 12.5);
    let table = reference::table("gear", &found);
    let [csv, driver, follower] = reference::files(&found.pair, &table).unwrap();
    assert!(csv.bytes.starts_with(b"figure,gear,involute"));
    for (file, i) in [(driver, 0), (follower, 1)] {
        let mesh = stl::parse(file.bytes, &file.path).unwrap();
        let volume = body::mesh(&found.pair, i).volume();
        near(mesh.volume(), volume, 1e-4 * volume);
    }
    let (design, motion) = synthetic::example("quick_return_1r");
    let said = reference::of(&design, &motion).unwrap_err().to_string();
    assert!(said.contains("leads or lags by up to"), "{said}");
}
