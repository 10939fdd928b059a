//! Deliberately spoiled designs: each is rejected for the right reason.

mod corpus;
mod known;

use std::f64::consts::TAU;

use corpus::*;
use mpcgear::design::Design;
use mpcgear::motion::{Class, Motion, MotionSource};
use mpcgear::solid::Mesh;
use mpcgear::solid::Solids;
use mpcgear::solid::assembly::Carrier;
use mpcgear::solid::kernel::Solid;
use mpcgear::verify::{Check, Claim, Failure};
use nalgebra::{Rotation3, Vector3};

#[test]
fn a_thickened_tooth_is_rejected() {
    let (p, n) = middle(1, 3);
    let check = with_mesh(Carrier::Driver, |mesh| {
        joined(mesh, &ball(p + 0.5 * n, 0.7))
    });
    let failed = failed(&check);
    assert!(
        failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
    assert!(
        failed.contains(&"flanks of the driver in place"),
        "{failed:?}"
    );
    let flank = check
        .claims
        .iter()
        .find(|c| c.name == "flanks of the driver in place")
        .unwrap();
    assert!(flank.place.ends_with("pair 2, tooth 4"), "{}", flank.place);
    // The ball meets the mate of the very tooth it sits on.
    let failure = &check.failures[0];
    assert_eq!(failure.failure, Failure::TwistedTeeth);
    assert_eq!(failure.driver_tooth, Some((1, 3)));
}

#[test]
fn a_moved_tooth_is_rejected() {
    let check = built_from(|design| {
        for s in &mut design.sub_gear_pairs[0].teeth[2].stations {
            s.p1 = (Vector3::from(s.p1) + 0.15 * Vector3::from(s.n1)).into();
        }
    });
    let failed = failed(&check);
    assert!(
        failed.contains(&"flanks of the driver in place"),
        "{failed:?}"
    );
    assert!(failed.contains(&"no escape"), "{failed:?}");
    assert!(
        !failed.contains(&"driver and follower stay apart"),
        "moved away, not into: {failed:?}"
    );
}

#[test]
fn teeth_that_leave_different_gaps_jolt_at_the_hand_over() {
    // Each within the tolerance of a flank, but not from one tooth to the next.
    let check = built_from(|design| {
        for (j, by) in [(2, 0.015), (3, -0.015)] {
            for s in &mut design.sub_gear_pairs[0].teeth[j].stations {
                s.p1 = (Vector3::from(s.p1) + by * Vector3::from(s.n1)).into();
            }
        }
    });
    let failed = failed(&check);
    assert!(failed.contains(&"no jump at hand-over"), "{failed:?}");
    assert!(
        !failed.contains(&"flanks of the driver in place"),
        "{failed:?}"
    );
    let claim = claim(&check, "no jump at hand-over");
    assert_eq!((claim.spot.pair, claim.spot.tooth), (Some(1), Some(3)));
}

#[test]
fn a_support_in_the_followers_room_is_named() {
    // A post from the base up into the circle of the follower's teeth, away from the driver.
    let check = with_mesh(Carrier::Support, |mesh| {
        let (low, _) = mesh.bounds();
        let post = post(Vector3::new(known::PITCH, 0.0, low.z), (1.5, 10.0 - low.z));
        Solid::new(mesh, "support")
            .expect("sound")
            .union(&post)
            .mesh()
    });
    let failed = failed(&check);
    assert!(
        failed.contains(&"follower and support stay apart"),
        "{failed:?}"
    );
    assert!(!failed.contains(&"no escape"), "{failed:?}");
    let failure = check.failures.first().expect("named");
    assert_eq!(failure.failure, Failure::FollowerMeetsSupport);
}

#[test]
fn a_flipped_tooth_is_rejected() {
    let check = built_from(|design| {
        for s in &mut design.sub_gear_pairs[0].teeth[5].stations {
            s.n1 = s.n1.map(|x| -x);
        }
    });
    let failed = failed(&check);
    assert!(
        failed.contains(&"flanks of the driver in place"),
        "{failed:?}"
    );
    assert!(
        failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
}

#[test]
fn a_mirrored_tooth_is_rejected() {
    // Mirrored about its own middle height, as a helix of the other hand.
    let check = built_from(|design| {
        let stations = &mut design.sub_gear_pairs[0].teeth[4].stations;
        let middle = stations[stations.len() / 2].p1[2];
        for s in stations {
            s.p1[2] = 2.0 * middle - s.p1[2];
            s.n1[2] = -s.n1[2];
            s.t1[2] = -s.t1[2];
        }
    });
    let failed = failed(&check);
    assert!(!failed.contains(&"closed meshes"), "{failed:?}");
    let flank = claim(&check, "flanks of the driver in place");
    assert!(!flank.holds, "{failed:?}");
    assert_eq!((flank.spot.pair, flank.spot.tooth), (Some(1), Some(5)));
    assert!(
        failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
}

#[test]
fn a_mirrored_driver_is_rejected() {
    let check = with_mesh(Carrier::Driver, |mesh| Mesh {
        vertices: mesh.vertices.iter().map(|&[x, y, z]| [x, -y, z]).collect(),
        triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
    });
    let failed = failed(&check);
    assert!(!failed.contains(&"closed meshes"), "{failed:?}");
    assert!(
        failed.contains(&"flanks of the driver in place"),
        "{failed:?}"
    );
    assert!(
        failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
}

#[test]
fn a_missing_tooth_is_rejected() {
    let check = built_from(|design| {
        design.sub_gear_pairs[0].teeth.remove(7);
    });
    let failed = failed(&check);
    assert!(failed.contains(&"no escape"), "{failed:?}");
    assert!(failed.contains(&"hand-over"), "{failed:?}");
    assert!(
        !failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
    let hand_over = check.claims.iter().find(|c| c.name == "hand-over").unwrap();
    assert!(
        hand_over.place.ends_with("pair 1, tooth 8"),
        "{}",
        hand_over.place
    );
}

#[test]
fn a_normal_turned_by_two_degrees_is_rejected() {
    let (design, bodies) = sound();
    let mut spoiled = design.clone();
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 2f64.to_radians());
    for s in &mut spoiled.sub_gear_pairs[1].teeth[0].stations {
        for n in [&mut s.n, &mut s.n1, &mut s.n2] {
            *n = (turn * Vector3::from(*n)).into();
        }
    }
    let check = checked(&spoiled, &known::motion(Class::R1), bodies);
    let failed = failed(&check);
    assert!(failed.contains(&"normal across the curve"), "{failed:?}");
    assert!(!failed.contains(&"shared contact points"), "{failed:?}");
    let claim = check
        .claims
        .iter()
        .find(|c| c.name == "normal across the curve")
        .unwrap();
    assert!(claim.place.ends_with("pair 2, tooth 1"), "{}", claim.place);
}

#[test]
fn a_spoke_in_the_way_is_rejected() {
    // A ball on the driver's drum side of a tooth, between two bands' teeth of the follower.
    let (p, n) = middle(0, 0);
    let check = with_mesh(Carrier::Driver, |mesh| {
        joined(mesh, &ball(p + n - 3.0 * along(n, p), 1.6))
    });
    let failed = failed(&check);
    assert!(
        failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
}

/// Across the normal in the plane of turning: towards the neighbouring tooth.
fn along(n: Vector3<f64>, p: Vector3<f64>) -> Vector3<f64> {
    let radial = Vector3::new(p.x + 25.0, p.y, 0.0).normalize();
    (radial.cross(&Vector3::z()) * n.dot(&radial.cross(&Vector3::z())).signum()).normalize()
}

#[test]
fn a_hole_is_rejected() {
    let check = with_mesh(Carrier::Support, |mesh| {
        let mut mesh = mesh.clone();
        mesh.triangles.remove(20);
        mesh
    });
    assert_eq!(failed(&check), ["closed meshes"]);
    let claim = check
        .claims
        .iter()
        .find(|c| c.name == "closed meshes")
        .unwrap();
    assert!(
        claim.figure.contains("support") && claim.figure.contains("hole"),
        "{}",
        claim.figure
    );
}

#[test]
fn two_bands_of_equal_side_are_rejected() {
    let m = known::motion(Class::R1);
    let band = |z0: f64| {
        known::Helical {
            alpha: 0.5,
            side: 1.0,
            z0,
            travel: 12.0,
        }
        .band(&m)
    };
    let design = known::design(Class::R1, vec![band(10.0), band(26.0)]);
    let check = checked(&design, &m, &bodies_of(&design));
    let failed = failed(&check);
    assert!(failed.contains(&"dynamic form closure"), "{failed:?}");
    assert!(failed.contains(&"no escape"), "{failed:?}");
    assert!(failed.contains(&"held by the flanks alone"), "{failed:?}");
    assert!(!failed.contains(&"shared contact points"), "{failed:?}");
    // Nothing is stated that nobody can know.
    let kinematic = claim(&check, "kinematic error");
    assert!(
        kinematic
            .figure
            .starts_with("undecided: without form closure"),
        "{}",
        kinematic.figure
    );
    let numbers = |c: &Claim| !(c.figure.contains("NaN") || c.figure.contains("inf"));
    assert!(check.claims.iter().all(numbers), "{:#?}", check.claims);
}

#[test]
fn a_motion_scaled_by_a_twentieth_is_rejected() {
    let (design, motion) = uneven(0.25);
    let bodies = Solids::build(&design, &motion).expect("builds").bodies;
    let right = checked(&design, &motion, &bodies);
    let of = |check: &Check| {
        failed(check)
            .iter()
            .map(|n| n.to_string())
            .collect::<Vec<_>>()
    };
    let wrong = checked(&design, &uneven_motion(0.25 * 1.05), &bodies);
    for name in [
        "shared contact points",
        "no approach",
        "driver and follower stay apart as printed",
        "kinematic error",
    ] {
        assert!(!of(&right).contains(&name.into()), "{:#?}", right.claims);
        assert!(of(&wrong).contains(&name.into()), "{:?}", of(&wrong));
    }
}

/// Bands of opposite side on the instantaneous pitch line of a follower that turns by
/// −φ + `swing`·sin φ.
fn uneven(swing: f64) -> (Design, Motion) {
    let motion = uneven_motion(swing);
    let (alpha, travel) = (0.5_f64, 12.0);
    let band = |side: f64, z0: f64| {
        let dz = travel / (known::C * TAU / known::J as f64);
        let across = Vector3::new(0.0, dz, known::PITCH).normalize() * side;
        let n = Vector3::x() * alpha.sin() + across * alpha.cos();
        let ratio = |phi: f64| 1.0 - swing * phi.cos();
        let pitch = |phi: f64| -known::L / (1.0 + ratio(phi));
        // From n·ṗ = n·v₂(p): how fast the contact has to move along the axis.
        let speed = |phi: f64| {
            let h = 1e-4;
            let slide = (pitch(phi + h) - pitch(phi - h)) / (2.0 * h);
            (-n.y * ratio(phi) * pitch(phi) - n.x * slide) / n.z
        };
        known::band(&motion, &|phi, middle| {
            // Simpson's rule with 32 intervals.
            let h = (phi - middle) / 32.0;
            let weight = |i: i32| match i {
                0 | 32 => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let sum: f64 = (0..=32)
                .map(|i| weight(i) * speed(middle + h * f64::from(i)))
                .sum();
            (Vector3::new(pitch(phi), 0.0, z0 + h / 3.0 * sum), n)
        })
    };
    let mut design = known::design(Class::R1, vec![band(1.0, 10.0), band(-1.0, 26.0)]);
    design.motion = motion_source(swing);
    (design, motion)
}

fn motion_source(swing: f64) -> MotionSource {
    serde_json::from_value(serde_json::json!({
        "kind": "formula",
        "own_turn": format!("-phi + {swing}*sin(phi)"),
    }))
    .expect("a motion")
}

fn uneven_motion(swing: f64) -> Motion {
    Motion::new(Class::R1, &motion_source(swing)).expect("a motion")
}
