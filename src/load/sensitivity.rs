//! What assembly errors do to form closure and to the follower's pose.
//!
//! The driver's flanks are moved by a small error, and the follower follows to where the largest
//! remaining interference of the contacts is smallest. Each contact point then slides to where
//! both flanks are parallel again, which their curvatures decide.

use nalgebra::{DVector, Matrix2, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::contacts::Configuration;
use super::{Load, Sampling, play};
use crate::closure;
use crate::design::Design;
use crate::motion::Motion;
use crate::{Error, Result};

/// Number of independent errors.
pub(super) const ERRORS: usize = 5;
/// Random errors inside the tolerance box, beside its 2⁵ corners.
const INSIDE: usize = 32;

/// One assembly error, as deviations from the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The driver axis is farther from O by this, mm.
    pub center_distance: f64,
    /// The driver is turned about an axis through its origin parallel to x, rad.
    pub tilt_x: f64,
    /// … and to y, rad.
    pub tilt_y: f64,
    /// The driver is larger by this share.
    pub driver_scale: f64,
    /// The follower is larger by this share.
    pub follower_scale: f64,
}

impl Deviation {
    /// The errors as shares (−1 to 1) of the tolerances of `load`, in the order of the fields.
    pub(super) fn scaled(load: &Load, factors: [f64; ERRORS]) -> Deviation {
        let tilt = load.axis_tilt_error_deg.to_radians();
        let scale = load.scale_error_percent * 1e-2;
        Deviation {
            center_distance: factors[0] * load.center_distance_error_mm,
            tilt_x: factors[1] * tilt,
            tilt_y: factors[2] * tilt,
            driver_scale: factors[3] * scale,
            follower_scale: factors[4] * scale,
        }
    }
}

/// Worst effects of errors within the tolerances of [`Load`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Worst {
    /// Smallest min Q reached.
    pub q_min: f64,
    /// Largest change of the follower's direction, rad.
    pub turn: f64,
    /// Largest displacement of the load point, mm.
    pub point: f64,
    /// Largest loss of flank gap at a contact, mm; more than the clearance jams.
    pub interference: f64,
}

/// Result of the sensitivity analysis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sensitivity {
    /// min Q without errors, at the same phases.
    pub q_min: f64,
    /// All single errors at once, each with its worst sign, from derivatives.
    pub by_derivative: Worst,
    /// Worst of the corners of the tolerance box and random errors inside it.
    pub by_sampling: Worst,
}

/// Effect of one deviation at one angle.
#[derive(Debug, Clone)]
pub(super) struct Effect {
    /// Hold.
    pub q: f64,
    turn: Vector3<f64>,
    point: Vector3<f64>,
    interference: f64,
    /// Loss of flank gap at each contact, mm; the largest is the interference.
    pub losses: Vec<f64>,
}

/// Effect of the errors allowed by `load` on `design`, at the angles of `sampling`.
///
/// # Errors
/// [`Error::Infeasible`] where the follower is not form closed or flanks are parallel beside the
/// contact, so that the contact point is not defined.
pub fn sensitivity(
    design: &Design,
    motion: &Motion,
    load: &Load,
    sampling: Sampling,
) -> Result<Sensitivity> {
    let draws = draws();
    let mut report = Sensitivity {
        q_min: f64::INFINITY,
        by_derivative: Worst {
            q_min: f64::INFINITY,
            ..Worst::default()
        },
        by_sampling: Worst {
            q_min: f64::INFINITY,
            ..Worst::default()
        },
    };
    for phi in sampling.angles() {
        let at = Configuration::at(design, motion, phi)?;
        let point = at.follower.pose.apply(load.point_mm.into());
        let effect = |factors: [f64; ERRORS]| {
            effect(&at, point, &Deviation::scaled(load, factors)).ok_or_else(|| Error::Infeasible {
                reason: "assembly errors cannot be followed".into(),
                place: format!("φ = {:.2}°", phi.to_degrees()),
                hint: "the follower is not form closed here, or two flanks are parallel".into(),
            })
        };
        let exact = effect([0.0; ERRORS])?;
        report.q_min = report.q_min.min(exact.q);

        // Derivative along each error from both sides: the follower's answer has kinks.
        let mut sum = Worst {
            q_min: exact.q,
            ..Worst::default()
        };
        for i in 0..ERRORS {
            const STEP: f64 = 1e-3;
            let side = |step: f64| effect(std::array::from_fn(|j| if i == j { step } else { 0.0 }));
            let (up, down) = (side(STEP)?, side(-STEP)?);
            let worse = |get: &dyn Fn(&Effect) -> f64| get(&up).max(get(&down)) / STEP;
            sum.q_min -= worse(&|e| exact.q - e.q).max(0.0);
            sum.turn += worse(&|e| e.turn.norm());
            sum.point += worse(&|e| e.point.norm());
            sum.interference += worse(&|e| e.interference).max(0.0);
        }
        report.by_derivative.take(&sum);
        for factors in &draws {
            let e = effect(*factors)?;
            report.by_sampling.take(&Worst {
                q_min: e.q,
                turn: e.turn.norm(),
                point: e.point.norm(),
                interference: e.interference,
            });
        }
    }
    Ok(report)
}

