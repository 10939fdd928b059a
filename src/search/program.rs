//! The linear program of one step of the polish: all design variables move at once, within a trust
//! region, so that the smallest hold grows most while every limit is kept to first order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};

/// Set when the work has to end.
pub(super) type Stop = Arc<AtomicBool>;

/// A quantity and its change by the design variables (index, per natural size).
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub value: f64,
    pub slope: Vec<(usize, f64)>,
}

impl Row {
    /// Least value within a step of `step` natural sizes.
    fn least(&self, step: f64) -> f64 {
        self.value - step * self.slope.iter().map(|s| s.1.abs()).sum::<f64>()
    }

    fn after(&self, moves: &[f64]) -> f64 {
        self.slope
            .iter()
            .fold(self.value, |sum, &(v, by)| sum + by * moves[v])
    }
}

/// What a step has to heed.
#[derive(Debug, Default)]
pub(super) struct Program {
    /// Number of design variables.
    pub variables: usize,
    /// Distances of facets from zero: the least of them is the hold.
    pub holds: Vec<Row>,
    /// Slacks of limits.
    pub limits: Vec<Row>,
}

/// A step and what the program expects of it.
#[derive(Debug)]
pub(super) struct Step {
    /// Of all design variables, in natural sizes.
    pub moves: Vec<f64>,
    /// Expected hold.
    pub hold: f64,
    /// Expected worst violation of a limit.
    pub violation: f64,
}

impl Program {
    /// The best step of at most `step` natural sizes in each variable, when a violation of 1 costs as much
    /// as a hold of `price`; `None` when the solver gives up.
    ///
    /// Few of the rows matter: those that a small part of the step could reach are heeded first, then
    /// those that turn out to be missed.
    /// It gives up as well as soon as it is told to `stop`.
    pub fn solve(&self, (step, price): (f64, f64), stop: &Stop) -> Option<Step> {
        let least = self.holds.iter().map(|row| row.value).reduce(f64::min)?;
        let reached = |row: &Row, from: f64, share: f64| row.least(share * step) < from;
        let mut holds: Vec<bool> = self
            .holds
            .iter()
            .map(|r| reached(r, least, FIRST))
            .collect();
        let mut limits: Vec<bool> = self.limits.iter().map(|r| reached(r, 0.0, FIRST)).collect();
        for _ in 0..ROUNDS {
            let found = self.relaxed((&holds, &limits), (step, price), stop)?;
            let (hold, violation) = (found.hold, found.violation);
            let mut missed = 0;
            let mut heed = |rows: &[Row], heeded: &mut [bool], from: f64| {
                for (row, heeded) in rows.iter().zip(heeded) {
                    if !*heeded && row.after(&found.moves) < from {
                        *heeded = true;
                        missed += 1;
                    }
                }
            };
            heed(&self.holds, &mut holds, hold - SLIGHT * price);
            heed(&self.limits, &mut limits, -violation - SLIGHT);
            if missed == 0 {
                return Some(found);
            }
        }
        let mut found = self.relaxed((&holds, &limits), (step, price), stop)?;
        let least = |rows: &[Row]| {
            let after = rows.iter().map(|row| row.after(&found.moves));
            after.fold(f64::INFINITY, f64::min)
        };
        (found.hold, found.violation) = (least(&self.holds), (-least(&self.limits)).max(0.0));
        Some(found)
    }

