//! Solids of every class from synthetic designs: sound bodies that stay clear of each other, pieces
//! that fit together, parameters that can be turned.

mod synthetic;

use mpcgear::Error;
use mpcgear::design::{Design, Gear};
use mpcgear::motion::{Class, Drive, Motion};
use mpcgear::solid::expression::Values;
use mpcgear::solid::kernel::{self, Solid};
use mpcgear::solid::{Solids, layout, pieces, primitive, section, sweep};

/// Every pair of bodies that overlaps at a driver angle (every `step` degrees), with the volume.
fn overlaps(
    (design, motion): &(Design, Motion),
    step: usize,
    counts: impl Fn(&str, &str) -> bool,
) -> Vec<String> {
    let solids = Solids::build(design, motion).expect("builds");
    let mut found = Vec::new();
    for degrees in (0..360).step_by(step) {
        let phi = (degrees as f64).to_radians();
        let place = |b| solids.placed(b, design, motion, phi);
        let placed: Vec<(&str, Solid)> = solids
            .bodies
            .iter()
            .map(|b| {
                (
                    b.name.as_str(),
                    Solid::new(&place(b), &b.name).expect("sound"),
                )
            })
            .collect();
        for (i, (a, solid_a)) in placed.iter().enumerate() {
            for (b, solid_b) in placed[i + 1..].iter().filter(|(b, _)| counts(a, b)) {
                let volume = solid_a.intersection(solid_b).volume();
                if volume > 1e-9 {
                    found.push(format!("{a} and {b} at {degrees}°: {volume:.4} mm³"));
                }
            }
        }
    }
    found
}

#[test]
fn rolling_bodies_never_overlap() {
    for class in Class::ALL {
        let found = overlaps(&synthetic::uniform(class), 10, |_, _| true);
        assert_eq!(found, Vec::<String>::new(), "{class}");
    }
}

#[test]
fn frames_and_joints_stay_clear_of_tilting_and_sliding_followers() {
    for example in ["stroke_1r1t", "trefoil", "wobble_lift_3r1t"] {
        // These teeth are not conjugate: gears may meet, everything else may not.
        let found = overlaps(&synthetic::example(example), 15, |a, b| {
            (a, b) != ("driver", "follower")
        });
        assert_eq!(found, Vec::<String>::new(), "{example}");
    }
}

#[test]
fn an_overlap_is_seen() {
    let (design, motion) = synthetic::uniform(Class::R1);
    let solids = Solids::build(&design, &motion).expect("builds");
    let [driver, follower, ..] = &solids.bodies[..] else {
        panic!("driver and follower come first");
    };
    // A tenth of a pitch out of mesh is more than the clearance.
    let driver = Solid::new(&driver.mesh, "driver").expect("sound");
    let turned = follower.carrier.pose(&motion, Drive::new(25.0, 1), 0.063);
    let follower = Solid::new(&follower.mesh.moved(&turned), "follower").expect("sound");
    assert!(driver.intersection(&follower).volume() > 0.01);
}

#[test]
fn pieces_fill_their_body_without_overlapping() {
    for class in Class::ALL {
        let (design, motion) = synthetic::uniform(class);
        let recipe = layout::recipe(&design, &motion).expect("has room");
        let values = Values::new(&recipe.parameters);
        for body in recipe.bodies.iter().filter(|b| !b.pieces.is_empty()) {
            let whole = primitive::build(&body.features, &values).expect("builds");
            let built: Vec<Solid> = body
                .pieces
                .iter()
                .map(|p| primitive::build(&p.features, &values).expect("builds"))
                .collect();
            for (i, a) in built.iter().enumerate() {
                for (j, b) in built.iter().enumerate().skip(i + 1) {
                    let overlap = a.intersection(b).volume();
                    let names = (&body.pieces[i].name, &body.pieces[j].name);
                    assert!(overlap < 1e-6, "{class}: {names:?} share {overlap} mm³");
                }
            }
            // Screw holes, gaps between pieces and the part of the pin's flange below the plate.
            let pieces = Solid::union_of(&built);
            let missing = whole.difference(&pieces).volume() / whole.volume();
            let extra = pieces.difference(&whole).volume() / whole.volume();
            assert!(
                missing < 0.06,
                "{class} {}: {missing} is missing",
                body.name
            );
            assert!(extra < 1e-6, "{class} {}: {extra} too much", body.name);
        }
    }
}

