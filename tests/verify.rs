//! The proof on solids whose answers are known.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use manifold_rust::linalg::Vec3;
use manifold_rust::manifold::Manifold;
use mpcgear::design::ClosureSample;
use mpcgear::motion::{Class, Drive, Motion, MotionSource};
use mpcgear::solid::Mesh;
use mpcgear::solid::assembly::{Carrier, SolidBody};
use mpcgear::verify::{
    Defect, Mechanism, Proof, ProofSettings, WallSettings, mesh, prove, thickness,
};

fn mesh_of(solid: &Manifold) -> Mesh {
    let gl = solid.get_mesh_gl64(-1);
    let stride = gl.num_prop as usize;
    Mesh {
        vertices: gl
            .vert_properties
            .chunks(stride)
            .map(|v| [v[0], v[1], v[2]])
            .collect(),
        triangles: gl
            .tri_verts
            .chunks(3)
            .map(|t| [t[0] as u32, t[1] as u32, t[2] as u32])
            .collect(),
    }
}

fn block(lo: [f64; 3], hi: [f64; 3]) -> Manifold {
    Manifold::cube(
        Vec3::new(hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]),
        false,
    )
    .translate(Vec3::new(lo[0], lo[1], lo[2]))
}

/// Cylinder about z, centred at the origin.
fn cylinder(height: f64, r0: f64, r1: f64, segments: i32) -> Manifold {
    Manifold::cylinder(height, r0, r1, segments).translate(Vec3::new(0.0, 0.0, -height / 2.0))
}

fn ball(radius: f64, at: [f64; 3]) -> Manifold {
    Manifold::sphere(radius, 96).translate(Vec3::new(at[0], at[1], at[2]))
}

fn body(name: &str, carrier: Carrier, solid: &Manifold) -> SolidBody {
    SolidBody {
        name: name.into(),
        mesh: mesh_of(solid),
        carrier,
    }
}

/// Driver turning by φ about x = −25, follower by −φ about z: the uniform motion.
fn proof_of(class: Class, bodies: &[SolidBody], settings: &ProofSettings, q: f64) -> Proof {
    let motion = Motion::new(class, &MotionSource::Uniform {}).expect("a uniform motion");
    let mechanism = Mechanism {
        motion: &motion,
        drive: Drive::new(25.0, 1),
    };
    let closure = [ClosureSample {
        phi: 0.0,
        q,
        q_star: q,
        eta: 1.0,
    }];
    prove(bodies, &mechanism, (settings, &closure), &mut |_, _| {
        ControlFlow::Continue(())
    })
    .expect("a proof")
}

fn kinds(mesh: &Mesh) -> Vec<Defect> {
    mesh::problems("toy", mesh)
        .iter()
        .map(|p| p.defect)
        .collect()
}

#[test]
fn gap_of_two_balls_is_the_distance_of_their_surfaces() {
    // Centres at x = −15 (driver, 10 from its axis) and x = +12 about z: nearest when both point
    // at each other, at φ = π for the follower's ball, while the driver's is then at x = −35.
    let driver = body("driver", Carrier::Driver, &ball(2.0, [-25.0, 0.0, 0.0]));
    let follower = body("follower", Carrier::Follower, &ball(3.0, [12.0, 0.0, 0.0]));
    let proof = proof_of(
        Class::R1,
        &[driver, follower],
        &ProofSettings::default(),
        1.0,
    );
    let pair = &proof.pairs[0];
    // At φ = π the centres are 13 apart; the facets of 96 segments lose at most 0.003 mm each.
    assert!((pair.gap_mm - 8.0).abs() < 0.01, "{}", pair.gap_mm);
    assert!(pair.gap_mm >= 8.0);
    assert!((pair.gap_at.phi - PI).abs() < 0.01);
    assert!((pair.gap_at.at[0] + 23.0).abs() < 0.01, "{:?}", pair.gap_at);
    assert!(pair.holds());
    assert_eq!(proof.overlap_max_mm3(), 0.0);
}

