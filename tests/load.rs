//! Load figures against closed forms and laws of mechanics.

mod known;

use approx::assert_relative_eq;
use known::{Helical, PITCH, design, involute, motion, revolute, spherical};
use mpcgear::closure;
use mpcgear::design::{Design, Gear};
use mpcgear::load::contacts::Configuration;
use mpcgear::load::hertz::{effective_modulus, patch};
use mpcgear::load::{
    ExtraLoad, Load, Material, PayloadLimit, Sampling, analyse, analyse_rigid, sensitivity,
};
use mpcgear::motion::{Class, Motion};
use mpcgear::strength::Teeth;
use nalgebra::Vector3;

fn torque_load(torque: f64) -> Load {
    Load {
        mass_g: 0.0,
        extra: vec![ExtraLoad {
            torque_nmm: [0.0, 0.0, torque],
            ..ExtraLoad::default()
        }],
        ..Load::default()
    }
}

fn sampling(count: usize) -> Sampling {
    Sampling {
        count,
        ..Sampling::default()
    }
}

/// A payload off the axis, pulled by gravity and a varying force and torque.
fn busy_load() -> Load {
    let row = |phi_deg: f64, s: f64| ExtraLoad {
        phi_deg,
        force_n: [s, 2.0 - s, 0.5 * s],
        torque_nmm: [30.0 * s, -10.0, 20.0 - 15.0 * s],
    };
    Load {
        mass_g: 250.0,
        point_mm: [8.0, -5.0, 40.0],
        gravity: [0.3, 0.2, -1.0],
        extra: vec![row(20.0, -1.0), row(140.0, 2.0), row(300.0, 0.5)],
        ..Load::default()
    }
}

fn helical(side: f64, z0: f64) -> Helical {
    Helical {
        alpha: 0.45,
        side,
        z0,
        travel: 14.0,
    }
}

/// Two helical bands of opposite side on parallel shafts, and their motion.
fn helical_pair() -> (Design, Motion) {
    let m = motion(Class::R1);
    let bands = vec![helical(1.0, 10.0).band(&m), helical(-1.0, 26.0).band(&m)];
    (design(Class::R1, bands), m)
}

#[test]
fn helical_gears_on_parallel_shafts_have_textbook_forces() {
    let (pair, m) = helical_pair();
    let torque = 750.0;
    let report = analyse(&pair, &m, &torque_load(torque), sampling(97)).unwrap();
    let helix = (PITCH / helical(1.0, 0.0).axial_speed()).atan();
    let tangential = torque / PITCH;
    for s in &report.samples {
        let (loaded, idle) = (&s.contacts[0], &s.contacts[1]);
        let force = Vector3::from(loaded.n) * loaded.force;
        assert_relative_eq!(force.y, tangential, max_relative = 1e-6);
        assert_relative_eq!(
            force.x,
            tangential * 0.45f64.tan() / helix.cos(),
            max_relative = 1e-6
        );
        assert_relative_eq!(force.z, tangential * helix.tan(), max_relative = 1e-6);
        assert_relative_eq!(s.torque, torque, max_relative = 1e-6);
        assert!(idle.force.abs() < 1e-9, "the other flank is not pressed");
        // The teeth roll: friction takes nothing.
        assert_relative_eq!(s.torque_with_friction.unwrap(), torque, max_relative = 1e-4);
    }
}

#[test]
fn involute_gears_lose_to_friction_what_the_textbook_says() {
    let m = motion(Class::R1);
    let alpha = 20f64.to_radians();
    let pair = design(
        Class::R1,
        vec![
            involute(&m, alpha, (1.0, 5.0)),
            involute(&m, alpha, (-1.0, 9.0)),
        ],
    );
    let load = Load {
        friction: 0.15,
        ..torque_load(400.0)
    };
    let base = PITCH * alpha.cos();
    for degrees in [20.0, 25.0, 30.0f64] {
        let one = Sampling {
            start: degrees.to_radians(),
            end: degrees.to_radians() + 0.01,
            count: 1,
        };
        let report = analyse(&pair, &m, &load, one).unwrap();
        // Beyond the pitch point the driver's lever of friction is the longer one.
        let s = base * (degrees - 18.0).to_radians();
        let (driver, follower) = (PITCH * alpha.sin() + s, PITCH * alpha.sin() - s);
        let expected = (base + 0.15 * follower) / (base + 0.15 * driver);
        assert_relative_eq!(report.efficiency.unwrap(), expected, max_relative = 1e-6);
        assert!(expected < 1.0);
    }
}