impl Worst {
    fn take(&mut self, other: &Worst) {
        self.q_min = self.q_min.min(other.q_min);
        self.turn = self.turn.max(other.turn);
        self.point = self.point.max(other.point);
        self.interference = self.interference.max(other.interference);
    }
}

/// Corners of the box [−1, 1]⁵ and random points inside.
fn draws() -> Vec<[f64; ERRORS]> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let corners = (0..1u32 << ERRORS)
        .map(|bits| std::array::from_fn(|i| if bits >> i & 1 == 1 { 1.0 } else { -1.0 }));
    let inside: Vec<[f64; ERRORS]> = (0..INSIDE)
        .map(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
        .collect();
    corners.chain(inside).collect()
}

/// Flank displacement of driver minus follower at `p`, and turn of the driver.
fn displacement(
    at: &Configuration,
    p: Vector3<f64>,
    e: &Deviation,
) -> (Vector3<f64>, Vector3<f64>) {
    // The driver turns about z through (−L, 0, 0), so it would carry O with (0, ω₁ L, 0).
    let arm = p + Vector3::x() * (at.driver.v_origin.y / at.driver.omega.z);
    let turn = Vector3::new(e.tilt_x, e.tilt_y, 0.0);
    let driver = -Vector3::x() * e.center_distance + turn.cross(&arm) + arm * e.driver_scale;
    (driver - (p - at.centre) * e.follower_scale, turn)
}

/// The effect of `e` at `at`; `None` where the follower cannot answer.
pub(super) fn effect(at: &Configuration, point: Vector3<f64>, e: &Deviation) -> Option<Effect> {
    let columns = play::columns(at);
    let pushes: Vec<f64> = at
        .contacts
        .iter()
        .map(|c| c.n.dot(&displacement(at, c.p, e).0))
        .collect();
    let (xi, interference) = follow(&columns, &pushes)?;
    let losses = columns.iter().zip(&pushes);
    let losses = losses
        .map(|(column, push)| push - column.dot(&xi))
        .collect();
    let (shift, turn) = play::motion(at, &xi);
    let centre = at.centre + shift;

    let mut wrenches = Vec::with_capacity(at.contacts.len());
    for c in &at.contacts {
        let (push, tilt) = displacement(at, c.p, e);
        let answer = shift + turn.cross(&(c.p - at.centre));
        let relative = push - answer;
        let tangential = Vector2::new(relative.dot(&c.tangents[0]), relative.dot(&c.tangents[1]));
        let lean = c.n.cross(&(tilt - turn));
        let lean = Vector2::new(lean.dot(&c.tangents[0]), lean.dot(&c.tangents[1]));
        let both: Matrix2<f64> = c.driver_curvature + c.follower_curvature;
        let slide = both.try_inverse()? * (c.driver_curvature * tangential + lean);
        let bend = c.follower_curvature * slide;
        let in_space = |v: Vector2<f64>| c.tangents[0] * v.x + c.tangents[1] * v.y;
        let p = c.p + answer + in_space(slide);
        let n = (c.n - in_space(bend) + turn.cross(&c.n)).normalize();
        wrenches.push(closure::wrench(at.class, p, n, centre, 1.0));
    }
    Some(Effect {
        q: closure::measure(&wrenches, at.class.dof()),
        turn,
        point: shift + turn.cross(&(point - at.centre)),
        interference,
        losses,
    })
}

/// Where the follower goes when the driver's flank k advances by `pushes`_k: ξ and t with
/// n̄_k·ξ + t ≥ push_k and t smallest.
fn follow(columns: &[DVector<f64>], pushes: &[f64]) -> Option<(DVector<f64>, f64)> {
    use microlp::{ComparisonOp, LinearExpr, OptimizationDirection, Problem};
    let size = pushes.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    let dof = columns.first()?.len();
    if size == 0.0 {
        return Some((DVector::zeros(dof), 0.0));
    }
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let mut program = Problem::new(OptimizationDirection::Minimize);
    let t = program.add_var(1.0, free);
    let xi: Vec<_> = (0..dof).map(|_| program.add_var(0.0, free)).collect();
    for (column, push) in columns.iter().zip(pushes) {
        let mut sum = LinearExpr::empty();
        sum.add(t, 1.0);
        for (i, &x) in xi.iter().enumerate() {
            sum.add(x, column[i]);
        }
        program.add_constraint(sum, ComparisonOp::Ge, push / size);
    }
    let solution = program.solve().ok()?.into_solution().ok()?;
    let answer = DVector::from_iterator(dof, xi.iter().map(|&x| solution.var_value(x) * size));
    Some((answer, solution.var_value(t) * size))
}