    /// [`Program::solve`] with some of the rows.
    fn relaxed(
        &self,
        (holds, limits): (&[bool], &[bool]),
        (step, price): (f64, f64),
        stop: &Stop,
    ) -> Option<Step> {
        // Variables: the moves in units of the step, the hold, the worst violation.
        let (n, hold, violation) = (self.variables + 2, self.variables, self.variables + 1);
        let mut matrix = Matrix::default();
        let heeded = |rows: &'_ [Row], heeded: &'_ [bool]| -> Vec<usize> {
            (0..rows.len()).filter(|&i| heeded[i]).collect()
        };
        for i in heeded(&self.holds, holds) {
            let row = &self.holds[i];
            let slope = row.slope.iter().map(|&(v, by)| (v, -by * step));
            matrix.push(slope.chain([(hold, 1.0)]), row.value);
        }
        for i in heeded(&self.limits, limits) {
            let row = &self.limits[i];
            let slope = row.slope.iter().map(|&(v, by)| (v, -by * step));
            matrix.push(slope.chain([(violation, -1.0)]), row.value);
        }
        for v in 0..self.variables {
            matrix.push([(v, 1.0)], 1.0);
            matrix.push([(v, -1.0)], 1.0);
        }
        matrix.push([(violation, -1.0)], 0.0);
        let mut cost = vec![0.0; n];
        cost[hold] = -1.0;
        cost[violation] = price;
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(60)
            .tol_gap_abs(1e-4)
            .tol_gap_rel(1e-4)
            .tol_feas(1e-5)
            .build()
            .ok()?;
        let (rows, bound) = (matrix.bound.len(), matrix.bound);
        let a = CscMatrix::new_from_triplets(rows, n, matrix.rows, matrix.columns, matrix.values);
        let cones = [NonnegativeConeT(rows)];
        let quadratic = CscMatrix::zeros((n, n));
        let mut solver =
            DefaultSolver::new(&quadratic, &cost, &a, &bound, &cones, settings).ok()?;
        let stop = Arc::clone(stop);
        solver.set_termination_callback(move |_| stop.load(Relaxed));
        solver.solve();
        let solution = &solver.solution;
        let solved = matches!(
            solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        );
        let moves = solution.x[..self.variables].iter();
        solved.then(|| Step {
            moves: moves.map(|x| x.clamp(-1.0, 1.0) * step).collect(),
            hold: solution.x[hold],
            violation: solution.x[violation].max(0.0),
        })
    }
}

/// Share of the step that a row has to be within to be heeded at first, and rounds of heeding more.
const FIRST: f64 = 0.15;
const ROUNDS: usize = 4;

/// Violation that is not worth another round.
const SLIGHT: f64 = 1e-4;

/// A sparse matrix as triplets, with the bounds of its rows.
#[derive(Default)]
struct Matrix {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    bound: Vec<f64>,
}

impl Matrix {
    fn push(&mut self, row: impl IntoIterator<Item = (usize, f64)>, bound: f64) {
        for (column, value) in row {
            self.rows.push(self.bound.len());
            self.columns.push(column);
            self.values.push(value);
        }
        self.bound.push(bound);
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    fn row(value: f64, slope: &[(usize, f64)]) -> Row {
        Row {
            value,
            slope: slope.to_vec(),
        }
    }

    #[test]
    fn the_least_hold_grows_until_a_limit_stops_it() {
        // min(1 + x, 1 + 2y) with 0.3 − x ≥ 0 and steps of at most 1: x = 0.3, y ≥ 0.15.
        let program = Program {
            variables: 2,
            holds: vec![row(1.0, &[(0, 1.0)]), row(1.0, &[(1, 2.0)])],
            limits: vec![row(0.3, &[(0, -1.0)]), row(100.0, &[(1, -1.0)])],
        };
        let found = program.solve((1.0, 10.0), &Stop::default()).unwrap();
        assert_abs_diff_eq!(found.hold, 1.3, epsilon = 1e-3);
        assert_abs_diff_eq!(found.moves[0], 0.3, epsilon = 1e-3);
        assert!(
            found.moves[1] > 0.149 && found.violation < 1e-3,
            "{found:?}"
        );
        // A short step is all that there is.
        let found = program.solve((0.1, 10.0), &Stop::default()).unwrap();
        assert_abs_diff_eq!(found.hold, 1.1, epsilon = 1e-3);
    }

    #[test]
    fn a_violation_is_paid_for() {
        // 1 mm short at the start, mended before anything is gained.
        let program = Program {
            variables: 1,
            holds: vec![row(1.0, &[(0, 1.0)])],
            limits: vec![row(-1.0, &[(0, -2.0)])],
        };
        let found = program.solve((1.0, 10.0), &Stop::default()).unwrap();
        assert_abs_diff_eq!(found.moves[0], -0.5, epsilon = 1e-3);
        assert_abs_diff_eq!(found.violation, 0.0, epsilon = 1e-3);
        // At a low price the hold is worth more.
        let found = program.solve((1.0, 0.1), &Stop::default()).unwrap();
        assert_abs_diff_eq!(found.moves[0], 1.0, epsilon = 1e-3);
    }

    #[test]
    fn told_to_stop_it_gives_up() {
        let program = Program {
            variables: 1,
            holds: vec![row(1.0, &[(0, 1.0)])],
            limits: Vec::new(),
        };
        let stop = Stop::default();
        stop.store(true, Relaxed);
        assert!(program.solve((1.0, 1.0), &stop).is_none());
    }
}