#[test]
fn forces_balance_and_agree_with_virtual_work() {
    for (class, pair) in [(Class::R1, revolute()), (Class::R3, spherical())] {
        let m = motion(class);
        let report = analyse(&pair, &m, &busy_load(), sampling(180)).unwrap();
        assert!(
            report.equilibrium_error_max <= 1e-9,
            "{}",
            report.equilibrium_error_max
        );
        assert!(
            report.virtual_work_error_max <= 1e-6,
            "{}",
            report.virtual_work_error_max
        );
        assert!(report.force_max > 0.1 && report.torque_max > 1.0);
        assert!(
            report
                .samples
                .iter()
                .flat_map(|s| &s.contacts)
                .all(|c| c.force >= 0.0)
        );
    }
}

#[test]
fn no_other_balance_has_a_smaller_largest_force() {
    // With K = N+1 every balance is f + s·g with g > 0 the internal forces: at the optimum one is zero.
    let report = analyse(&spherical(), &motion(Class::R3), &busy_load(), sampling(60)).unwrap();
    for s in &report.samples {
        let least = s
            .contacts
            .iter()
            .map(|c| c.force)
            .fold(f64::INFINITY, f64::min);
        assert!(least.abs() < 1e-9, "φ = {}: {least}", s.phi);
    }
}

#[test]
fn largest_payload_loads_one_contact_to_the_limit() {
    let (pair, m) = (spherical(), motion(Class::R3));
    let load = Load {
        mass_g: 1000.0,
        point_mm: [20.0, 0.0, 30.0],
        force_limit_n: 0.5,
        driver_material: Material::Steel,
        follower_material: Material::Steel,
        ..Load::default()
    };
    let report = analyse(&pair, &m, &load, sampling(72)).unwrap();
    assert_eq!(report.payload_limit, Some(PayloadLimit::Force));
    let again = Load {
        mass_g: 1000.0 * report.payload_max,
        ..load
    };
    let limit = analyse(&pair, &m, &again, sampling(72)).unwrap();
    assert_relative_eq!(limit.force_max, 0.5, max_relative = 1e-5);
}

#[test]
fn largest_payload_presses_one_contact_as_hard_as_its_material_bears() {
    let (pair, m) = (spherical(), motion(Class::R3));
    let load = Load {
        mass_g: 1000.0,
        point_mm: [20.0, 0.0, 30.0],
        force_limit_n: 1e6,
        driver_material: Material::Steel,
        ..Load::default()
    };
    let report = analyse(&pair, &m, &load, sampling(72)).unwrap();
    assert_eq!(report.payload_limit, Some(PayloadLimit::Pressure));
    // The weaker material decides.
    assert_eq!(report.pressure_allowed, Material::Pla.allowed_pressure());
    let again = Load {
        mass_g: 1000.0 * load.safety * report.payload_max,
        ..load
    };
    let limit = analyse(&pair, &m, &again, sampling(72)).unwrap();
    let pressure = limit.pressure_max.expect("point contacts");
    assert_relative_eq!(pressure, report.pressure_allowed, max_relative = 1e-5);
}

