//! Periodic quintic spline (C⁴) through points of R^D at any increasing abscissae.
//!
//! Kept B-splines (`splines`, `bspline`, `enterpolation`) neither interpolate periodically on
//! uneven knots nor give derivatives, hence this one: de Boor's basis, a cyclic five-band system.

use nalgebra::{Matrix2, Vector2};
use num_dual::Dual2_64;

const DEGREE: usize = 5;

/// Fewest knots of the cyclic system; shorter data is repeated over several periods.
const MIN_KNOTS: usize = 8;

/// s(x + period) = s(x), s(xᵢ) = yᵢ.
#[derive(Debug, Clone)]
pub(super) struct PeriodicSpline<const D: usize> {
    /// Knots x₋₅ … xₙ₊₅; x₀ < … < xₙ = x₀ + period, continued to both sides.
    knots: Vec<f64>,
    /// Coefficient of the basis function that is centred at each of the n knots.
    coefficients: Vec<[f64; D]>,
}

impl<const D: usize> PeriodicSpline<D> {
    /// Interpolates `values` at the strictly increasing `knots`, one value per knot, all of them
    /// within less than one `period`. `None` if the knots are too uneven to solve for it.
    pub(super) fn new(knots: &[f64], values: &[[f64; D]], period: f64) -> Option<Self> {
        if knots.is_empty() || knots.len() != values.len() {
            return None;
        }
        let repeats = MIN_KNOTS.div_ceil(knots.len());
        let count = (repeats * knots.len()) as isize;
        let per_period = knots.len() as isize;
        let continued = (-(DEGREE as isize)..=count + DEGREE as isize).map(|i| {
            knots[i.rem_euclid(per_period) as usize] + i.div_euclid(per_period) as f64 * period
        });
        let mut spline = PeriodicSpline {
            knots: continued.collect(),
            coefficients: Vec::new(),
        };
        let rows: Vec<[f64; 5]> = (0..spline.len())
            .map(|i| {
                let basis = spline.basis(i, Dual2_64::from_re(spline.knots[DEGREE + i]));
                [0, 1, 2, 3, 4].map(|k| basis[k].re)
            })
            .collect();
        let values: Vec<[f64; D]> = (0..spline.len())
            .map(|i| values[i % values.len()])
            .collect();
        spline.coefficients = solve_cyclic(&rows, &values)?;
        Some(spline)
    }

    /// Value and two derivatives at `x`.
    pub(super) fn at(&self, x: f64) -> [Dual2_64; D] {
        let n = self.len();
        let one = &self.knots[DEGREE..=DEGREE + n];
        let x = one[0] + (x - one[0]).rem_euclid(one[n] - one[0]);
        let interval = one[..n].partition_point(|knot| *knot <= x).max(1) - 1;
        let basis = self.basis(interval, Dual2_64::from_re(x).derivative());
        let mut sum = [Dual2_64::from_re(0.0); D];
        for (k, weight) in basis.iter().enumerate() {
            let coefficient = &self.coefficients[(interval + n + k - 2) % n];
            for (s, c) in sum.iter_mut().zip(coefficient) {
                *s += *weight * *c;
            }
        }
        sum
    }

    /// Number of intervals.
    fn len(&self) -> usize {
        self.knots.len() - 1 - 2 * DEGREE
    }

    /// The six basis functions that are not zero in `interval`, centred at its knots −2 … +3
    /// (Cox-de Boor recursion on dual numbers: derivatives come with it).
    fn basis(&self, interval: usize, x: Dual2_64) -> [Dual2_64; DEGREE + 1] {
        let knots = &self.knots[interval + 1..];
        let mut basis = [Dual2_64::from_re(0.0); DEGREE + 1];
        basis[0] = Dual2_64::from_re(1.0);
        for degree in 1..=DEGREE {
            let mut saved = Dual2_64::from_re(0.0);
            for r in 0..degree {
                let right = knots[DEGREE + r];
                let left = knots[DEGREE + r - degree];
                let share = basis[r] * (1.0 / (right - left));
                basis[r] = saved + share * (-x + right);
                saved = share * (x - left);
            }
            basis[degree] = saved;
        }
        basis
    }
}

