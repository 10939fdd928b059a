//! Every option of the scripts that the embedded kernel does not know, one by one: it changes what it
//! names as much as it should, and only that. The judge is arithmetic.

mod openscad_bench;
mod openscad_run;
mod synthetic;

use std::f64::consts::PI;

use mpcgear::motion::Class;
use openscad_bench::{Bench, Values, box_change, close, disc};
use openscad_run::{Run, installed, manifold};

#[test]
fn spokes_taper_have_fillets_and_webs() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3T1, "spokes");
    for gear in ["driver", "follower"] {
        let plain = bench.volume(gear, &[]);
        let tapered = bench.volume(gear, &[("spokes", "\"tapered\"")]);
        assert!(tapered > plain + 0.2, "{gear}: {tapered} after {plain}");
        let slim: Values = &[("spokes", "\"tapered\""), ("rib_foot_thickness", "1.5")];
        let slim = bench.volume(gear, slim);
        assert!(plain < slim && slim < tapered, "{gear}: {slim}");
        let fillet = bench.volume(gear, &[("rib_fillet", "0.2")]);
        assert!(fillet > plain + 0.1, "{gear}: {fillet} after {plain}");

        // A disc per sub-gear pair around a smaller hub, less what ribs and teeth fill already.
        let hub = format!("{gear}_hub_radius");
        let web = format!("{gear}_web_radius");
        let range = bench
            .design
            .recipe
            .parameters
            .iter()
            .find(|p| p.name == hub);
        let range = range.expect("a hub");
        let (inner, outer) = (range.min, range.min + 0.6 * (range.max - range.min));
        let (small, large) = (inner.to_string(), outer.to_string());
        let values = [
            (hub.as_str(), small.as_str()),
            ("spokes", "\"webbed\""),
            (web.as_str(), large.as_str()),
            ("spoke_web_thickness", "2"),
        ];
        let bare = bench.volume(gear, &values[..1]);
        let webbed = bench.volume(gear, &values);
        let bands = bench.design.sub_gear_pairs.len() as f64;
        let full = bands * 2.0 * PI * (outer * outer - inner * inner);
        let share = (webbed - bare) / full;
        assert!((0.75..1.0).contains(&share), "{gear}: {share} of the discs");
        let said = bench.refusal(gear, &[("spokes", "\"webbed\"")]);
        assert!(said.contains(&hub) && said.contains(&web), "{said}");
    }
}

#[test]
fn bores_of_the_driver_are_as_large_as_they_say() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "bores");
    let plain = bench.volume("driver", &[]);
    let removed = |values: Values| plain - bench.volume("driver", values);
    // Bore 3 mm, 0.1 mm of gap all around, 10 mm deep.
    let (radius, depth) = (1.6, 10.0);
    let round = depth * disc(radius);
    close(removed(&[("bore", "\"round\"")]), round, 0.2, "round");
    let d_shape = |radius: f64, flat: f64| {
        let angle = ((radius - flat) / radius).acos();
        let segment = radius * radius * (angle - angle.sin() * angle.cos());
        depth * (disc(radius) - segment)
    };
    let d = d_shape(radius, 0.5);
    close(removed(&[("bore", "\"d_shape\"")]), d, 0.6, "D");
    let hexagon = depth * 2.0 * 3f64.sqrt() * radius * radius;
    close(removed(&[("bore", "\"hexagon\"")]), hexagon, 0.2, "hexagon");
    let teeth = 25.0;
    let spline = depth * teeth * radius * 0.93 * radius * (PI / teeth).sin();
    close(removed(&[("bore", "\"spline\"")]), spline, 0.2, "spline");

    let with = |name: &'static str, value: &'static str, kind: &'static str| {
        removed(&[("bore", kind), (name, value)])
    };
    close(
        with("bore_diameter", "4", "\"round\""),
        depth * disc(2.1),
        0.2,
        "diameter",
    );
    close(
        with("bore_depth", "6", "\"round\""),
        6.0 * disc(1.6),
        0.2,
        "depth",
    );
    close(
        with("bore_fit", "0.3", "\"round\""),
        depth * disc(1.8),
        0.2,
        "fit",
    );
    let coarse = depth * 8.0 * radius * 0.93 * radius * (PI / 8.0).sin();
    close(
        with("bore_teeth", "8", "\"spline\""),
        coarse,
        0.2,
        "serrations",
    );
    let shallow = d_shape(radius, 0.3);
    close(
        with("bore_flat", "0.3", "\"d_shape\""),
        shallow,
        0.6,
        "flat",
    );
    let nema = d_shape(2.6, 0.5);
    close(
        removed(&[("bore_preset", "\"nema17\"")]),
        nema,
        0.6,
        "NEMA 17",
    );

    let round = ("bore", "\"round\"");
    for (values, words) in [
        // With the flat of 1 mm: 4 - 1 - 0.8 - 0.1 mm of radius are left.
        (
            [round, ("bore_diameter", "6")],
            "bore_diameter from 1 to 4.2 works",
        ),
        ([round, ("bore_diameter", "50")], "out of range: 1 to 6.2"),
        (
            [("bore", "\"oval\""), ("bore_diameter", "5")],
            "must be one of",
        ),
        (
            [("bore_preset", "\"servo_25t\""), ("shaft_flat", "1")],
            "shaft_flat from 0.0001 to 0.15 works",
        ),
        // A shaft of 8 mm has no room for these.
        (
            [("bore_preset", "\"nema23\""), ("shaft_flat", "0.1")],
            "must be one of",
        ),
        ([round, ("keyway", "true")], "larger hub.journal_radius_mm"),
        (
            [round, ("set_screw", "\"M3\"")],
            "must be one of [\"none\"]",
        ),
        (
            [round, ("center_distance", "30")],
            "teeth and motion dictate 25",
        ),
    ] {
        let said = bench.refusal("driver", &values);
        assert!(said.contains(words), "{values:?}: {said}");
    }
    for offer in ["keyway", "set_screw"] {
        let script = std::fs::read_to_string(bench.folder.join("driver.scad")).expect("a script");
        let shown = script.split("/* [Hidden] */").next().expect("text");
        assert!(!shown.contains(&format!("\n{offer} = ")), "{offer}");
    }
}

