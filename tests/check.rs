//! The checker checked: a sound mechanism passes, what cannot be decided or put together fails.

mod corpus;
mod known;

use corpus::*;
use mpcgear::design::Design;
use mpcgear::motion::{Class, MotionFile};
use mpcgear::solid::assembly::Carrier;
use mpcgear::solid::kernel::Solid;
use mpcgear::solid::recipe::{Feature, Piece, Recipe, Shape};
use mpcgear::solid::{Mesh, Solids};
use mpcgear::verify::Check;

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

/// The follower is loose by what its gap leaves it, and no looser than it may be.
#[test]
fn more_play_than_allowed_is_a_failure_with_a_name() {
    let (design, bodies) = sound();
    let motion = known::motion(Class::R1);
    let play = |design: &Design| {
        let check = checked(design, &motion, bodies);
        let found = claim(&check, "play as an angle");
        (found.value.expect("a figure"), found.holds)
    };
    let (as_drawn, holds) = play(design);
    assert!(holds);
    let mut stricter = design.clone();
    stricter.settings.fit.max_play_deg = 0.9 * as_drawn;
    assert_eq!(play(&stricter), (as_drawn, false));
    let mut wider = design.clone();
    wider.section.clearance *= 2.0;
    let (twice, _) = play(&wider);
    assert!(
        (twice / as_drawn - 2.0).abs() < 1e-6,
        "{as_drawn}°, then {twice}°"
    );
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

/// A mechanism whose recipe was changed after its bodies were built: only putting it together is
/// another matter.
fn assembled(design: &Design, change: impl Fn(&mut Recipe)) -> Check {
    let motion = known::motion(design.class);
    let solids = Solids::build(design, &motion).expect("builds");
    let mut spoiled = design.clone();
    spoiled.recipe = solids.recipe;
    change(&mut spoiled.recipe);
    checked(&spoiled, &motion, &solids.bodies)
}

fn piece<'a>(recipe: &'a mut Recipe, name: &str) -> &'a mut Piece {
    let mut pieces = recipe.bodies.iter_mut().flat_map(|b| &mut b.pieces);
    pieces.find(|p| p.name == name).expect("a piece")
}

#[test]
fn a_lid_over_the_driver_keeps_it_out() {
    let check = assembled(&known::revolute(), |recipe| {
        let lid = Shape::block(("-40", "-10"), ("-15", "15"), ("60", "63"));
        let post = Shape::block(("-40", "-38"), ("-15", "15"), ("0", "61"));
        let base = &mut piece(recipe, "base").features;
        base.extend([Feature::add("post", post), Feature::add("lid", lid)]);
    });
    assert_eq!(
        failed(&check),
        ["assembly of the driver", "assembly of the bridge"]
    );
    let driver = claim(&check, "assembly of the driver");
    assert!(
        driver.figure.contains("along −z the base is in the way"),
        "{}",
        driver.figure
    );
}

#[test]
fn a_socket_that_is_not_split_keeps_the_ball_out() {
    let design = known::spherical();
    let sound = assembled(&design, |_| {});
    let steps = |check: &Check| {
        let claims = check.claims.iter();
        claims
            .filter(|c| c.name.starts_with("assembly"))
            .map(|c| (c.name.clone(), c.holds))
            .collect::<Vec<_>>()
    };
    assert_eq!(steps(&sound).len(), 5);
    assert!(steps(&sound).iter().all(|s| s.1), "{:#?}", sound.claims);
    let whole = assembled(&design, |recipe| {
        let stand = piece(recipe, "stand");
        stand.features.retain(|f| f.name != "half of the cap");
    });
    let ball = claim(&whole, "assembly of the follower's ball");
    assert!(
        !ball.holds && ball.figure.contains("the stand is in the way"),
        "{ball:?}"
    );
}