#[test]
fn largest_payload_brings_one_root_to_the_strength_of_its_material() {
    let (mut pair, m) = (spherical(), motion(Class::R3));
    for band in &mut pair.sub_gear_pairs {
        band.flank_radius = Some(1.5);
    }
    // Thin walls: roots decide.
    pair.section.rib = 0.8;
    let load = Load {
        mass_g: 1000.0,
        point_mm: [20.0, 0.0, 30.0],
        force_limit_n: 1e6,
        driver_material: Material::Pa12,
        follower_material: Material::Pa12,
        ..Load::default()
    };
    let report = analyse(&pair, &m, &load, sampling(72)).unwrap();
    assert_eq!(report.payload_limit, Some(PayloadLimit::RootStress));
    let rigid = analyse_rigid(&pair, &m, &load, sampling(72)).unwrap();
    assert!(report.payload_max < rigid.payload_max);
    let again = Load {
        mass_g: 1000.0 * load.safety * report.payload_max,
        ..load
    };
    let limit = analyse(&pair, &m, &again, sampling(72)).unwrap();
    let strength = Material::Pa12.yield_strength();
    assert_eq!(report.root_stress_allowed_mpa, strength);
    let stress = limit.root_stress_max_mpa.expect("elements");
    assert_relative_eq!(stress, strength, max_relative = 1e-5);
    // The tooth that is named is the one that carries it.
    let named = report.payload_tooth.expect("a tooth");
    let contacts = limit.samples.iter().map(|s| &s.contacts[named.pair]);
    let of_named = contacts.filter(|c| c.tooth == named.tooth).map(|c| {
        let [driver, follower] = c.root_stress.expect("elements");
        match named.gear.expect("one gear") {
            Gear::Driver => driver,
            Gear::Follower => follower,
        }
    });
    assert_relative_eq!(of_named.fold(0.0, f64::max), strength, max_relative = 1e-5);
}

#[test]
fn teeth_and_contact_are_springs_one_behind_the_other() {
    let (pair, m) = helical_pair();
    let load = Load {
        mass_g: 300.0,
        point_mm: [20.0, 0.0, 10.0],
        gravity: [1.0, 0.5, 0.0],
        follower_material: Material::Petg,
        ..Load::default()
    };
    let weight = 0.3 * mpcgear::load::wrench::GRAVITY;
    let teeth = Teeth::of(&pair, [Material::Pla, Material::Petg]).expect("elements");
    let elastic = analyse(&pair, &m, &load, sampling(7)).unwrap();
    let rigid = analyse_rigid(&pair, &m, &load, sampling(7)).unwrap();
    for (with, without) in elastic.samples.iter().zip(&rigid.samples) {
        let at = Configuration::at(&pair, &m, with.phi).unwrap();
        let bent = with
            .contacts
            .iter()
            .zip(&at.contacts)
            .map(|(load, contact)| {
                let both = teeth.tooth(contact.pair, contact.tooth);
                let compliance: f64 = both.iter().map(|t| t.at(contact.share).compliance).sum();
                load.force * load.force * compliance / weight
            });
        let added = with.deflection.expect("weight") - without.deflection.expect("weight");
        assert_relative_eq!(added, bent.sum::<f64>(), max_relative = 1e-9);
    }
    let (softest, gear, [k, j]) = teeth.softest().expect("teeth");
    assert_eq!(elastic.tooth_stiffness_min_n_per_mm, Some(softest));
    let of_softest = &teeth.tooth(k, j)[usize::from(gear == Gear::Follower)];
    let compliances = of_softest.responses.iter().map(|r| r.compliance);
    assert_relative_eq!(
        compliances.fold(0.0, f64::max),
        1.0 / softest,
        max_relative = 1e-12
    );
}

#[test]
fn weight_along_a_revolute_axis_needs_no_force() {
    let report = analyse(
        &revolute(),
        &motion(Class::R1),
        &Load::default(),
        sampling(36),
    )
    .unwrap();
    assert!(report.force_max < 1e-9 && report.torque_max < 1e-9);
    assert_eq!(report.payload_max, f64::INFINITY);
}

