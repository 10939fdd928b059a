//! Checks of a finished motion, whatever kind it came from: sampled over one period.

use nalgebra::Vector3;

use super::{Class, Cycle, MotionState, hub};
use crate::{Error, Problem, Result};

/// Samples per period.
pub(super) const SAMPLES: usize = 720;

/// How far a motion may leave its class's motion space before it is refused; what is left below
/// (rounding of table files) is projected away. mm and rad.
pub(super) const SPACE_MM: f64 = 2e-3;
pub(super) const SPACE_RAD: f64 = 2e-4;

/// How far the pose at φ + 2π may be from the one at φ, mm and rad.
const CLOSING: f64 = 1e-6;

/// Differences between neighbouring samples that no smooth motion of this size shows:
/// of the pose (rad, mm) and of twist (rad/rad, mm/rad) beyond what the twist rate explains.
const POSE_JUMP: (f64, f64) = (0.05, 0.5);
const TWIST_JUMP: (f64, f64) = (0.02, 0.2);

/// Least speed at which a follower has to turn against the driver of a range, per phase.
const SLOWEST: f64 = 0.2;

/// Everything finite, closed, smooth, in the motion space of `class`, with net turn −1; over a range
/// turning against the driver all the way. The mean speed of that.
pub(super) fn check(
    (class, cycle): (Class, Cycle),
    motion: impl Fn(f64) -> MotionState,
) -> Result<f64> {
    let states: Vec<MotionState> = (0..=SAMPLES)
        .map(|i| motion(cycle.part(i, SAMPLES)))
        .collect();
    let mut problems = Vec::new();
    problems.extend(not_finite(cycle, &states));
    if problems.is_empty() {
        if cycle.wraps() {
            problems.extend(not_closed(&states[0], &states[SAMPLES]));
        }
        problems.extend(outside_space((class, cycle), &states));
        problems.extend(not_smooth(cycle, &states));
    }
    if !problems.is_empty() {
        return Err(Error::input("motion", problems));
    }
    let turning = match cycle.wraps() {
        true => net_turn(&states).map(|()| 1.0),
        false => against(cycle, &states),
    }?;
    let worst = largest(&states, tilt);
    match hub::tilt_error(worst.1, cycle.part(worst.0, SAMPLES)) {
        Some(error) => Err(error),
        None => Ok(turning),
    }
}

/// The mean speed at which the follower turns against the driver, where it always does.
fn against(cycle: Cycle, states: &[MotionState]) -> Result<f64> {
    let (i, fastest) = largest(states, |s| s.omega.z);
    if fastest > -SLOWEST {
        return Err(Error::Infeasible {
            reason: format!(
                "the follower turns {:.2} times as fast as the driver about z, it must turn the other way, \
                 −{SLOWEST} times as fast or faster",
                fastest + 0.0
            ),
            place: at(cycle, i),
            hint: "let own_turn fall with phi over the whole range".into(),
        });
    }
    let turns = hub::net_turns(states.iter().map(|s| s.pose.quaternion()));
    Ok(-turns / cycle.share())
}

/// Angle of the body's z axis against that of Σ, rad.
pub(super) fn tilt(state: &MotionState) -> f64 {
    let axis = state.pose.rotation.column(2).into_owned();
    axis.angle(&Vector3::z())
}

fn at(cycle: Cycle, i: usize) -> String {
    format!("φ = {:.1}°", cycle.part(i, SAMPLES).to_degrees())
}

/// Index and value of the largest `measure`.
fn largest(states: &[MotionState], measure: impl Fn(&MotionState) -> f64) -> (usize, f64) {
    states
        .iter()
        .map(measure)
        .enumerate()
        .fold(
            (0, f64::MIN),
            |best, (i, v)| if v > best.1 { (i, v) } else { best },
        )
}

fn not_finite(cycle: Cycle, states: &[MotionState]) -> Option<Problem> {
    let finite = |s: &MotionState| {
        s.pose.rotation.iter().all(|v| v.is_finite())
            && [
                s.pose.translation,
                s.omega,
                s.omega_rate,
                s.v_origin,
                s.v_origin_rate,
            ]
            .iter()
            .all(|v| v.iter().all(|x| x.is_finite()))
    };
    let i = states.iter().position(|s| !finite(s))?;
    Some(Problem::new(
        "motion",
        format!("pose or speed is not a finite number at {}", at(cycle, i)),
        "look for a division by zero, or sqrt, ln, asin outside their range",
    ))
}