#[test]
fn shared_volume_of_two_blocks() {
    let support = body(
        "support",
        Carrier::Support,
        &block([10.0, -1.0, 0.0], [12.0, 1.0, 1.0]),
    );
    let driver = body(
        "driver",
        Carrier::Driver,
        &block([-60.0, -1.0, -1.0], [-50.0, 1.0, 1.0]),
    );
    let follower = body(
        "follower",
        Carrier::Follower,
        &block([-11.0, -0.5, 0.5], [0.0, 0.5, 3.0]),
    );
    let proof = proof_of(
        Class::R1,
        &[driver, follower, support],
        &ProofSettings::default(),
        1.0,
    );
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["follower", "support"])
        .unwrap();
    // At φ = 180°: [10, 11] × [−.5, .5] × [.5, 1].
    assert!(
        pair.colliding_steps > 5 && pair.colliding_steps < 30,
        "{}",
        pair.colliding_steps
    );
    let volume = pair.overlap_mm3.unwrap();
    assert!(volume > 0.3 && volume <= 0.51, "{volume}");
    assert!((pair.overlap_at.unwrap().phi - PI).abs() < 0.2);
    assert!(!proof.holds());
}

#[test]
fn a_body_inside_another_is_found_without_surface_contact() {
    let driver = body(
        "driver",
        Carrier::Driver,
        &block([-60.0, -1.0, -1.0], [-50.0, 1.0, 1.0]),
    );
    let follower = body("follower", Carrier::Follower, &ball(1.0, [0.0; 3]));
    let support = body("support", Carrier::Support, &ball(5.0, [0.0; 3]));
    let proof = proof_of(
        Class::R1,
        &[driver, follower, support],
        &ProofSettings::default(),
        1.0,
    );
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["follower", "support"])
        .unwrap();
    assert_eq!(pair.gap_mm, 0.0);
    assert_eq!(pair.colliding_steps, 360);
    assert!((pair.overlap_mm3.unwrap() - 4.0 / 3.0 * PI).abs() < 0.02);
    // A ball in a hollow one is not inside its material.
    let hollow = body(
        "support",
        Carrier::Support,
        &ball(5.0, [0.0; 3]).difference(&ball(1.2, [0.0; 3])),
    );
    let driver = body(
        "driver",
        Carrier::Driver,
        &block([-60.0, -1.0, -1.0], [-50.0, 1.0, 1.0]),
    );
    let follower = body("follower", Carrier::Follower, &ball(1.0, [0.0; 3]));
    let proof = proof_of(
        Class::R1,
        &[driver, follower, hollow],
        &ProofSettings::default(),
        1.0,
    );
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["follower", "support"])
        .unwrap();
    assert!(
        (pair.gap_mm - 0.2).abs() < 0.01 && pair.holds(),
        "{}",
        pair.gap_mm
    );
}

/// A fast pointer that passes through a thin post between two sampled phases.
#[test]
fn a_collision_between_samples_is_not_missed() {
    let phi = (100.5_f64).to_radians();
    let post = |radius: f64| {
        cylinder(4.0, radius, radius, 24).translate(Vec3::new(
            -25.0 + 20.0 * phi.cos(),
            20.0 * phi.sin(),
            0.0,
        ))
    };
    let follower = body("follower", Carrier::Follower, &ball(1.0, [20.0, 0.0, 30.0]));
    let pointer = body(
        "driver",
        Carrier::Driver,
        &block([-25.0, -0.05, -1.0], [-4.0, 0.05, 1.0]),
    );
    let thin = body("support", Carrier::Support, &post(0.05));
    let bodies = [pointer, follower, thin];
    let proof = proof_of(Class::R1, &bodies, &ProofSettings::default(), 1.0);
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["driver", "support"])
        .unwrap();
    // Whether a step lands on the post or the bound between steps raises the doubt: it is found there.
    let found = pair.overlap_at.as_ref().or(pair.doubts.first());
    let found = found.expect("the collision is not missed");
    assert!((found.phi - phi).abs() < 0.01, "{found:?}");
    assert!(!pair.holds());
    // Out of the pointer's way it is proven clear, though it is nearer than a step of the tip.
    let clear = cylinder(4.0, 0.05, 0.05, 24).translate(Vec3::new(
        -25.0 + 21.1 * phi.cos(),
        21.1 * phi.sin(),
        0.0,
    ));
    let bodies = [
        bodies[0].clone(),
        bodies[1].clone(),
        body("support", Carrier::Support, &clear),
    ];
    let proof = proof_of(Class::R1, &bodies, &ProofSettings::default(), 1.0);
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["driver", "support"])
        .unwrap();
    assert!(
        pair.holds() && pair.gap_mm < 0.2,
        "{} {:?}",
        pair.gap_mm,
        pair.doubts
    );
    // Grown by 0.06 mm each they would meet.
    let grown = ProofSettings {
        grown_by_mm: 0.06,
        ..ProofSettings::default()
    };
    let proof = proof_of(Class::R1, &bodies, &grown, 1.0);
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["driver", "support"])
        .unwrap();
    assert!(!pair.holds());
}