#[test]
fn open_contacts_are_refused() {
    let m = motion(Class::R1);
    let one = Helical {
        alpha: 0.5,
        side: 1.0,
        z0: 10.0,
        travel: 12.0,
    };
    let pair = design(Class::R1, vec![one.band(&m)]);
    let error = analyse(&pair, &m, &torque_load(-100.0), sampling(4)).unwrap_err();
    assert!(
        error.to_string().contains("cannot hold the load"),
        "{error}"
    );
    let hopeless = Load {
        gravity: [0.0; 3],
        force_limit_n: f64::NAN,
        ..Load::default()
    };
    let error = analyse(&pair, &m, &hopeless, sampling(4))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("load.gravity") && error.contains("load.force_limit_n"),
        "{error}"
    );
}

/// Law of contact kinematics (Montana): the curvatures of both flanks decide how the contact point
/// moves on the follower, (K₁ + K₂)·T² = −K₁·v_rel − n × ω_rel in the tangent plane.
#[test]
fn curvatures_explain_how_the_contact_moves() {
    let m = motion(Class::R1);
    let rolling = revolute();
    let alpha = 20f64.to_radians();
    let sliding = design(
        Class::R1,
        vec![
            involute(&m, alpha, (1.0, 5.0)),
            involute(&m, alpha, (-1.0, 9.0)),
        ],
    );
    for pair in [rolling, sliding] {
        for phi in [0.05, 0.31, 0.4, 0.62, 3.0] {
            let at = Configuration::at(&pair, &m, phi).unwrap();
            let h = 1e-4;
            let [before, after] = [-h, h].map(|h| Configuration::at(&pair, &m, phi + h).unwrap());
            for (k, c) in at.contacts.iter().enumerate() {
                let speed = (after.contacts[k].p - before.contacts[k].p) / (2.0 * h);
                let (v, omega) = (at.sliding(c.p), at.follower.omega - at.driver.omega);
                let flat = |v: Vector3<f64>| {
                    nalgebra::Vector2::new(v.dot(&c.tangents[0]), v.dot(&c.tangents[1]))
                };
                let t2 = flat(speed - at.follower.velocity(c.p));
                let left = (c.driver_curvature + c.follower_curvature) * t2;
                let right = -(c.driver_curvature * flat(v)) - flat(c.n.cross(&omega));
                assert!(
                    (left - right).norm() < 1e-4 * right.norm().max(1.0),
                    "φ {phi}, k {k}: {left} {right}"
                );
            }
        }
    }
}

#[test]
fn hertz_agrees_with_closed_forms() {
    // Two spheres: p₀ = (6 F E*² / (π³ R²))^⅓.
    let (force, modulus, radius) = (12.0f64, 1900.0f64, 0.7f64);
    let round = patch([1.0 / radius; 2], force, modulus).unwrap();
    let pi = std::f64::consts::PI;
    let expected = (6.0 * force * modulus.powi(2) / (pi.powi(3) * radius.powi(2))).cbrt();
    assert_relative_eq!(round.pressure, expected, max_relative = 1e-6);
    assert_relative_eq!(round.a, round.b, max_relative = 1e-5);
    assert_relative_eq!(
        round.approach,
        round.a * round.a / radius,
        max_relative = 1e-5
    );

    // Nearly a line: the patch approaches p₀ = √(w E* / (π R)) with the peak line load w of an
    // elliptic patch, w = 3F/(4a).
    let long = patch([1e-6, 1.0 / radius], force, modulus).unwrap();
    let line = (3.0 * force / (4.0 * long.a) * modulus / (pi * radius)).sqrt();
    assert_relative_eq!(long.pressure, line, max_relative = 2e-3);

    // A flatter contact bears less pressure; conforming or crossing flanks are not a point contact.
    assert!(
        patch([0.2, 1.0], force, modulus).unwrap().pressure
            < patch([1.0, 1.0], force, modulus).unwrap().pressure
    );
    assert_eq!(patch([-0.1, 1.0], force, modulus), None);
    let steel = effective_modulus(Material::Steel, Material::Steel);
    assert_relative_eq!(
        steel,
        210_000.0 / (2.0 * (1.0 - 0.09)),
        max_relative = 1e-12
    );
}

