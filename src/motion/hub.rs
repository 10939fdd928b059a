//! The follower's hub axis and how often the follower turns about it.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};

use crate::{Error, Result};

/// Body axes that lean by less than this towards the mean axis are taken as the hub axis, rad.
///
/// Every wobble that repeats with the follower's own turn leans its mean axis a little; up to this
/// angle the body's z axis is what the user means by the hub axis.
const ALIGN_ABOVE: f64 = 15.0 * PI / 180.0;

/// Largest tilt of the hub axis against z that a ball in a socket leaves room for, rad.
const MAX_TILT: f64 = 60.0 * PI / 180.0;

/// Body axis that stays closest to Σ's z axis: the mean of the weighted samples of R(φ)ᵀ e_z, of
/// which the weights add up to 1.
///
/// # Errors
/// [`Error::Infeasible`] when no body axis stays near z.
pub(super) fn mean_direction(samples: impl Iterator<Item = Vector3<f64>>) -> Result<Vector3<f64>> {
    let mean: Vector3<f64> = samples.sum();
    if mean.norm() < MAX_TILT.cos() {
        return Err(Error::Infeasible {
            reason: "no hub axis: no axis of the follower stays near the driver's axis".to_owned(),
            place: "whole period".to_owned(),
            hint: format!(
                "let the follower turn once per period about an axis that stays within {:.0}° of z",
                MAX_TILT.to_degrees()
            ),
        });
    }
    Ok(mean.normalize())
}

/// Rotation of the body frame that puts its z axis onto `hub` (body frame); identity if z is near
/// enough.
pub(super) fn align_to(hub: Vector3<f64>) -> UnitQuaternion<f64> {
    if hub.angle(&Vector3::z()) < ALIGN_ABOVE {
        return UnitQuaternion::identity();
    }
    UnitQuaternion::rotation_between(&Vector3::z(), &hub)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI))
}

/// Turn about z along the rotations, counted on beyond whole turns, rad; each step must be less than
/// half a turn. The first is between −π and π.
pub(super) fn unwrapped(
    rotations: impl Iterator<Item = UnitQuaternion<f64>>,
) -> impl Iterator<Item = f64> {
    rotations.scan(0.0, |turn, q| {
        let twist = 2.0 * q.k.atan2(q.w);
        *turn += (twist - *turn + PI).rem_euclid(TAU) - PI;
        Some(*turn)
    })
}

/// Turns about z from the first to the last of the rotations, in periods; steps as in [`unwrapped`].
pub(super) fn net_turns(rotations: impl Iterator<Item = UnitQuaternion<f64>>) -> f64 {
    let mut turns = unwrapped(rotations);
    let first = turns.next().unwrap_or(0.0);
    (turns.last().unwrap_or(first) - first) / TAU
}

/// The follower must turn −1 times per driver turn.
pub(super) fn net_turn_error(turns: f64) -> Error {
    Error::Infeasible {
        reason: format!(
            "net turn: the follower makes {:+.0} turns about its mean axis per driver turn, it must make −1",
            turns.round() + 0.0
        ),
        place: "whole period".to_owned(),
        hint: "a gear pair turns its gears in opposite directions: let the follower make one turn \
               of −φ per period, with the wanted wobble on top"
            .to_owned(),
    }
}

/// The hub axis leans too far.
pub(super) fn tilt_error(tilt: f64, phi: f64) -> Option<Error> {
    (tilt > MAX_TILT).then(|| Error::Infeasible {
        reason: format!(
            "tilt: the follower's axis leans by {:.1}° against z, possible are {:.0}°",
            tilt.to_degrees(),
            MAX_TILT.to_degrees()
        ),
        place: format!("φ = {:.1}°", phi.to_degrees()),
        hint: "reduce the tilt".to_owned(),
    })
}