/// Solves Σₖ rows[i][k] · c[(i + k − 2) mod n] = values[i].
///
/// The last two unknowns border a plain five-band matrix, which is totally positive (collocation
/// of B-splines), so elimination without pivoting is stable; a 2×2 Schur complement closes the ring.
fn solve_cyclic<const D: usize>(rows: &[[f64; 5]], values: &[[f64; D]]) -> Option<Vec<[f64; D]>> {
    let n = rows.len();
    let m = n - 2;
    let mut band = rows[..m].to_vec();
    let mut border = vec![[0.0; 2]; m];
    let mut right = values[..m].to_vec();
    for i in 0..m {
        for (k, weight) in band[i].iter_mut().enumerate() {
            let column = (i + n + k - 2) % n;
            if column >= m {
                border[i][column - m] = *weight;
                *weight = 0.0;
            }
        }
    }
    for i in 0..m {
        for below in 1..=2.min(m - 1 - i) {
            let factor = band[i + below][2 - below] / band[i][2];
            for k in 2..5 {
                band[i + below][k - below] -= factor * band[i][k];
            }
            let (pivot_border, pivot_right) = (border[i], right[i]);
            subtract(&mut border[i + below], factor, &pivot_border);
            subtract(&mut right[i + below], factor, &pivot_right);
        }
    }
    for i in (0..m).rev() {
        for above in 1..=2.min(m - 1 - i) {
            let factor = band[i][2 + above];
            let (next_border, next_right) = (border[i + above], right[i + above]);
            subtract(&mut border[i], factor, &next_border);
            subtract(&mut right[i], factor, &next_right);
        }
        let pivot = 1.0 / band[i][2];
        border[i] = border[i].map(|b| b * pivot);
        right[i] = right[i].map(|r| r * pivot);
    }
    let mut schur = Matrix2::zeros();
    let mut last = [values[m], values[m + 1]];
    for (row, rest) in last.iter_mut().enumerate() {
        for (k, &weight) in rows[m + row].iter().enumerate() {
            let column = (m + row + n + k - 2) % n;
            if column >= m {
                schur[(row, column - m)] += weight;
            } else {
                for (j, b) in border[column].iter().enumerate() {
                    schur[(row, j)] -= weight * b;
                }
                subtract(rest, weight, &right[column]);
            }
        }
    }
    let inverse = schur.try_inverse()?;
    let mut solution = right;
    let mut tail = [[0.0; D]; 2];
    for d in 0..D {
        let y = inverse * Vector2::new(last[0][d], last[1][d]);
        (tail[0][d], tail[1][d]) = (y[0], y[1]);
    }
    for (c, b) in solution.iter_mut().zip(&border) {
        subtract(c, b[0], &tail[0]);
        subtract(c, b[1], &tail[1]);
    }
    solution.extend(tail);
    let finite = solution.iter().flatten().all(|c| c.is_finite());
    finite.then_some(solution)
}

/// a ← a − factor · b
fn subtract<const N: usize>(a: &mut [f64; N], factor: f64, b: &[f64; N]) {
    for (x, y) in a.iter_mut().zip(b) {
        *x -= factor * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn interpolates_uneven_data(
            steps in prop::collection::vec((0.05f64..1.0, -5.0f64..5.0), 4..60),
        ) {
            let total: f64 = steps.iter().map(|(step, _)| step).sum();
            let mut x = 0.3;
            let mut knots = Vec::new();
            for (step, _) in &steps {
                knots.push(x);
                x += step;
            }
            let values: Vec<[f64; 1]> = steps.iter().map(|(_, y)| [*y]).collect();
            let spline = PeriodicSpline::new(&knots, &values, total).expect("solvable");
            for (x, y) in knots.iter().zip(&values) {
                for turn in [-1.0, 0.0, 2.0] {
                    let got = spline.at(x + turn * total)[0].re;
                    prop_assert!((got - y[0]).abs() < 1e-9, "{got} {}", y[0]);
                }
            }
        }
    }

    #[test]
    fn reproduces_a_sine_to_sixth_order() {
        let error = |n: usize| {
            let tau = std::f64::consts::TAU;
            let knots: Vec<f64> = (0..n).map(|i| tau * i as f64 / n as f64).collect();
            let values: Vec<[f64; 1]> = knots.iter().map(|x| [x.sin()]).collect();
            let spline = PeriodicSpline::new(&knots, &values, tau).expect("solvable");
            (0..1000)
                .map(|i| {
                    let x = tau * f64::from(i) / 1000.0;
                    let s = spline.at(x)[0];
                    (s.re - x.sin()).abs()
                })
                .fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(12), error(24));
        assert!(coarse < 1e-4, "{coarse:e}");
        assert!(coarse / fine > 50.0, "order {}", (coarse / fine).log2());
    }
}
