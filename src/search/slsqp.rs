//! Sequential quadratic programming (NLopt's SLSQP, Kraft 1988) behind a guard.
//!
//! The solver's verdict is not taken at its word: the best point is our own record of everything it
//! evaluated, and its feasibility is what we saw there. NaN and panics never reach the solver, which
//! would loop on the one and be undefined on the other.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use nlopt::{Algorithm, FailState, Nlopt, SuccessState, Target};

/// Smooth program: minimise a value subject to constraints ≤ 0.
pub trait Program {
    /// Number of variables.
    fn variables(&self) -> usize;

    /// Number of constraints.
    fn constraints(&self) -> usize;

    /// Evaluates everything at `x` into `at`, which is zeroed and of the right sizes.
    fn evaluate(&self, x: &[f64], at: &mut Evaluation);
}

/// A program's values and derivatives at one point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Evaluation {
    /// Objective.
    pub value: f64,
    /// Derivative of the objective by each variable.
    pub gradient: Vec<f64>,
    /// Constraints; satisfied where ≤ 0.
    pub constraints: Vec<f64>,
    /// Derivative of constraint i by variable k at `i * variables + k`.
    pub jacobian: Vec<f64>,
}

impl Evaluation {
    fn is_finite(&self) -> bool {
        self.value.is_finite()
            && [&self.gradient, &self.constraints, &self.jacobian]
                .iter()
                .all(|v| v.iter().all(|x| x.is_finite()))
    }

    fn violation(&self) -> f64 {
        self.constraints.iter().copied().fold(0.0, f64::max)
    }
}

/// Evaluates `program` at `x`.
pub fn evaluate(program: &dyn Program, x: &[f64]) -> Evaluation {
    let mut at = Evaluation {
        value: 0.0,
        gradient: vec![0.0; program.variables()],
        constraints: vec![0.0; program.constraints()],
        jacobian: vec![0.0; program.constraints() * program.variables()],
    };
    program.evaluate(x, &mut at);
    at
}

/// Where to start and within which bounds (infinite where there is none).
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// First point; moved into the bounds.
    pub x: Vec<f64>,
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Stop when a step changes every variable by less than this. Default 1e-9.
    pub step: f64,
    /// Stop when a step changes the objective by less than this. Default 1e-12.
    pub value: f64,
    /// Stop after this many evaluations. Default 400.
    pub evaluations: u32,
    /// Stop after this long, s: a safety net, because it makes the result depend on the machine. Default 60.
    pub seconds: f64,
    /// Largest constraint value that counts as feasible. Default 1e-7.
    pub feasible: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            step: 1e-9,
            value: 1e-12,
            evaluations: 400,
            seconds: 60.0,
            feasible: 1e-7,
        }
    }
}

/// Why a solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StopReason {
    /// Steps or gains fell below the limits.
    Converged,
    /// The limit of evaluations was reached.
    Evaluations,
    /// The time limit was reached.
    Time,
    /// Round-off stopped the progress.
    Roundoff,
    /// The program was not finite at the start.
    NotFinite,
    /// The program panicked: a defect of ours.
    Panicked,
    /// The solver refused the program or ran out of memory.
    Failed,
}

impl std::fmt::Display for StopReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            StopReason::Converged => "converged",
            StopReason::Evaluations => "evaluation limit reached",
            StopReason::Time => "time limit reached",
            StopReason::Roundoff => "stopped by round-off",
            StopReason::NotFinite => "not finite at the start",
            StopReason::Panicked => "objective panicked",
            StopReason::Failed => "solver failed",
        })
    }
}

/// What a solver found.
#[derive(Debug, Clone, PartialEq)]
pub struct Report<T> {
    /// Best point: of the feasible ones that with the least objective, else the least infeasible.
    pub best: T,
    /// Objective there; NaN when the program was not finite at the start.
    pub value: f64,
    /// Largest constraint value there, at least 0; NaN as above.
    pub worst_violation: f64,
    /// Why it stopped.
    pub stop: StopReason,
    /// Number of evaluations.
    pub evaluations: usize,
}

impl<T> Report<T> {
    /// Same report about something made of the best point.
    pub fn map<U>(self, make: impl FnOnce(T) -> U) -> Report<U> {
        Report {
            best: make(self.best),
            value: self.value,
            worst_violation: self.worst_violation,
            stop: self.stop,
            evaluations: self.evaluations,
        }
    }
}

/// Value shown to the solver where the program is not finite: a wall that its line search backs off
/// from. Squares of it must not overflow.
const WALL: f64 = 1e20;

/// Everything evaluated so far; the solver asks for objective and constraints one after the other.
struct Record<'a> {
    program: &'a dyn Program,
    feasible: f64,
    last: Option<(Vec<f64>, Evaluation)>,
    best: Option<(Vec<f64>, f64, f64)>,
    evaluations: usize,
    panicked: bool,
}