#[test]
fn play_of_a_revolute_pair_is_the_gap_over_the_lever() {
    let pair = revolute();
    let report = analyse(&pair, &motion(Class::R1), &torque_load(10.0), sampling(36)).unwrap();
    let lever = PITCH
        * Helical {
            alpha: 0.5,
            side: 1.0,
            z0: 0.0,
            travel: 12.0,
        }
        .normal()
        .y;
    for s in &report.samples {
        assert_relative_eq!(
            s.play_turn,
            pair.section.clearance / lever,
            max_relative = 1e-6
        );
    }
}

#[test]
fn play_is_at_least_gap_over_q_in_three_dimensions() {
    let pair = spherical();
    let report = analyse(&pair, &motion(Class::R3), &busy_load(), sampling(36)).unwrap();
    for (s, c) in report.samples.iter().zip(pair.closure.iter().step_by(10)) {
        assert!(
            s.play_turn >= pair.section.clearance / c.q * (1.0 - 1e-6),
            "φ {}",
            s.phi
        );
        assert!(s.sag <= s.play_point * (1.0 + 1e-9));
    }
}

#[test]
fn a_larger_centre_distance_turns_the_follower_by_backlash() {
    // Both flanks of a revolute pair lose contact alike: the follower stays, the gap opens.
    let load = Load {
        axis_tilt_error_deg: 0.0,
        scale_error_percent: 0.0,
        ..torque_load(10.0)
    };
    let pair = revolute();
    let s = sensitivity::sensitivity(&pair, &motion(Class::R1), &load, sampling(20)).unwrap();
    assert!(s.by_sampling.turn < 1e-9 && s.by_derivative.turn < 1e-9);
    assert_relative_eq!(
        s.by_sampling.interference,
        0.1 * 0.5f64.sin(),
        max_relative = 1e-6
    );
    assert_relative_eq!(
        s.by_derivative.interference,
        0.1 * 0.5f64.sin(),
        max_relative = 1e-6
    );
}

#[test]
fn sensitivity_is_bounded_by_its_derivatives_for_small_errors() {
    let small = Load {
        center_distance_error_mm: 0.01,
        axis_tilt_error_deg: 0.02,
        scale_error_percent: 0.02,
        ..busy_load()
    };
    let pair = spherical();
    let s = sensitivity::sensitivity(&pair, &motion(Class::R3), &small, sampling(20)).unwrap();
    let q = pair
        .closure
        .iter()
        .map(|c| c.q)
        .fold(f64::INFINITY, f64::min);
    assert_relative_eq!(s.q_min, q, max_relative = 1e-3);
    let (d, r) = (s.by_derivative, s.by_sampling);
    assert!(
        r.q_min < s.q_min && r.q_min >= d.q_min - 0.01 * s.q_min,
        "{s:?}"
    );
    assert!(r.point > 0.0 && r.point <= d.point * 1.05, "{s:?}");
    assert!(r.turn > 0.0 && r.turn <= d.turn * 1.05, "{s:?}");
}

#[test]
fn synthetic_designs_are_form_closed() {
    for pair in [revolute(), spherical()] {
        assert!(pair.closure.iter().all(|c| c.q > 1.0), "{}", pair.name);
        assert_eq!(closure::measure(&[[0.0; 4]; 2], 1), 0.0);
    }
}

#[test]
fn at_a_hand_over_the_next_tooth_counts() {
    let pair = revolute();
    for j in 0..known::J {
        let phi = j as f64 * std::f64::consts::TAU / known::J as f64;
        for (offset, tooth) in [(0.0, j), (1e-6, j), (-1e-6, (j + known::J - 1) % known::J)] {
            let at = Configuration::at(&pair, &motion(Class::R1), phi + offset).unwrap();
            assert_eq!(at.contacts[0].tooth, tooth, "φ = {phi} + {offset}");
        }
    }
}

