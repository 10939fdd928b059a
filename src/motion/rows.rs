//! Poses at increasing phases, checked, and the smooth periodic motion through them.

use std::f64::consts::TAU;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::expression::Expression;
use super::hub::{align_to, mean_direction, net_turn_error, net_turns};
use super::jet::{PoseJet, about_z, compose};
use super::spline::PeriodicSpline;
use crate::{Error, Problem, Problems, Result};

/// Between two rows the follower may wobble by at most this much per rad of φ (rad/rad) …
const JUMP_TURN_RATE: f64 = 4.0;
/// … or this much in all (rad), whichever is larger …
const JUMP_TURN_MIN: f64 = 0.05;
/// … but never more than this: beyond it the way between the two poses is a guess (rad).
const JUMP_TURN_MAX: f64 = 2.2;
/// The same for the translation, mm/rad: a stroke of 30 mm once per turn still passes.
const JUMP_MOVE_RATE: f64 = 15.0;
/// … and mm.
const JUMP_MOVE_MIN: f64 = 0.5;
/// Closest two rows may be, rad; closer ones make the spline ill-conditioned.
const MIN_STEP: f64 = 1e-6;

/// One pose as given: where it stands in the input, phase (rad), position (mm), rotation.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub place: String,
    pub phi: f64,
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
}

impl Row {
    /// Checks one row of numbers `[phi_deg, x, y, z, qw, qx, qy, qz]`.
    pub(super) fn checked(place: String, numbers: &[f64; 8]) -> std::result::Result<Row, Problem> {
        const NAMES: [&str; 8] = ["phi_deg", "x", "y", "z", "qw", "qx", "qy", "qz"];
        if let Some(i) = numbers.iter().position(|v| !v.is_finite()) {
            let what = format!("{} is {}, not a finite number", NAMES[i], numbers[i]);
            return Err(Problem::new(place, what, ""));
        }
        let [phi_deg, x, y, z, w, i, j, k] = *numbers;
        let q = Quaternion::new(w, i, j, k);
        let length = q.norm();
        if length < 1e-9 {
            let what = "the quaternion has length zero";
            let hint = "no rotation is qw,qx,qy,qz = 1,0,0,0";
            return Err(Problem::new(place, what, hint));
        }
        if (length - 1.0).abs() > 0.01 {
            let what = format!("the quaternion has length {length:.4}, allowed 0.99 to 1.01");
            let hint = "the order is qw,qx,qy,qz; normalise it";
            return Err(Problem::new(place, what, hint));
        }
        Ok(Row {
            place,
            phi: phi_deg.to_radians(),
            position: Vector3::new(x, y, z),
            rotation: UnitQuaternion::new_normalize(q),
        })
    }
}

/// Smooth motion through rows: W(φ)·own turn, with the parts of W and the position as splines.
#[derive(Debug, Clone)]
pub(super) struct RowShape {
    own_turn: Expression,
    /// Takes the body frame to the frame that turns about z; see [`super::hub`].
    align: UnitQuaternion<f64>,
    /// (w, x, y, z) of W on one hemisphere, then the position.
    spline: PeriodicSpline<7>,
}

