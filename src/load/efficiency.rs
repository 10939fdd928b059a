//! Driver torque with and without friction on the flanks.

use nalgebra::{DVector, Vector3};

use super::contacts::Configuration;
use super::forces::{self, Balance};

/// Sliding slower than this, mm/rad, is rolling: no friction.
const ROLLING: f64 = 1e-6;

/// Driver torque (N·mm) that holds contact forces `forces` acting along `directions` on the follower.
pub fn driver_torque(at: &Configuration, forces: &[f64], directions: &[Vector3<f64>]) -> f64 {
    let power: f64 = at
        .contacts
        .iter()
        .zip(forces.iter().zip(directions))
        .map(|(c, (f, d))| f * d.dot(&at.driver.velocity(c.p)))
        .sum();
    power / at.driver.omega.z
}

/// Directions of the contact forces on the follower when it slides against the driver with
/// friction coefficient `friction`: n − μ·v_rel/|v_rel|. Not unit: f counts the normal part.
pub fn with_friction(at: &Configuration, friction: f64) -> Vec<Vector3<f64>> {
    at.contacts
        .iter()
        .map(|c| {
            let sliding = at.sliding(c.p);
            let speed = sliding.norm();
            if speed > ROLLING {
                c.n - sliding * (friction / speed)
            } else {
                c.n
            }
        })
        .collect()
}

/// Balance and driver torque under `load` with friction; `None` when the mechanism jams, that is
/// when no forces balance the load while sliding forwards.
pub fn sliding_balance(
    at: &Configuration,
    load: &DVector<f64>,
    (friction, lengths): (f64, &DVector<f64>),
) -> Option<(Balance, f64)> {
    let directions = with_friction(at, friction);
    let columns: Vec<DVector<f64>> = at
        .contacts
        .iter()
        .zip(&directions)
        .map(|(c, d)| at.class.project(c.p, *d, at.centre))
        .collect();
    let balance = forces::smallest_largest(&columns, load, lengths)?;
    let torque = driver_torque(at, &balance.forces, &directions);
    Some((balance, torque))
}
