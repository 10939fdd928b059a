//! The checker checked: a sound mechanism passes, deliberately spoiled ones fail for the right reason.

mod known;

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::OnceLock;

use mpcgear::design::{Design, Gear};
use mpcgear::motion::{Class, Motion, MotionFile, MotionSource};
use mpcgear::solid::assembly::{Carrier, SolidBody};
use mpcgear::solid::kernel::Solid;
use mpcgear::solid::{Mesh, Solids};
use mpcgear::verify::{Check, CheckInput, Claim, Effort, Failure, Printer, check};
use nalgebra::{Rotation3, Vector3};

/// A sound 1R mechanism, built once.
fn sound() -> &'static (Design, Vec<SolidBody>) {
    static SOUND: OnceLock<(Design, Vec<SolidBody>)> = OnceLock::new();
    SOUND.get_or_init(|| {
        let design = known::revolute();
        let bodies = bodies_of(&design);
        (design, bodies)
    })
}

fn bodies_of(design: &Design) -> Vec<SolidBody> {
    Solids::build(design, &known::motion(design.class))
        .expect("builds")
        .bodies
}

fn checked(design: &Design, motion: &Motion, bodies: &[SolidBody]) -> Check {
    let input = CheckInput {
        design,
        motion,
        bodies,
        pieces: &[],
        printer: Printer::default(),
        // 40 phases are four in each tooth's share of the turn.
        effort: Effort {
            steps: 120,
            escape_phases: 40,
            directions: 2,
            play_phases: 10,
        },
    };
    check(&input, &mut |_, _| ControlFlow::Continue(())).expect("checks")
}

fn failed(check: &Check) -> Vec<&str> {
    check
        .claims
        .iter()
        .filter(|c| !c.holds)
        .map(|c| c.name.as_str())
        .collect()
}

/// Checks the sound design on meshes of which one was changed.
fn with_mesh(carrier: Carrier, change: impl Fn(&Mesh) -> Mesh) -> Check {
    let (design, bodies) = sound();
    let mut bodies = bodies.clone();
    for body in bodies.iter_mut().filter(|b| b.carrier == carrier) {
        body.mesh = change(&body.mesh);
    }
    checked(design, &known::motion(Class::R1), &bodies)
}

/// Checks the sound design on bodies that were built from a changed design.
fn built_from(change: impl Fn(&mut Design)) -> Check {
    let (design, bodies) = sound();
    let mut spoiled = design.clone();
    change(&mut spoiled);
    // Only the driver is spoiled; the rest fits the sound design.
    let mut mixed = bodies.clone();
    mixed[0] = bodies_of(&spoiled).swap_remove(0);
    assert_eq!(mixed[0].carrier, Carrier::Driver);
    checked(design, &known::motion(Class::R1), &mixed)
}

/// A small ball in the driver frame.
fn ball(centre: Vector3<f64>, radius: f64) -> Solid {
    let solid = manifold_rust::manifold::Manifold::sphere(radius, 32).get_mesh_gl64(-1);
    let mesh = Mesh {
        vertices: solid
            .vert_properties
            .chunks(solid.num_prop as usize)
            .map(|v| [v[0] + centre.x, v[1] + centre.y, v[2] + centre.z])
            .collect(),
        triangles: solid
            .tri_verts
            .chunks(3)
            .map(|t| [t[0] as u32, t[1] as u32, t[2] as u32])
            .collect(),
    };
    Solid::new(&mesh, "ball").expect("sound")
}

fn joined(mesh: &Mesh, solid: &Solid) -> Mesh {
    Solid::new(mesh, "body")
        .expect("sound")
        .union(solid)
        .one_body("body")
        .expect("one body")
}

/// Contact point and normal into the driver in the middle of tooth `j` of pair `k`.
fn middle(k: usize, j: usize) -> (Vector3<f64>, Vector3<f64>) {
    let stations = &sound().0.sub_gear_pairs[k].teeth[j].stations;
    let (p, n, _) = stations[stations.len() / 2].frame(Gear::Driver);
    (p, n)
}