impl RowShape {
    /// Interpolates one period of `rows`, the first of which must not be repeated at the end.
    pub(super) fn new(rows: &[Row], own_turn: Expression) -> Result<RowShape> {
        let problem = |list: Problems| Error::input("motion", list);
        let problems = order_problems(rows);
        if !problems.is_empty() {
            return Err(problem(problems));
        }
        let weights = weights(rows);
        let axes = rows
            .iter()
            .zip(&weights)
            .map(|(row, weight)| (row.rotation.inverse() * Vector3::z()) * *weight);
        let align = align_to(mean_direction(axes)?);
        let mut wobble: Vec<UnitQuaternion<f64>> = rows
            .iter()
            .map(|row| {
                let own = own_turn.at(row.phi).re;
                row.rotation * align * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -own)
            })
            .collect();
        let problems = jumps(rows, &wobble);
        if !problems.is_empty() {
            return Err(problem(problems));
        }
        let turns = net_turns(wobble.iter().chain(wobble.first()).copied());
        let own_turns = (own_turn.at(rows[0].phi + TAU).re - own_turn.at(rows[0].phi).re) / TAU;
        if turns.abs() > 0.5 {
            return Err(net_turn_error(turns + own_turns));
        }
        for i in 1..wobble.len() {
            if wobble[i].dot(&wobble[i - 1]) < 0.0 {
                wobble[i] = UnitQuaternion::new_unchecked(-wobble[i].into_inner());
            }
        }
        let values: Vec<[f64; 7]> = rows
            .iter()
            .zip(&wobble)
            .map(|(row, q)| {
                let p = row.position;
                [q.w, q.i, q.j, q.k, p.x, p.y, p.z]
            })
            .collect();
        let knots: Vec<f64> = rows.iter().map(|row| row.phi).collect();
        let spline = PeriodicSpline::new(&knots, &values, TAU).ok_or_else(|| {
            let what = "the phases are too unevenly spaced to interpolate";
            let hint = "spread the rows more evenly over the period";
            problem(vec![Problem::new("motion", what, hint)].into())
        })?;
        Ok(RowShape {
            own_turn,
            align,
            spline,
        })
    }

    pub(super) fn at(&self, phi: f64) -> PoseJet {
        let [w, x, y, z, a, b, c] = self.spline.at(phi);
        PoseJet {
            rotation: compose(&[w, x, y, z], &about_z(self.own_turn.at(phi))),
            translation: [a, b, c],
        }
        .turned(&self.align.inverse())
    }
}

/// Share of the period that each row stands for.
fn weights(rows: &[Row]) -> Vec<f64> {
    let n = rows.len();
    (0..n)
        .map(|i| {
            let next = if i + 1 < n {
                rows[i + 1].phi
            } else {
                rows[0].phi + TAU
            };
            let last = if i > 0 {
                rows[i - 1].phi
            } else {
                rows[n - 1].phi - TAU
            };
            (next - last) / (2.0 * TAU)
        })
        .collect()
}

/// Rows that do not increase, or do not fit into one period.
fn order_problems(rows: &[Row]) -> Problems {
    let mut problems = Problems::default();
    for pair in rows.windows(2) {
        if pair[1].phi - pair[0].phi < MIN_STEP {
            problems.add(|| {
                let [before, after] = [pair[0].phi, pair[1].phi].map(f64::to_degrees);
                let what = format!("phi_deg {after:.6} does not increase after {before:.6}");
                let hint = "sort the rows by phi_deg and remove repeated ones";
                Problem::new(&pair[1].place, what, hint)
            });
        }
    }
    if let (Some(first), Some(last)) = (rows.first(), rows.last())
        && problems.is_empty()
        && last.phi - first.phi > TAU - MIN_STEP
    {
        problems.push(Problem::new(
            &last.place,
            format!(
                "phi_deg runs over {:.3}°, allowed less than one period of 360°",
                (last.phi - first.phi).to_degrees()
            ),
            "give one period only; the pose at its end is the one at its start",
        ));
    }
    problems
}

/// Neighbouring rows (the first follows the last) whose poses are too far apart.
fn jumps(rows: &[Row], wobble: &[UnitQuaternion<f64>]) -> Problems {
    let n = rows.len();
    let mut problems = Problems::default();
    for i in 0..n {
        let next = (i + 1) % n;
        let step = (rows[next].phi - rows[i].phi).rem_euclid(TAU);
        let turn = wobble[i].angle_to(&wobble[next]);
        let travel = (rows[next].position - rows[i].position).norm();
        let turn_limit = (JUMP_TURN_RATE * step).clamp(JUMP_TURN_MIN, JUMP_TURN_MAX);
        let travel_limit = (JUMP_MOVE_RATE * step).max(JUMP_MOVE_MIN);
        let found = if turn > turn_limit {
            format!(
                "turns by {:.1}° beside its own turn, allowed {:.1}°",
                turn.to_degrees(),
                turn_limit.to_degrees()
            )
        } else if travel > travel_limit {
            format!("moves by {travel:.2} mm, allowed {travel_limit:.2} mm")
        } else {
            continue;
        };
        let place = format!("{} to {}", rows[i].place, rows[next].place);
        let what = format!(
            "jump between rows: from φ = {:.2}° to {:.2}° the follower {found}",
            rows[i].phi.to_degrees(),
            rows[next].phi.to_degrees(),
        );
        let hint = "look for a wrong row; a fast transition needs rows in between";
        problems.push(Problem::new(place, what, hint));
    }
    problems
}