#[test]
fn every_parameter_keeps_every_body_in_one_piece() {
    for class in Class::ALL {
        let (design, motion) = synthetic::uniform(class);
        let recipe = layout::recipe(&design, &motion).expect("has room");
        for (i, parameter) in recipe.parameters.iter().enumerate() {
            assert!(parameter.min <= parameter.value, "{parameter:?}");
            assert!(parameter.value <= parameter.max, "{parameter:?}");
            for value in [parameter.min, parameter.max] {
                if value == parameter.value {
                    continue;
                }
                let mut turned = recipe.parameters.clone();
                turned[i].value = value;
                let values = Values::new(&turned);
                let pieces = recipe.bodies.iter().flat_map(|b| &b.pieces);
                let features = pieces.map(|p| (&p.name, &p.features));
                for (name, features) in
                    features.chain(recipe.bodies.iter().map(|b| (&b.name, &b.features)))
                {
                    let name = format!("{class} {name} with {} = {value}", parameter.name);
                    let solid = primitive::build(features, &values).expect(&name);
                    solid.one_body(&name).expect("one body");
                }
            }
        }
    }
}

#[test]
fn parts_list_names_the_pieces() {
    for class in Class::ALL {
        let (design, motion) = synthetic::uniform(class);
        let recipe = layout::recipe(&design, &motion).expect("has room");
        let assembly = pieces::assembly(class, &recipe).expect("complete recipe");
        let mut listed: Vec<&str> = assembly.printed.iter().map(|p| p.0.as_str()).collect();
        let mut built: Vec<&str> = recipe
            .bodies
            .iter()
            .flat_map(|b| match b.pieces.is_empty() {
                true => vec![b.name.as_str()],
                false => b.pieces.iter().map(|p| p.name.as_str()).collect(),
            })
            .collect();
        listed.sort_unstable();
        built.sort_unstable();
        assert_eq!(listed, built, "{class}");
        assert!(assembly.bought.iter().all(|b| b.1.starts_with("M3×")));
    }
}

#[test]
fn section_is_a_bead_on_a_neck_with_its_flank_at_the_contact() {
    let (mut design, _) = synthetic::uniform(Class::R1);
    design.section.root = 1.2; // deep enough for a neck below the bead
    let outline = section::polygon(&design.section, 40);
    let area: f64 = (0..outline.len())
        .map(|i| {
            let [a, b] = [0, 1].map(|k| outline[(i + k) % outline.len()]);
            0.5 * (a[0] * b[1] - a[1] * b[0])
        })
        .sum();
    // Circle of 0.9 mm above its chord of 1.4 mm, then 0.634 mm of neck; counter-clockwise.
    assert!((area - 3.107).abs() < 0.03, "area {area}");
    for i in 0..outline.len() {
        let (left, right) = (outline[outline.len() - 1 - i], outline[i]);
        assert!((left[1] - right[1]).abs() < 1e-9, "mirror image");
    }
    assert!(
        outline.iter().all(|p| p[0] > 0.05 - 1e-9),
        "behind the contact"
    );
    let at = |n: f64, b: f64| outline.iter().any(|p| (p[0] - n).hypot(p[1] - b) < 1e-9);
    assert!(
        at(0.05, 0.0),
        "flank starts half the clearance behind the contact"
    );
    assert!(at(1.85, 0.0), "thickness");
    assert!(at(0.95, 0.9), "tip");
    assert!(at(0.25, -1.2) && at(1.65, -1.2), "root as wide as the rib");
}