#[test]
fn a_sound_mechanism_passes_every_claim() {
    let (design, bodies) = sound();
    let check = checked(design, &known::motion(Class::R1), bodies);
    assert_eq!(failed(&check), Vec::<&str>::new(), "{:#?}", check.claims);
    assert!(check.claims.len() > 20);
    assert!(check.failures.is_empty());
    // Every tooth pair touches over its whole contact, and the claims say where they are worst.
    assert_eq!(check.touching.len(), 20);
    for t in &check.touching {
        let ratio = (t.to_deg - t.from_deg) / 36.0;
        assert!((ratio - known::C).abs() < 1e-9, "{t:?}");
    }
    let apart = claim(&check, "driver and follower stay apart");
    assert!(
        apart.value.unwrap() > 0.09 && apart.value.unwrap() < 0.11,
        "{apart:?}"
    );
    assert!(apart.spot.phi_deg.is_some() && apart.spot.pair.is_some());
    // Two directions at ten phases, each close to the first-order clearance/Q.
    assert_eq!(check.play.len(), 20);
    for play in &check.play {
        let ratio = play.distance.expect("bounded") / play.first_order;
        assert!(ratio > 0.3 && ratio < 1.2, "{play:?}");
    }
}

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

/// An upright square post on `foot`: half width and height.
fn post(foot: Vector3<f64>, (half, height): (f64, f64)) -> Solid {
    let size = manifold_rust::linalg::Vec3::new(2.0 * half, 2.0 * half, height);
    let gl = manifold_rust::manifold::Manifold::cube(size, true).get_mesh_gl64(-1);
    let mesh = Mesh {
        vertices: gl
            .vert_properties
            .chunks(3)
            .map(|v| [v[0] + foot.x, v[1] + foot.y, v[2] + foot.z + 0.5 * height])
            .collect(),
        triangles: gl
            .tri_verts
            .chunks(3)
            .map(|t| [t[0] as u32, t[1] as u32, t[2] as u32])
            .collect(),
    };
    Solid::new(&mesh, "post").expect("sound")
}

fn claim<'a>(check: &'a Check, name: &str) -> &'a Claim {
    check.claims.iter().find(|c| c.name == name).expect(name)
}

#[test]
fn a_design_without_bodies_is_undecided_and_fails() {
    let check = checked(&sound().0, &known::motion(Class::R1), &[]);
    let failed = failed(&check);
    assert!(failed.contains(&"no overlap") && failed.contains(&"no escape"));
    assert!(claim(&check, "no escape").figure.starts_with("undecided"));
    assert!(!failed.contains(&"shared contact points"), "{failed:?}");
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
fn an_unreadable_mesh_is_undecided_and_fails() {
    let check = with_mesh(Carrier::Follower, |mesh| {
        let mut mesh = mesh.clone();
        mesh.vertices[0][2] = f64::NAN;
        mesh
    });
    let failed = failed(&check);
    assert!(
        failed.contains(&"closed meshes") && failed.contains(&"no overlap"),
        "{failed:?}"
    );
}

#[test]
fn another_motion_is_rejected() {
    let (design, bodies) = sound();
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/quick_return_1r.toml");
    let (_, motion) = MotionFile::read(&path).expect("reads");
    let failed_of = checked(design, &motion, bodies);
    let failed = failed(&failed_of);
    assert!(failed.contains(&"shared contact points"), "{failed:?}");
    assert!(failed.contains(&"no approach"), "{failed:?}");
    assert!(
        failed.contains(&"driver and follower stay apart"),
        "{failed:?}"
    );
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
    assert!(!failed.contains(&"shared contact points"), "{failed:?}");
}

#[test]
fn a_follower_that_slides_on_its_pin_is_not_retained() {
    // The cap of the pin cut off: everything of the support above the drum.
    let (_, bodies) = sound();
    let follower = bodies
        .iter()
        .find(|b| b.carrier == Carrier::Follower)
        .unwrap();
    let top = follower.mesh.bounds().1.z;
    let check = with_mesh(Carrier::Support, |mesh| {
        let pin = manifold_rust::manifold::Manifold::cube(
            manifold_rust::linalg::Vec3::new(16.0, 16.0, 2.0 * top),
            true,
        );
        let gl = pin.get_mesh_gl64(-1);
        let cutter = Mesh {
            vertices: gl
                .vert_properties
                .chunks(3)
                .map(|v| [v[0], v[1], v[2] + 2.0 * top - 6.0])
                .collect(),
            triangles: gl
                .tri_verts
                .chunks(3)
                .map(|t| [t[0] as u32, t[1] as u32, t[2] as u32])
                .collect(),
        };
        let cutter = Solid::new(&cutter, "cutter").expect("sound");
        Solid::new(mesh, "support")
            .expect("sound")
            .difference(&cutter)
            .mesh()
    });
    assert!(
        failed(&check).contains(&"joint holds the follower"),
        "{:?}",
        failed(&check)
    );
}