#[test]
fn values_that_do_nothing_are_told() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3, "useless");
    let said = |body: &str, values: Values| {
        let (log, notes) = bench.run(body, values).evaluated();
        assert!(!log.contains("WARNING"), "{log}");
        notes
    };
    for body in ["driver", "follower", "support"] {
        assert_eq!(said(body, &[]), Vec::<String>::new(), "{body}");
    }
    for (body, name, value, words) in [
        ("driver", "bore_diameter", "4", "bore is none"),
        ("driver", "bore_fit", "0.2", "bore is none"),
        ("driver", "elephant_foot", "0.2", "layout is not print"),
        (
            "driver",
            "rib_foot_thickness",
            "1.5",
            "spokes is not tapered",
        ),
        ("driver", "feet_height", "3", "a parameter of support.scad"),
        (
            "support",
            "boss_height",
            "3",
            "a parameter of follower.scad",
        ),
        ("follower", "boss_radius", "5", "boss_height is 0"),
        ("support", "feet_radius", "3", "feet_height is 0"),
    ] {
        let notes = said(body, &[(name, value)]);
        assert_eq!(notes.len(), 1, "{name}: {notes:?}");
        assert!(
            notes[0].contains(name) && notes[0].contains(words),
            "{notes:?}"
        );
    }
    assert!(said("driver", &[("bore", "\"round\""), ("bore_diameter", "4")]).is_empty());
}

#[test]
fn the_mount_carries_a_boss_with_bore_keyway_and_set_screw() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3T1, "boss");
    let plain = bench.mesh("follower", &[]);
    let boss: Values = &[("boss_height", "10"), ("boss_radius", "7.5")];
    let with_boss = bench.mesh("follower", boss);
    close(box_change(&plain, &with_boss)[5], 10.0, 1e-3, "height");
    let with = |more: Values| with_boss.volume() - bench.volume("follower", &[boss, more].concat());
    let bore: Values = &[("boss_bore", "\"round\""), ("boss_bore_diameter", "8")];
    close(with(bore), 10.0 * disc(4.1), 0.3, "bore of the boss");
    // DIN 6885: 2 mm wide for shafts up to 8 mm, 1 mm deep in the hub.
    let keyed = with(&[bore, &[("boss_keyway", "true")]].concat()) - with(bore);
    assert!((2.0 * 10.0..2.3 * 10.0).contains(&keyed), "keyway: {keyed}");
    let narrow: Values = &[("boss_bore", "\"round\"")];
    let screw = with(&[narrow, &[("boss_set_screw", "\"M3\"")]].concat()) - with(narrow);
    // At least the pocket of the nut, 5.9 × 2.8 mm and half the boss high.
    assert!(screw > 5.9 * 2.8 * 5.0, "set screw: {screw}");
    for (values, words) in [
        (bore, "needs a boss"),
        (
            &[("boss_radius", "15"), ("boss_height", "5")] as Values,
            "boss_radius = 15 is out of range: 2 to",
        ),
        (
            &[boss, narrow, &[("boss_bore_diameter", "13.8")]].concat(),
            "boss_bore_diameter from 1 to 13.2 works",
        ),
        (
            &[
                ("boss_height", "2"),
                narrow[0],
                ("boss_set_screw", "\"M3\""),
            ],
            "boss_height from 8.25 to 30",
        ),
    ] {
        let said = bench.refusal("follower", values);
        assert!(said.contains(words), "{values:?}: {said}");
    }
}