#[test]
fn a_shaft_in_its_bore_is_proven_clear_all_the_way_round() {
    let shaft = cylinder(20.0, 4.0, 4.0, 128).translate(Vec3::new(-25.0, 0.0, 0.0));
    let bore = cylinder(30.0, 4.15, 4.15, 128).translate(Vec3::new(-25.0, 0.0, 0.0));
    let plate = block([-35.0, -10.0, -5.0], [-15.0, 10.0, 5.0]).difference(&bore);
    let bodies = [
        body("driver", Carrier::Driver, &shaft),
        body("follower", Carrier::Follower, &ball(1.0, [20.0, 0.0, 30.0])),
        body("support", Carrier::Support, &plate),
    ];
    let proof = proof_of(Class::R1, &bodies, &ProofSettings::default(), 1.0);
    let pair = proof
        .pairs
        .iter()
        .find(|p| p.bodies == ["driver", "support"])
        .unwrap();
    let sag = 4.15 * (1.0 - (PI / 128.0).cos());
    assert!(
        pair.gap_mm > 0.15 - sag - 1e-6 && pair.gap_mm < 0.15 + sag,
        "{}",
        pair.gap_mm
    );
    assert!(pair.holds(), "{:?}", pair.doubts);
}

/// Driver: a fork that grips a pin of the follower; with play on both sides.
fn fork(gap: f64, walls: [bool; 2]) -> Manifold {
    // The pin sits at (−10, 0, 0) with radius 1; rotation about z moves it in y.
    let mut fork = block([-26.0, -1.0, -4.0], [-24.0, 1.0, -3.0]);
    let base = block([-26.0, -3.0, -4.0], [-9.0, 3.0, -3.0]);
    fork = fork.union(&base);
    if walls[0] {
        fork = fork.union(&block([-12.0, 1.0 + gap, -4.0], [-9.0, 3.0, 2.0]));
    }
    if walls[1] {
        fork = fork.union(&block([-12.0, -3.0, -4.0], [-9.0, -1.0 - gap, 2.0]));
    }
    fork
}

fn pin() -> Manifold {
    cylinder(4.0, 1.0, 1.0, 96)
        .translate(Vec3::new(-10.0, 0.0, 0.5))
        .union(&block([-10.0, -0.5, 2.0], [0.0, 0.5, 2.5]))
}

fn escapes_of(walls: [bool; 2]) -> Proof {
    let bodies = [
        body("driver", Carrier::Driver, &fork(0.05, walls)),
        body("follower", Carrier::Follower, &pin()),
    ];
    // Only φ = 0 is a fork-and-pin position; Q = 10 mm is the lever arm.
    let settings = ProofSettings {
        escape_phases: 1,
        phases: 1,
        clearance_mm: 0.1,
        ..ProofSettings::default()
    };
    proof_of(Class::R1, &bodies, &settings, 10.0)
}

