//! Open cubic B-spline over u ∈ [0, 1]: clamped at both ends, uniform knots between.
//!
//! With four control points this is a Bézier curve. A spline is evaluated as a weighted sum of its
//! control points; the weights depend on u only and are tabulated once a grid.

use nalgebra::{DMatrix, Vector3};

/// Weights of all control points at one u, with their derivatives by u.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// Weights; they sum to 1.
    pub value: Vec<f64>,
    /// First derivative by u.
    pub first: Vec<f64>,
    /// Second derivative by u.
    pub second: Vec<f64>,
}

impl Weights {
    /// Weights of `control` ≥ 1 control points at `u`, clamped to [0, 1]; fewer than four control
    /// points make a curve of lower degree.
    pub fn at(control: usize, u: f64) -> Weights {
        let degree = degree(control);
        let knots = knots(control);
        let u = u.clamp(0.0, 1.0);
        // Weights of a degree d−k spline on the same knots, differentiated k times.
        let derivative = |order: usize| {
            if order > degree {
                return vec![0.0; control];
            }
            let mut w = bell(&knots, degree - order, u);
            for d in degree - order + 1..=degree {
                w = raise(&knots, d, &w);
            }
            w
        };
        Weights {
            value: derivative(0),
            first: derivative(1),
            second: derivative(2),
        }
    }
}

/// Parameters at which a spline whose control points are equally spaced values of a line reproduces
/// that line.
pub fn greville(control: usize) -> Vec<f64> {
    let d = degree(control);
    let knots = knots(control);
    (0..control)
        .map(|i| knots[i + 1..=i + d].iter().sum::<f64>() / d.max(1) as f64)
        .collect()
}

/// Least-squares fit of `control` control points to `points` at equally spaced u from 0 to 1;
/// also the largest distance between a point and the spline, mm. Where there are fewer points than
/// control points the shortest solution is taken. No points or no control points: no fit, infinite
/// error. Non-finite points: non-finite error.
pub fn fit(points: &[Vector3<f64>], control: usize) -> (Vec<Vector3<f64>>, f64) {
    let rows = points.len();
    if rows == 0 || control == 0 {
        return (Vec::new(), f64::INFINITY);
    }
    let mut weights = DMatrix::zeros(rows, control);
    let mut targets = DMatrix::zeros(rows, 3);
    for (i, p) in points.iter().enumerate() {
        let u = i as f64 / (rows - 1).max(1) as f64;
        for (a, w) in Weights::at(control, u).value.into_iter().enumerate() {
            weights[(i, a)] = w;
        }
        targets.row_mut(i).copy_from(&p.transpose());
    }
    if targets.iter().any(|x| !x.is_finite()) {
        return (vec![Vector3::zeros(); control], f64::NAN);
    }
    let Ok(solution) = weights.clone().svd(true, true).solve(&targets, 1e-12) else {
        return (vec![Vector3::zeros(); control], f64::NAN);
    };
    let error = (weights * &solution - targets)
        .row_iter()
        .map(|r| r.norm())
        .fold(0.0, f64::max);
    (
        solution
            .row_iter()
            .map(|r| Vector3::new(r[0], r[1], r[2]))
            .collect(),
        error,
    )
}

fn degree(control: usize) -> usize {
    control.saturating_sub(1).min(3)
}

/// control + degree + 1 knots.
fn knots(control: usize) -> Vec<f64> {
    let d = degree(control);
    let spans = (control - d).max(1);
    (0..control + d + 1)
        .map(|i| (i.saturating_sub(d) as f64 / spans as f64).min(1.0))
        .collect()
}

/// Cox-de Boor: values of all basis functions of one degree.
fn bell(knots: &[f64], degree: usize, u: f64) -> Vec<f64> {
    // The last span is closed, so that u = 1 belongs to it.
    let last = knots.iter().rposition(|&k| k < 1.0).unwrap_or(0);
    let span = knots[..=last].iter().rposition(|&k| k <= u).unwrap_or(0);
    let mut w = vec![0.0; knots.len() - 1];
    w[span] = 1.0;
    for d in 1..=degree {
        for i in 0..knots.len() - 1 - d {
            let left = ratio(u - knots[i], knots[i + d] - knots[i]) * w[i];
            let right = ratio(knots[i + d + 1] - u, knots[i + d + 1] - knots[i + 1]) * w[i + 1];
            w[i] = left + right;
        }
        w.pop();
    }
    w
}

/// Derivative of the basis functions of degree `d` from those of degree d − 1.
fn raise(knots: &[f64], d: usize, w: &[f64]) -> Vec<f64> {
    (0..w.len() - 1)
        .map(|i| {
            d as f64
                * (ratio(w[i], knots[i + d] - knots[i])
                    - ratio(w[i + 1], knots[i + d + 1] - knots[i + 1]))
        })
        .collect()
}

/// a/b, where 0/0 of coinciding knots counts as 0.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_derivatives_match_differences() {
        for control in 1..9 {
            for i in 1..40 {
                let u = i as f64 / 40.0 + 1e-3;
                let w = Weights::at(control, u);
                assert!((w.value.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                let h = 1e-5;
                let (a, b) = (Weights::at(control, u - h), Weights::at(control, u + h));
                for k in 0..control {
                    assert!((w.first[k] - (b.value[k] - a.value[k]) / (2.0 * h)).abs() < 1e-6);
                    assert!((w.second[k] - (b.first[k] - a.first[k]) / (2.0 * h)).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn ends_are_clamped_and_four_points_are_a_bezier_curve() {
        assert_eq!(
            Weights::at(6, 0.0).value,
            vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        );
        assert_eq!(
            Weights::at(6, 1.0).value,
            vec![0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        );
        let w = Weights::at(4, 0.25);
        let bezier = [0.421875, 0.421875, 0.140625, 0.015625];
        assert!(
            w.value
                .iter()
                .zip(bezier)
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        assert_eq!(Weights::at(4, 0.0).first, vec![-3.0, 3.0, 0.0, 0.0]);
        assert_eq!(Weights::at(4, 1.0).second, vec![0.0, 6.0, -12.0, 6.0]);
    }

    #[test]
    fn greville_reproduces_a_line() {
        for control in 2..8 {
            let g = greville(control);
            let w = Weights::at(control, 0.37);
            let u: f64 = w.value.iter().zip(&g).map(|(a, b)| a * b).sum();
            assert!((u - 0.37).abs() < 1e-14, "{control}: {u}");
        }
    }

    #[test]
    fn fit_reproduces_a_cubic_and_reports_its_error() {
        let cubic = |u: f64| Vector3::new(u * u * u, 1.0 - u, 2.0 * u * u);
        let points: Vec<_> = (0..33).map(|i| cubic(i as f64 / 32.0)).collect();
        for control in 4..7 {
            assert!(fit(&points, control).1 < 1e-12);
        }
        // A wave needs more control points than a cubic has: the error is there and falls.
        let wave: Vec<_> = (0..33)
            .map(|i| Vector3::new((i as f64 / 4.0).sin(), 0.0, i as f64))
            .collect();
        let (coarse, fine) = (fit(&wave, 4).1, fit(&wave, 12).1);
        assert!(coarse > 0.1 && fine < 0.02, "{coarse} {fine}");
        assert!(fit(&[Vector3::new(f64::NAN, 0.0, 0.0)], 4).1.is_nan());
        assert!(fit(&[], 4).1.is_infinite());
    }
}
