//! Last step of a tooth of the published formulation: from nearly conjugate to conjugate.
//!
//! The penalty E_norm is quadratic, so SLSQP leaves n·T¹ at about the square root of its tolerance.
//! Where the splines can be conjugate, Gauss-Newton on n·T¹ = 0 ends the matter in a few steps of least
//! length, which the other energies hardly notice. Where they cannot, nothing is changed.

use nalgebra::{DMatrix, DVector, RowDVector};

use super::paper::{Adjoint, ToothModel};

/// Steps tried: convergence is quadratic, more do not help.
const STEPS: usize = 12;

/// Singular values below this share of the largest are directions without effect.
const CUT: f64 = 1e-7;

impl ToothModel {
    /// Variables near `x` with |n·T¹| ≤ `tolerance` (mm/rad) at all samples; `None` when a few
    /// Gauss-Newton steps do not get there.
    pub fn finish(&self, x: &[f64], tolerance: f64) -> Option<Vec<f64>> {
        let mut x = DVector::from_column_slice(x);
        for _ in 0..STEPS {
            let (rolling, jacobian) = self.rolling(x.as_slice());
            if rolling.iter().all(|r| r.abs() <= tolerance) {
                return Some(x.as_slice().to_vec());
            }
            if !jacobian.iter().chain(rolling.iter()).all(|v| v.is_finite()) {
                return None;
            }
            let svd = jacobian.svd(true, true);
            let cut = CUT * svd.singular_values.max();
            x -= svd.solve(&rolling, cut).ok()?;
        }
        None
    }

    /// n·T¹ at the samples (n·T² vanishes by construction), and row by row its derivatives by the
    /// variables.
    fn rolling(&self, x: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let samples = self.samples(x);
        let mut jacobian = DMatrix::zeros(samples.len(), x.len());
        for (i, s) in samples.iter().enumerate() {
            let mut adjoints = vec![Adjoint::zero(); samples.len()];
            adjoints[i].n = s.t1;
            adjoints[i].t1 = s.n;
            let mut row = vec![0.0; x.len()];
            self.pull_back(&samples, &adjoints, &mut row);
            jacobian.set_row(i, &RowDVector::from_row_slice(&row));
        }
        let values = samples.iter().map(|s| s.n.dot(&s.t1));
        (DVector::from_iterator(samples.len(), values), jacobian)
    }
}