impl Record<'_> {
    fn at(&mut self, x: &[f64]) -> &Evaluation {
        let fresh = match self.last.take() {
            Some((seen, at)) if seen == x => at,
            _ => self.evaluate(x),
        };
        &self.last.insert((x.to_vec(), fresh)).1
    }

    fn evaluate(&mut self, x: &[f64]) -> Evaluation {
        let (n, m) = (self.program.variables(), self.program.constraints());
        let wall = |value: f64| Evaluation {
            value,
            gradient: vec![0.0; n],
            constraints: vec![value; m],
            jacobian: vec![0.0; n * m],
        };
        // After a panic all is flat and feasible, which ends the solver's work.
        if self.panicked {
            return wall(0.0);
        }
        self.evaluations += 1;
        let program = self.program;
        let Ok(at) = catch_unwind(AssertUnwindSafe(|| evaluate(program, x))) else {
            self.panicked = true;
            return wall(0.0);
        };
        if !at.is_finite() {
            return wall(WALL);
        }
        let violation = at.violation();
        let better = self.best.as_ref().is_none_or(|(_, value, worst)| {
            match (violation <= self.feasible, *worst <= self.feasible) {
                (true, true) => at.value < *value,
                (false, false) => violation < *worst,
                (here, _) => here,
            }
        });
        if better {
            self.best = Some((x.to_vec(), at.value, violation));
        }
        at
    }
}

/// Minimises `program` from `start`. Every call makes its own solver; the result is never worse than
/// the start.
pub fn minimise(program: &dyn Program, start: &Start, limits: &Limits) -> Report<Vec<f64>> {
    let (n, m) = (program.variables(), program.constraints());
    let mut x: Vec<f64> = start
        .x
        .iter()
        .zip(start.lower.iter().zip(&start.upper))
        .map(|(x, (low, high))| x.max(*low).min(*high))
        .collect();
    let record = RefCell::new(Record {
        program,
        feasible: limits.feasible,
        last: None,
        best: None,
        evaluations: 0,
        panicked: false,
    });
    let sized = n > 0 && x.len() == n && start.x.len() == n && x.iter().all(|v| v.is_finite());
    if sized {
        record.borrow_mut().at(&x);
    }
    let (seen, panicked) = (record.borrow().best.is_some(), record.borrow().panicked);
    let stop = if panicked {
        StopReason::Panicked
    } else if !sized || !seen {
        StopReason::NotFinite
    } else {
        let stop = run(&record, start, limits, &mut x, m);
        if record.borrow().panicked {
            StopReason::Panicked
        } else {
            stop
        }
    };
    let record = record.into_inner();
    let (best, value, worst_violation) = record.best.unwrap_or((x, f64::NAN, f64::NAN));
    Report {
        best,
        value,
        worst_violation,
        stop,
        evaluations: record.evaluations,
    }
}

fn run(
    record: &RefCell<Record<'_>>,
    start: &Start,
    limits: &Limits,
    x: &mut [f64],
    m: usize,
) -> StopReason {
    let objective = |x: &[f64], gradient: Option<&mut [f64]>, _: &mut ()| {
        let mut record = record.borrow_mut();
        let at = record.at(x);
        if let Some(g) = gradient {
            g.copy_from_slice(&at.gradient);
        }
        at.value
    };
    let constraints = |values: &mut [f64], x: &[f64], jacobian: Option<&mut [f64]>, _: &mut ()| {
        let mut record = record.borrow_mut();
        let at = record.at(x);
        values.copy_from_slice(&at.constraints);
        if let Some(j) = jacobian {
            j.copy_from_slice(&at.jacobian);
        }
    };
    let mut solver = Nlopt::new(Algorithm::Slsqp, x.len(), objective, Target::Minimize, ());
    let mut prepare = || {
        solver.set_lower_bounds(&start.lower)?;
        solver.set_upper_bounds(&start.upper)?;
        if m > 0 {
            solver.add_inequality_mconstraint(m, constraints, (), &vec![limits.feasible; m])?;
        }
        solver.set_xtol_abs1(limits.step)?;
        solver.set_ftol_abs(limits.value)?;
        solver.set_maxeval(limits.evaluations.max(1))?;
        solver.set_maxtime(limits.seconds.max(1e-3))
    };
    if prepare().is_err() {
        return StopReason::Failed;
    }
    match solver.optimize(x) {
        Ok((SuccessState::MaxEvalReached, _)) => StopReason::Evaluations,
        Ok((SuccessState::MaxTimeReached, _)) => StopReason::Time,
        Ok(_) => StopReason::Converged,
        Err((FailState::RoundoffLimited, _)) => StopReason::Roundoff,
        Err(_) => StopReason::Failed,
    }
}