#[test]
fn flat_flanks_end_in_rounded_edges_behind_the_same_contact() {
    let (mut design, _) = synthetic::uniform(Class::R1);
    let mut area = 0.0;
    for radius in [0.95, 1.5, 2.5, 6.0] {
        design.section.flank_radius = radius;
        let outline = section::polygon(&design.section, 400);
        for i in 0..outline.len() {
            let (left, right) = (outline[outline.len() - 1 - i], outline[i]);
            assert!((left[1] - right[1]).abs() < 1e-9, "mirror image");
        }
        // On the flank every corner is `radius` from its centre, and the flank is as high as it says.
        let height = section::flank_height(&design.section);
        assert!(height >= 0.14 * radius || radius == 6.0, "{height}");
        let flank = outline
            .iter()
            .filter(|p| p[0] < 0.95 && p[1].abs() < height + 1e-9);
        for p in flank {
            let away = (p[0] - 0.05 - radius).hypot(p[1]);
            assert!((away - radius).abs() < 1e-6, "{p:?} is {away} away");
        }
        // No corner turns sharply: edges are round.
        let turn = |i: usize| {
            let at = |k: usize| outline[(i + k) % outline.len()];
            let way = |k: usize| (at(k + 1)[1] - at(k)[1]).atan2(at(k + 1)[0] - at(k)[0]);
            (way(1) - way(0)).rem_euclid(std::f64::consts::TAU)
        };
        let sharpest = (0..outline.len()).map(turn).fold(0.0, f64::max);
        // At the root the rib's sides stand in the section.
        assert!(sharpest < 0.5, "turns by {sharpest} at once, R = {radius}");
        let tops = outline.iter().filter(|p| (p[1] - 0.9).abs() < 1e-9);
        assert_eq!(tops.count(), 2, "flat tip between two edges");
        let corners = outline.iter().zip(outline.iter().cycle().skip(1));
        let now: f64 = corners
            .map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0]))
            .sum();
        assert!(now > area, "flatter is fuller");
        area = now;
    }
    assert!(area < 1.8 * 1.5, "less than its box");
}

#[test]
fn a_folding_sweep_is_named() {
    let (mut design, _) = synthetic::uniform(Class::R1);
    let tooth = &mut design.sub_gear_pairs[0].teeth[0];
    // A tangent that wheels about the normal: the section's corners run backwards.
    for (i, station) in tooth.stations.iter_mut().enumerate() {
        let (_, n, t) = station.frame(Gear::Driver);
        let about = nalgebra::Unit::new_normalize(n);
        let wheel = nalgebra::Rotation3::from_axis_angle(&about, 0.5 * i as f64);
        station.t1 = (wheel * t).into();
    }
    let axis = sweep::axis_point(Gear::Driver, 25.0);
    let frames = sweep::frames(tooth, Gear::Driver, axis);
    match sweep::tooth(&frames, &design.section, "driver tooth 1") {
        Err(Error::Infeasible { reason, place, .. }) => {
            assert!(reason.contains("folds"), "{reason}");
            assert!(place.starts_with("driver tooth 1"), "{place}");
        }
        other => panic!("folded sweep gave {other:?}"),
    }
}

#[test]
fn first_layers_are_drawn_in_where_asked_for() {
    let (mut design, motion) = synthetic::uniform(Class::R1);
    let plain = Solids::build(&design, &motion).expect("builds");
    let amount = 0.3;
    design.settings.fit.elephant_foot_mm = amount;
    let drawn_in = Solids::build(&design, &motion).expect("builds");
    assert_eq!(
        plain.bodies, drawn_in.bodies,
        "only what is printed is drawn in"
    );
    for (before, after) in plain.pieces.iter().zip(&drawn_in.pieces) {
        // Corner to corner on the bed, before and after.
        let foot = |mesh: &mpcgear::solid::Mesh| {
            let on_bed = mesh.vertices.iter().filter(|v| v[2] < 1e-6);
            on_bed.fold([f64::MAX, f64::MIN], |[lo, hi], v| {
                [lo.min(v[1]), hi.max(v[1])]
            })
        };
        let ([a, b], [c, d]) = (foot(&before.mesh), foot(&after.mesh));
        let name = &before.name;
        assert!(
            (c - a - amount).abs() < 2e-3 && (b - d - amount).abs() < 2e-3,
            "{name}: {a} to {b} became {c} to {d}"
        );
        assert!(before.mesh.bounds().1.z == after.mesh.bounds().1.z);
        let layers = |z: f64| {
            let cut = after.mesh.vertices.iter();
            cut.filter(|v| (v[2] - z).abs() < 1e-6).count()
        };
        assert!(layers(amount) > 0, "{name}: no step at {amount} mm");
    }
}

#[test]
fn a_block_loses_the_rim_of_its_first_layers() {
    let side = 20.0;
    let block = kernel::lathe(&[(side / 2_f64.sqrt(), 0.0), (side / 2_f64.sqrt(), 5.0)], 4);
    let solid = Solid::new(&block, "block").expect("closed");
    let amount = 0.25;
    let rim = amount * (side * side - (side - 2.0 * amount).powi(2));
    let left = solid.foot_drawn_in(amount).volume();
    assert!((side * side * 5.0 - left - rim).abs() < 1e-6, "{left}");
}