fn not_closed(first: &MotionState, last: &MotionState) -> Option<Problem> {
    let apart = (last.pose.translation - first.pose.translation).norm();
    let turned = turn_between(first, last);
    let rate = (last.omega - first.omega).norm() + (last.v_origin - first.v_origin).norm();
    let hint = "every expression must repeat after 2π; own_turn must change by −2π";
    if apart > CLOSING || turned > CLOSING {
        let what = format!(
            "the motion does not close: after one period the pose is {apart:.4} mm and {:.3}° off",
            turned.to_degrees()
        );
        return Some(Problem::new("motion", what, hint));
    }
    (rate > CLOSING * 1e3).then(|| {
        let what = "the motion does not close smoothly: its speed differs after one period";
        Problem::new("motion", what, hint)
    })
}

fn turn_between(a: &MotionState, b: &MotionState) -> f64 {
    // Of the small angles only the sine is accurate, of the large ones only the cosine.
    let relative = b.pose.rotation * a.pose.rotation.transpose();
    let sine = Vector3::new(
        relative[(2, 1)] - relative[(1, 2)],
        relative[(0, 2)] - relative[(2, 0)],
        relative[(1, 0)] - relative[(0, 1)],
    )
    .norm()
        / 2.0;
    sine.atan2((relative.trace() - 1.0) / 2.0)
}

/// Leaving the motion space of the class: by how much, and where.
fn outside_space((class, cycle): (Class, Cycle), states: &[MotionState]) -> Vec<Problem> {
    let mut problems = Vec::new();
    if !class.is_spherical() {
        let (i, tilt) = largest(states, tilt);
        if tilt > SPACE_RAD {
            problems.push(Problem::new(
                "motion",
                format!(
                    "tilts by {:.3}° at {}; class {class} turns about z only",
                    tilt.to_degrees(),
                    at(cycle, i)
                ),
                "use class 3R (or 3R1T with a stroke), or remove the tilt",
            ));
        }
    }
    let forbidden = |s: &MotionState| {
        let t = s.pose.translation;
        Vector3::new(t.x, t.y, if class.slides() { 0.0 } else { t.z }).norm()
    };
    let (i, distance) = largest(states, forbidden);
    if distance > SPACE_MM {
        let allowed = if class.slides() {
            "translates along z only"
        } else {
            "does not translate"
        };
        problems.push(Problem::new(
            "motion",
            format!(
                "translates by {distance:.4} mm at {}; class {class} {allowed}",
                at(cycle, i)
            ),
            "put the origin of the follower's frame at the joint's centre; \
             1R1T and 3R1T can move along z",
        ));
    }
    problems
}

/// Jumps of pose or twist, which formulas and corners of a curve can have.
fn not_smooth(cycle: Cycle, states: &[MotionState]) -> Option<Problem> {
    let h = cycle.length() / SAMPLES as f64;
    states.windows(2).enumerate().find_map(|(i, pair)| {
        let (a, b) = (&pair[0], &pair[1]);
        let turn = turn_between(a, b) - h * a.omega.norm().max(b.omega.norm());
        let speed = |s: &MotionState| s.v_origin + s.omega.cross(&s.pose.translation);
        let travel = (b.pose.translation - a.pose.translation).norm()
            - h * speed(a).norm().max(speed(b).norm());
        let rest = |x: Vector3<f64>, y: Vector3<f64>, dx: Vector3<f64>, dy: Vector3<f64>| {
            (y - x - (dx + dy) * (h / 2.0)).norm()
        };
        let omega = rest(a.omega, b.omega, a.omega_rate, b.omega_rate);
        let v = rest(a.v_origin, b.v_origin, a.v_origin_rate, b.v_origin_rate);
        let what = if turn > POSE_JUMP.0 || travel > POSE_JUMP.1 {
            "pose"
        } else if omega > TWIST_JUMP.0 || v > TWIST_JUMP.1 {
            "speed"
        } else {
            return None;
        };
        Some(Problem::new(
            "motion",
            format!(
                "the {what} jumps between {} and {}",
                at(cycle, i),
                at(cycle, i + 1)
            ),
            "gears need a smooth motion: round the corner off",
        ))
    })
}

fn net_turn(states: &[MotionState]) -> Result<()> {
    let turns = hub::net_turns(states.iter().map(|s| s.pose.quaternion()));
    if (turns + 1.0).abs() < 0.5 {
        Ok(())
    } else {
        Err(hub::net_turn_error(turns))
    }
}
