//! Are the joints what they should be: the follower held by its ball or pin, the slider by its guide.

use nalgebra::{DVector, Matrix3, Vector3};
use rayon::prelude::*;

use super::claim::{Claim, Spot};
use super::collide::Placed;
use super::escape::displacement;
use super::hold::Play;
use super::kept::{Images, Kept};
use super::mechanism::Mechanism;
use super::overlap::Part;
use crate::motion::{Class, Pose};
use crate::solid::assembly::Carrier;

/// Phases at which joints are pulled at.
const HOLD_PHASES: usize = 12;

/// Claims about the joints; `joint_play` is the radial play of the joints, mm, `play` what the teeth
/// leave the follower.
pub(super) fn claims(
    parts: &[Part],
    mechanism: &Mechanism,
    (joint_play, play): (f64, &[Play]),
) -> Vec<Claim> {
    let mut claims = vec![follower_retained(parts, mechanism, joint_play)];
    if mechanism.motion.class() == Class::R3T1 {
        claims.push(slider_guided(parts, mechanism, joint_play));
    }
    claims.push(leaning(parts, mechanism, play));
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

/// Whether `moved`, displaced by `by` (Σ) from where it is at `phi`, touches `other`. `images` are those of
/// the other and of the moved one on what both motions keep.
fn touches(
    (moved, other): (&Part, &Part),
    mechanism: &Mechanism,
    (phi, by): (f64, &Pose),
    images: Option<&[Images; 2]>,
) -> bool {
    let displaced = compose(by, &mechanism.pose(moved.body.carrier, phi));
    let seen = mechanism
        .pose(other.body.carrier, phi)
        .inverse_mul(&displaced);
    Placed::new(&other.tree, &moved.tree, seen)
        .keeping(images.map(|[other, moved]| (other, moved)))
        .touch()
}

fn find<'a, 'b>(parts: &'a [Part<'b>], carrier: Carrier) -> Option<&'a Part<'b>> {
    parts.iter().find(|p| p.body.carrier == carrier)
}

/// Pulled in any direction that the joint forbids, the follower must meet what holds it.
fn follower_retained(parts: &[Part], mechanism: &Mechanism, play: f64) -> Claim {
    let claim = Claim::new(
        "joint holds the follower",
        "the follower cannot be pulled out of its joint",
    );
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let directions = match mechanism.motion.class() {
        Class::R1T1 => vec![x, -x, y, -y],
        _ => vec![x, -x, y, -y, z, -z],
    };
    let holder = match mechanism.motion.class() {
        Class::R3T1 => Carrier::Slider,
        _ => Carrier::Support,
    };
    let bodies = (find(parts, Carrier::Follower), find(parts, holder));
    stopped(claim, bodies, mechanism, (&directions, play))
}

/// The slider that carries the ball must have nowhere to go but along its guide.
fn slider_guided(parts: &[Part], mechanism: &Mechanism, play: f64) -> Claim {
    let claim = Claim::new(
        "guide holds the slider",
        "the slider can move along its guide only, at every height of the motion",
    );
    let (x, y) = (Vector3::x(), Vector3::y());
    let bodies = (find(parts, Carrier::Slider), find(parts, Carrier::Support));
    stopped(claim, bodies, mechanism, (&[x, -x, y, -y], play))
}

/// Decides whether a body pulled in each of `directions` is stopped by its holder, all round the turn.
fn stopped(
    claim: Claim,
    bodies: (Option<&Part>, Option<&Part>),
    mechanism: &Mechanism,
    (directions, play): (&[Vector3<f64>], f64),
) -> Claim {
    let (Some(held), Some(holder)) = bodies else {
        return claim.undecided("the bodies of the joint are not all there");
    };
    // Twice the play closes any joint of that play, facets included.
    let size = 2.0 * play + 0.1;
    let free = mechanism
        .motion
        .cycle()
        .phases(HOLD_PHASES)
        .find_map(|phi| {
            let loose = |d: &&Vector3<f64>| {
                !touches((held, holder), mechanism, (phi, &shift(**d * size)), None)
            };
            Some((phi, directions.iter().find(loose)?))
        });
    match free {
        None => claim.say(
            true,
            format!("stopped within {size:.2} mm on all sides"),
            "stopped",
        ),
        Some((phi, d)) => claim
            .say(false, format!("free to move {size:.2} mm"), "stopped")
            .at(Spot::phase(phi).towards(d.as_slice())),
    }
}

/// Under load, and when the motor turns back, the follower leans to the end of its play: nothing but
/// the driver may be in its way there.
fn leaning(parts: &[Part], mechanism: &Mechanism, play: &[Play]) -> Claim {
    let claim = Claim::new(
        "room for the play",
        "leaning to either end of its play, as turning back makes it, the follower touches teeth only",
    );
    let Some(follower) = find(parts, Carrier::Follower) else {
        return claim.undecided("the follower is missing");
    };
    let others: Vec<&Part> = parts
        .iter()
        .filter(|p| !matches!(p.body.carrier, Carrier::Follower | Carrier::Driver))
        .collect();
    let class = mechanism.motion.class();
    // Leaning is a motion that the joint allows: it keeps what the joint keeps.
    let images = others.iter().map(|other| {
        let kept = Kept::by((other.body.carrier, Carrier::Follower), mechanism)?;
        Some([*other, follower].map(|part| kept.images(&part.tree)))
    });
    let images: Vec<Option<[Images; 2]>> = images.collect();
    let known: Vec<(&Play, f64)> = play.iter().filter_map(|p| Some((p, p.distance?))).collect();
    if known.is_empty() {
        return claim.undecided("the play could not be measured");
    }
    let hits: Vec<Option<&Play>> = known
        .par_iter()
        .map(|&(p, distance)| {
            let lean = |other: &Part| {
                let mut u = DVector::from_column_slice(&p.direction) * distance;
                // The slider goes along in its free direction.
                if other.body.carrier == Carrier::Slider {
                    u[0] = 0.0;
                }
                displacement(class, &u, mechanism.motion.joint_centre(p.phi))
            };
            others
                .iter()
                .zip(&images)
                .any(|(other, images)| {
                    touches(
                        (follower, other),
                        mechanism,
                        (p.phi, &lean(other)),
                        images.as_ref(),
                    )
                })
                .then_some(p)
        })
        .collect();
    let hits: Vec<&Play> = hits.into_iter().flatten().collect();
    let figure = format!("{} of {} touch something", hits.len(), known.len());
    let claim = claim.say(hits.is_empty(), figure, "0");
    match hits.first() {
        Some(p) => claim.at(Spot::phase(p.phi).towards(&p.direction)),
        None => claim,
    }
}