#[test]
fn a_gripped_pin_cannot_escape_and_a_free_one_does() {
    let held = escapes_of([true, true]);
    assert_eq!((held.displacements, held.escapes.len()), (2, 0));
    let free = escapes_of([true, false]);
    assert_eq!(free.escapes.len(), 1);
    // The missing wall is at −y; the pin at x = −10 goes there by a positive turn.
    assert_eq!(free.escapes[0].direction, vec![1.0]);
    let other = escapes_of([false, true]);
    assert_eq!(other.escapes[0].direction, vec![-1.0]);
    // No measure of closure means no size that would count as blocked.
    let bodies = [
        body("driver", Carrier::Driver, &fork(0.05, [true, true])),
        body("follower", Carrier::Follower, &pin()),
    ];
    let settings = ProofSettings {
        escape_phases: 1,
        phases: 1,
        ..ProofSettings::default()
    };
    assert_eq!(
        proof_of(Class::R1, &bodies, &settings, 0.0).escapes.len(),
        2
    );
    assert_eq!(
        proof_of(Class::R1, &bodies, &settings, f64::NAN)
            .escapes
            .len(),
        2
    );
}

#[test]
fn walls_are_found_and_edges_are_not_walls() {
    let settings = WallSettings {
        up_to: 3.0,
        spacing: 0.15,
    };
    let thinnest = |solid: &Manifold| thickness::thinnest(&mesh_of(solid), &settings);
    // A plate.
    let plate = thinnest(&block([0.0; 3], [20.0, 15.0, 0.5])).unwrap();
    assert!((plate.thickness_mm - 0.5).abs() < 1e-6, "{plate:?}");
    // A thick block: nothing below 3 mm, though its edges and corners are sharp.
    assert_eq!(thinnest(&block([0.0; 3], [20.0, 15.0, 4.0])), None);
    // A wedge-shaped edge of 45° is not a thin wall.
    let wedge =
        block([0.0; 3], [20.0, 20.0, 20.0]).trim_by_plane(Vec3::new(1.0, 0.0, 1.0), 14.142135);
    assert_eq!(thinnest(&wedge), None);
    // A bore close to a face leaves a web of 0.4 mm.
    let bore = cylinder(30.0, 3.0, 3.0, 96).translate(Vec3::new(10.0, 3.4, 0.0));
    let web = thinnest(&block([0.0, 0.0, -10.0], [20.0, 20.0, 10.0]).difference(&bore)).unwrap();
    assert!((web.thickness_mm - 0.4).abs() < 0.03, "{web:?}");
    assert!(web.at[1] < 0.5 && (web.at[0] - 10.0).abs() < 1.0, "{web:?}");
    // The notch of a V-groove 0.6 mm above the bottom: faces are not parallel, the wall is thin.
    let groove = block([-5.0, -30.0, -5.0], [5.0, 30.0, 5.0])
        .rotate(0.0, 45.0, 0.0)
        .translate(Vec3::new(0.0, 0.0, 0.6 + 5.0 * 2.0_f64.sqrt()));
    let notch =
        thinnest(&block([-15.0, -10.0, 0.0], [15.0, 10.0, 6.0]).difference(&groove)).unwrap();
    assert!(
        notch.thickness_mm > 0.599 && notch.thickness_mm < 0.75,
        "{notch:?}"
    );
    // A tube and a thin rod.
    let tube = cylinder(10.0, 5.0, 5.0, 128).difference(&cylinder(12.0, 4.2, 4.2, 128));
    let tube = thinnest(&tube).unwrap();
    assert!((tube.thickness_mm - 0.8).abs() < 0.02, "{tube:?}");
    let rod = thinnest(&cylinder(10.0, 0.9, 0.9, 48)).unwrap();
    assert!((rod.thickness_mm - 1.8).abs() < 0.02, "{rod:?}");
}