#[test]
fn the_support_has_feet_bearings_and_pieces() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R3, "support");
    let plain = bench.mesh("support", &[]);
    let feet = bench.mesh("support", &[("feet_height", "5"), ("feet_radius", "3")]);
    close(box_change(&plain, &feet)[2], -5.0, 1e-3, "feet");
    let added = feet.volume() - plain.volume();
    close(added, 4.0 * 5.0 * disc(3.0), 0.5, "feet");

    // Without a seat the eye grows by what the seat takes out again, twice.
    let room: Values = &[("journal_radius", "2.5"), ("bearing_wall", "3.9")];
    let eye = bench.volume("support", room);
    let seat: Values = &[("bearing", "\"MR105\""), ("bearing_fit", "0.1")];
    let seated = bench.volume("support", &[room, seat].concat());
    let seats = 2.0 * 4.0 * (disc(5.1) - disc(2.65));
    close(eye - seated, seats, 0.5, "seats of MR105");
    let said = bench.refusal("support", seat);
    assert!(said.contains("needs journal_radius = 2.5"), "{said}");

    for piece in bench.solids.pieces.iter().filter(|p| p.body == "support") {
        let name = format!("\"{}\"", piece.name);
        let values: Values = &[("piece", &name), ("layout", "\"print\"")];
        let printed = bench.mesh("support", values);
        close(printed.bounds().0.z, 0.0, 1e-4, "the bed");
        let share = printed.volume() / piece.mesh.volume();
        close(share, 1.0, 1e-3, &piece.name);
        let size = printed.bounds().1 - printed.bounds().0;
        let wanted = piece.mesh.bounds().1 - piece.mesh.bounds().0;
        close(size.z, wanted.z, 1e-3, &piece.name);
    }
}

#[test]
fn printing_lays_parts_down_and_pulls_their_feet_in() {
    if !installed() {
        return;
    }
    let bench = Bench::new(Class::R1, "print");
    let lying: Values = &[("layout", "\"print\"")];
    for body in ["driver", "follower"] {
        let (plain, flat) = (bench.mesh(body, &[]), bench.mesh(body, lying));
        close(flat.bounds().0.z, 0.0, 1e-4, "the bed");
        close(flat.volume(), plain.volume(), 0.05, body);
        let foot = bench.mesh(body, &[lying, &[("elephant_foot", "0.3")]].concat());
        close(box_change(&flat, &foot)[2], 0.0, 1e-4, "the bed");
        let lost = flat.volume() - foot.volume();
        // The outline of the lower journal (radius 4) or of the drum, 0.3 wide and high.
        assert!((1.0..20.0).contains(&lost), "{body}: {lost} mm³ of foot");
    }
}

#[test]
fn feet_of_a_slider_are_pulled_in() {
    if !installed() {
        return;
    }
    // With these values CGAL failed at a cut through the lowest layer.
    let bench = Bench::new(Class::R3T1, "slider");
    let lying = ["clearance", "joint_play", "piece_fit"]
        .into_iter()
        .zip(["0.25", "0.3", "0.2"])
        .chain([("layout", "\"print\""), ("piece", "\"slider_carriage\"")])
        .filter(|(name, _)| bench.has("slider", name))
        .collect::<Vec<_>>();
    close(
        bench.mesh("slider", &lying).bounds().0.z,
        0.0,
        1e-4,
        "the bed",
    );
    let flat = bench.volume("slider", &lying);
    let foot = bench.volume(
        "slider",
        &[&lying[..], &[("elephant_foot", "0.3")]].concat(),
    );
    assert!((1.0..60.0).contains(&(flat - foot)), "{flat} to {foot} mm³");
}

#[test]
fn every_parameter_set_works_on_every_part() {
    let Some(command) = manifold() else {
        return;
    };
    let bench = Bench::new(Class::R1, "sets");
    let sets = bench.folder.join("parameters.json");
    let text = std::fs::read_to_string(&sets).expect("sets");
    let page: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let names = page["parameterSets"].as_object().expect("sets");
    for name in [
        "draft",
        "sla",
        "fdm_0.4",
        "fdm_0.6+bridge",
        "motor_nema17",
        "motor_nema17+fdm_0.4",
        "bearings_mr105+sla",
    ] {
        assert!(names.contains_key(name), "{name} is missing");
    }
    assert!(!names.contains_key("fdm_0.4+stand"), "1R has no stand");
    for (name, values) in names {
        let values = values.as_object().expect("values");
        assert!(values.values().all(|v| v.is_string()));
        let lies = values.get("layout").is_some_and(|v| v == "print");
        let printers = ["fdm_0.4", "fdm_0.6", "sla", "sls"];
        let printed = name.split('+').any(|part| printers.contains(&part));
        assert_eq!(printed, lies, "{name}");
        let piece = values.get("piece").and_then(|v| v.as_str());
        for body in &bench.solids.bodies {
            let of_body = |p: &&mpcgear::solid::assembly::PrintPiece| p.body == body.name;
            let pieces: Vec<_> = bench.solids.pieces.iter().filter(of_body).collect();
            let single = piece.is_some_and(|name| name != "whole");
            if single && !pieces.iter().any(|p| Some(p.name.as_str()) == piece) {
                continue;
            }
            let count = if lies && !single { pieces.len() } else { 1 };
            let script = bench.folder.join(format!("{}.scad", body.name));
            let run = Run::with(&command, &script).set_of(&sets, name);
            let made = run.stl(&format!("set-{name}")).closed_bodies(count);
            if lies {
                close(made.bounds().0.z, 0.0, 1e-4, name);
            }
        }
    }
}