#[test]
fn the_table_over_the_angle_says_what_the_samples_say() {
    let design = revolute();
    let report = analyse(
        &design,
        &motion(Class::R1),
        &torque_load(300.0),
        sampling(24),
    )
    .expect("held");
    let table = report.table(1);
    assert_eq!(table.rows.len(), 24);
    let column = |name: &str| {
        let index = table.columns.iter().position(|c| c == name);
        index.unwrap_or_else(|| panic!("{name} among {:?}", table.columns))
    };
    for (row, sample) in table.rows.iter().zip(&report.samples) {
        let number = |name: &str| row[column(name)].parse::<f64>().expect("a number");
        assert!((number("phi deg") - sample.phi.to_degrees()).abs() < 0.06);
        assert!((number("force2 N") - sample.contacts[1].force).abs() < 6e-4);
        assert!((number("torque Nmm") - sample.torque).abs() < 6e-3);
        assert!((number("play mm") - sample.play_point).abs() < 6e-4);
    }
    // Weight along the axis loads nothing: unlimited, and an empty cell to a spreadsheet.
    assert_eq!(table.rows[0][column("payload g")], "–");
    let csv = table.render(mpcgear::table::Format::Csv).expect("csv");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let first = reader.records().next().expect("a row").expect("csv");
    assert_eq!(&first[column("payload g")], "");
    assert_eq!(table.records()[0]["payload g"], serde_json::Value::Null);
    assert_eq!(report.table(6).rows.len(), 4);
}

#[test]
fn gears_made_within_the_tolerances_work_until_these_are_as_large_as_the_gap() {
    use mpcgear::load::tolerances::{Draws, spread};
    let (pair, m) = helical_pair();
    let with = |factor: f64, seed: u64| {
        let load = Load {
            center_distance_error_mm: 0.1 * factor,
            axis_tilt_error_deg: 0.2 * factor,
            scale_error_percent: 0.2 * factor,
            ..Load::default()
        };
        spread(&pair, &m, &load, Draws { count: 200, seed }).expect("closed")
    };
    let (small, large) = (with(0.1, 1), with(20.0, 1));
    assert_eq!(small, with(0.1, 1));
    assert_ne!(small, with(0.1, 2));
    assert!(small.works == 1.0 && small.jams == 0.0, "{small:?}");
    assert!(large.works < 0.2 && large.jams > 0.3, "{large:?}");
    let (narrow, wide) = (small.q_min.expect("Q"), large.q_min.expect("Q"));
    assert!(narrow.p5 <= narrow.p50 && narrow.p50 <= narrow.p95);
    assert!(wide.p95 - wide.p5 > 5.0 * (narrow.p95 - narrow.p5));
    // Without errors of place, play is what the gap leaves.
    let play = analyse(&pair, &m, &Load::default(), sampling(36))
        .expect("closed")
        .play_turn_max;
    let spread = small.play_deg.expect("free");
    assert!(spread.p5 < play.to_degrees() && play.to_degrees() < spread.p95);
}

#[test]
fn contacts_flatten_with_the_cube_root_of_the_square_of_the_load() {
    let (pair, m) = helical_pair();
    let with = |mass_g: f64| {
        let load = Load {
            mass_g,
            point_mm: [20.0, 0.0, 10.0],
            gravity: [1.0, 0.5, 0.0],
            ..Load::default()
        };
        let report = analyse_rigid(&pair, &m, &load, sampling(7)).expect("closed");
        report
            .samples
            .into_iter()
            .map(|s| s.deflection)
            .collect::<Vec<_>>()
    };
    assert!(with(0.0).iter().all(Option::is_none));
    for (one, eight) in with(100.0).into_iter().zip(with(800.0)) {
        let (one, eight) = (one.expect("weight"), eight.expect("weight"));
        assert!(one > 0.0);
        assert_relative_eq!(eight / one, 4.0, max_relative = 1e-6);
    }
}