#[test]
fn mesh_defects_are_named() {
    let good = mesh_of(&block([0.0; 3], [2.0, 3.0, 4.0]).difference(&ball(1.0, [0.0; 3])));
    assert_eq!(kinds(&good), vec![]);
    let spoil = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        kinds(&mesh)
    };
    assert_eq!(
        spoil(&|m| {
            m.triangles.pop();
        }),
        vec![Defect::Open]
    );
    assert_eq!(spoil(&|m| m.triangles[3].swap(0, 1)), vec![Defect::Flipped]);
    assert_eq!(
        spoil(&|m| m.triangles.iter_mut().for_each(|t| t.swap(0, 1))),
        vec![Defect::InsideOut]
    );
    assert_eq!(spoil(&|m| m.triangles.clear()), vec![Defect::Empty]);
    assert_eq!(
        spoil(&|m| m.vertices[2][1] = f64::NAN),
        vec![Defect::Unreadable]
    );
    assert_eq!(
        spoil(&|m| m.triangles[0][1] = 1_000_000),
        vec![Defect::Unreadable]
    );
    assert!(spoil(&|m| m.triangles[5] = [m.triangles[5][0]; 3]).contains(&Defect::Degenerate));
    let append = |a: &Mesh, b: &Mesh| {
        let mut both = a.clone();
        let shift = both.vertices.len() as u32;
        both.vertices.extend(&b.vertices);
        both.triangles
            .extend(b.triangles.iter().map(|t| t.map(|i| i + shift)));
        both
    };
    let apart = mesh_of(&ball(1.0, [9.0; 3]));
    assert_eq!(kinds(&append(&good, &apart)), vec![Defect::Disconnected]);
    let crossing = mesh_of(&ball(1.0, [2.0, 1.6, 2.1]));
    let crossed = kinds(&append(&good, &crossing));
    assert_eq!(
        crossed,
        vec![Defect::Disconnected, Defect::SelfIntersecting]
    );
    // Two blocks that share one edge only, and two that share one corner only.
    let edge = append(
        &mesh_of(&block([0.0; 3], [1.0; 3])),
        &mesh_of(&block([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])),
    );
    assert!(kinds(&edge).contains(&Defect::NonManifold));
    let corner = append(
        &mesh_of(&block([0.0; 3], [1.0; 3])),
        &mesh_of(&block([1.0; 3], [2.0; 3])),
    );
    assert!(kinds(&corner).contains(&Defect::NonManifold));
    // A vertex pulled through the opposite side.
    let mut pulled = mesh_of(&ball(1.0, [0.0; 3]));
    pulled.vertices[0] = pulled.vertices[0].map(|x| -1.3 * x);
    assert_eq!(kinds(&pulled), vec![Defect::SelfIntersecting]);
}

/// What is no surface is told soon, however many triangles it has.
#[test]
fn heaps_of_triangles_are_no_surfaces() {
    // A deterministic mess: corners all over a cube.
    let mut state = 1u64;
    let mut random = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let count = 20_000;
    let vertices: Vec<[f64; 3]> = (0..3 * count)
        .map(|_| [random(), random(), random()])
        .collect();
    let triangles = (0..count as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    let soup = Mesh {
        vertices,
        triangles,
    };
    assert_eq!(kinds(&soup), vec![Defect::Loose]);
    // The same corners, closed: two triangles, back to back, each.
    let back = soup
        .triangles
        .iter()
        .map(|t| [t[0], t[2], t[1]])
        .collect::<Vec<_>>();
    let closed = Mesh {
        triangles: soup.triangles.iter().copied().chain(back).collect(),
        ..soup.clone()
    };
    let found = mesh::problems("mess", &closed);
    let crossings = found.iter().find(|p| p.defect == Defect::SelfIntersecting);
    let crossings = crossings.expect("it crosses itself").count;
    // All there are would be millions.
    assert!((10_000..1_000_000).contains(&crossings), "{crossings}");
    // A million times the same triangle.
    let same = Mesh {
        vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]; 100_000],
    };
    assert!(kinds(&same).contains(&Defect::Crowded));
}

#[test]
fn a_stopped_proof_says_so() {
    let bodies = [
        body("driver", Carrier::Driver, &ball(1.0, [-25.0, 0.0, 0.0])),
        body("follower", Carrier::Follower, &ball(1.0, [0.0; 3])),
    ];
    let motion = Motion::new(Class::R1, &MotionSource::Uniform {}).unwrap();
    let mechanism = Mechanism {
        motion: &motion,
        drive: Drive::new(25.0, 1),
    };
    let closure = [ClosureSample {
        phi: 0.0,
        q: 1.0,
        q_star: 1.0,
        eta: 1.0,
    }];
    let settings = (&ProofSettings::default(), closure.as_slice());
    let stopped = prove(&bodies, &mechanism, settings, &mut |what, _| {
        if what == "proof: overlap" {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert!(matches!(stopped, Err(mpcgear::Error::Interrupted)));
}
