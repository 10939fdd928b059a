//! Contact forces that hold a load: small linear programs over the contacts' projected normals.

use microlp::{ComparisonOp, LinearExpr, OptimizationDirection, Problem, Variable};
use nalgebra::{DMatrix, DVector};

/// Contact forces in equilibrium with a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// f_k ≥ 0, N.
    pub forces: Vec<f64>,
    /// Largest f_k, N.
    pub largest: f64,
    /// Norm of the equilibrium error in span(U), relative to the norm of the load.
    pub residual: f64,
}

/// Largest relative equilibrium error that counts as equilibrium.
const EQUILIBRIUM: f64 = 1e-9;
/// A force this close to a bound, relative to the largest, is at the bound.
const AT_BOUND: f64 = 1e-6;
/// A weight of one kilogram that loads the joint with less, N, does not load it.
const WEIGHTLESS: f64 = 1e-9;

/// Forces f ≥ 0 with Σ f_k `columns`_k = −`load` whose largest is smallest; `None` when the
/// contacts cannot hold the load, or no solution in equilibrium to 1e-9 was found.
///
/// `lengths` scales each row of the equilibrium (mm for moments, 1 for forces) so that the program
/// is well conditioned.
pub fn smallest_largest(
    columns: &[DVector<f64>],
    load: &DVector<f64>,
    lengths: &DVector<f64>,
) -> Option<Balance> {
    let scaled_load = load.component_div(lengths);
    let size = scaled_load.norm();
    if size == 0.0 {
        return Some(Balance {
            forces: vec![0.0; columns.len()],
            largest: 0.0,
            residual: 0.0,
        });
    }
    let scaled: Vec<DVector<f64>> = columns.iter().map(|c| c.component_div(lengths)).collect();
    let goal = -scaled_load / size;
    let mut program = Problem::new(OptimizationDirection::Minimize);
    let largest = program.add_var(1.0, (0.0, f64::INFINITY));
    let forces: Vec<Variable> = scaled
        .iter()
        .map(|_| program.add_var(0.0, (0.0, f64::INFINITY)))
        .collect();
    for &f in &forces {
        program.add_constraint([(f, 1.0), (largest, -1.0)], ComparisonOp::Le, 0.0);
    }
    equilibrium(&mut program, (&forces, &scaled), goal.as_slice());
    let solution = program.solve().ok()?.into_solution().ok()?;
    let f: Vec<f64> = forces.iter().map(|&v| solution.var_value(v)).collect();
    let f = sharpen(&scaled, &goal, &f)?;

    let residual = (scaled
        .iter()
        .zip(&f)
        .map(|(c, f)| c * *f)
        .sum::<DVector<f64>>()
        - goal)
        .norm();
    let forces: Vec<f64> = f.iter().map(|f| f * size).collect();
    (residual <= EQUILIBRIUM).then(|| Balance {
        largest: forces.iter().copied().fold(0.0, f64::max),
        forces,
        residual,
    })
}

/// Largest m ≥ 0 for which `fixed` + m·`unit` is held by forces of at most `limit`; infinite when
/// `unit` needs no force at all, `None` when even m = 0 is too much.
pub fn largest_payload(
    columns: &[DVector<f64>],
    (unit, fixed): (&DVector<f64>, &DVector<f64>),
    lengths: &DVector<f64>,
    limit: f64,
) -> Option<f64> {
    let size = unit.component_div(lengths).norm();
    let mut program = Problem::new(OptimizationDirection::Maximize);
    // Forces in units of the limit, payload in units that load the joint with the limit.
    let payload = program.add_var(1.0, (0.0, f64::INFINITY));
    let scaled: Vec<DVector<f64>> = columns.iter().map(|c| c.component_div(lengths)).collect();
    let forces: Vec<Variable> = scaled
        .iter()
        .map(|_| program.add_var(0.0, (0.0, 1.0)))
        .collect();
    for row in 0..unit.len() {
        let mut sum = LinearExpr::empty();
        for (column, &f) in scaled.iter().zip(&forces) {
            sum.add(f, column[row]);
        }
        if size > WEIGHTLESS {
            sum.add(payload, unit[row] / lengths[row] / size);
        }
        program.add_constraint(sum, ComparisonOp::Eq, -fixed[row] / lengths[row] / limit);
    }
    match program.solve() {
        Ok(outcome) => outcome
            .into_solution()
            .ok()
            .map(|s| s.var_value(payload) * limit / size),
        Err(microlp::Error::Unbounded) => Some(f64::INFINITY),
        Err(_) => None,
    }
}

/// Whether the contacts block every motion of the joint: some strictly positive forces balance each
/// other and the columns span R^N.
pub fn closed(columns: &[DVector<f64>]) -> bool {
    let Some(first) = columns.first() else {
        return false;
    };
    let unit: Vec<DVector<f64>> = columns.iter().map(|c| c.normalize()).collect();
    let rank = DMatrix::from_columns(&unit).rank(1e-9);
    let mut program = Problem::new(OptimizationDirection::Minimize);
    let forces: Vec<Variable> = unit
        .iter()
        .map(|_| program.add_var(1.0, (1.0, f64::INFINITY)))
        .collect();
    equilibrium(&mut program, (&forces, &unit), &vec![0.0; first.len()]);
    rank == first.len() && program.solve().is_ok()
}

fn equilibrium(
    program: &mut Problem,
    (forces, columns): (&[Variable], &[DVector<f64>]),
    goal: &[f64],
) {
    for (row, &goal) in goal.iter().enumerate() {
        let mut sum = LinearExpr::empty();
        for (column, &f) in columns.iter().zip(forces) {
            sum.add(f, column[row]);
        }
        program.add_constraint(sum, ComparisonOp::Eq, goal);
    }
}

/// Solves the equilibrium again with the forces that the program put on a bound held there: the
/// simplex stops at 1e-7, this is exact to round-off.
fn sharpen(columns: &[DVector<f64>], goal: &DVector<f64>, forces: &[f64]) -> Option<Vec<f64>> {
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let free = |f: f64| f > AT_BOUND * largest && f < (1.0 - AT_BOUND) * largest;
    let mut unknowns = vec![DVector::zeros(goal.len())];
    for (column, &f) in columns.iter().zip(forces) {
        if free(f) {
            unknowns.push(column.clone());
        } else if f >= (1.0 - AT_BOUND) * largest {
            unknowns[0] += column;
        }
    }
    let x = DMatrix::from_columns(&unknowns)
        .svd(true, true)
        .solve(goal, 1e-12)
        .ok()?;
    let mut next = x.iter().skip(1);
    let exact: Vec<f64> = forces
        .iter()
        .map(|&f| match f {
            f if free(f) => next.next().copied().unwrap_or(0.0),
            f if f >= (1.0 - AT_BOUND) * largest => x[0],
            _ => 0.0,
        })
        .collect();
    exact
        .iter()
        .all(|&f| f.is_finite() && f >= 0.0)
        .then_some(exact)
}
