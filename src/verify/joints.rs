//! Are the joints what they should be: the follower held by its ball or pin, and free to be put in.

use nalgebra::{Matrix3, Vector3};

use super::claim::Claim;
use super::collide::Placed;
use super::mechanism::Mechanism;
use super::overlap::Part;
use crate::motion::{Class, Pose};
use crate::solid::assembly::Carrier;

/// Phases at which putting in is tried.
const PHASES: usize = 36;

/// Claims about the joints; `play` is the radial play of the joints, mm.
pub(super) fn claims(parts: &[Part], mechanism: &Mechanism, play: f64) -> Vec<Claim> {
    let mut claims = vec![retained(parts, mechanism, play)];
    claims.push(insertion(parts, mechanism));
    claims
}

fn shift(by: Vector3<f64>) -> Pose {
    Pose {
        rotation: Matrix3::identity(),
        translation: by,
    }
}

fn compose(outer: &Pose, inner: &Pose) -> Pose {
    Pose {
        rotation: outer.rotation * inner.rotation,
        translation: outer.apply(inner.translation),
    }
}

/// Whether the follower, moved by `by` at `phi`, touches `other`.
fn touches(
    (follower, other): (&Part, &Part),
    mechanism: &Mechanism,
    (phi, by): (f64, Vector3<f64>),
) -> bool {
    let moved = compose(&shift(by), &mechanism.pose(Carrier::Follower, phi));
    let seen = mechanism.pose(other.body.carrier, phi).inverse_mul(&moved);
    Placed::new(&other.tree, &follower.tree, seen)
        .touch(None)
        .is_some()
}

/// Pulled in any direction that the joint forbids, the follower must meet what holds it.
fn retained(parts: &[Part], mechanism: &Mechanism, play: f64) -> Claim {
    let claim = Claim::new(
        "joint holds the follower",
        "the follower cannot be pulled out of its joint",
    );
    let class = mechanism.motion.class();
    let holder = if class == Class::R3T1 {
        Carrier::Slider
    } else {
        Carrier::Support
    };
    let find = |c: Carrier| parts.iter().find(|p| p.body.carrier == c);
    let (Some(follower), Some(holder)) = (find(Carrier::Follower), find(holder)) else {
        return claim.undecided("the body that holds the follower is missing");
    };
    let mut directions = vec![Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()];
    if class != Class::R1T1 {
        directions.extend([Vector3::z(), -Vector3::z()]);
    }
    // Twice the play closes any joint of that play, facets included.
    let size = 2.0 * play + 0.1;
    let free = directions
        .iter()
        .find(|&d| !touches((follower, holder), mechanism, (0.0, d * size)));
    match free {
        None => claim.say(
            true,
            format!("stopped within {size:.2} mm on all sides"),
            "stopped",
        ),
        Some(d) => claim.say(
            false,
            format!(
                "free to move {size:.2} mm towards ({:.0}, {:.0}, {:.0})",
                d.x, d.y, d.z
            ),
            "stopped",
        ),
    }
}

/// All contact normals push the follower away from the driver, so at some driver angle it must be
/// possible to slide it in along −x: moved out along +x it may not touch the driver.
fn insertion(parts: &[Part], mechanism: &Mechanism) -> Claim {
    let claim = Claim::new(
        "assembly",
        "the follower can be slid into mesh with the driver in place",
    );
    let find = |c: Carrier| parts.iter().find(|p| p.body.carrier == c);
    let (Some(follower), Some(driver)) = (find(Carrier::Follower), find(Carrier::Driver)) else {
        return claim.undecided("driver or follower is missing");
    };
    let away = mechanism.center_distance;
    let steps: Vec<f64> = (1..=100)
        .map(|i| away * (f64::from(i) / 100.0).powi(2))
        .collect();
    let free = (0..PHASES)
        .map(|i| std::f64::consts::TAU * i as f64 / PHASES as f64)
        .find(|&phi| {
            steps
                .iter()
                .all(|&s| !touches((follower, driver), mechanism, (phi, Vector3::x() * s)))
        });
    match free {
        Some(phi) => claim
            .say(true, "slides in along −x", "a way in")
            .at(format!("φ = {:.0}°", phi.to_degrees())),
        None => claim.say(
            false,
            format!("blocked at all of {PHASES} driver angles"),
            "a way in",
        ),
    }
}
