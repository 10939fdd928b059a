//! Fourier series in φ through scattered samples, by least squares.

use nalgebra::{DMatrix, RowDVector};

/// Samples of some components at phases, ready to be fitted with any number of harmonics.
pub(super) struct Samples {
    /// Per sample: drift, 1, cos φ, sin φ, cos 2φ, … .
    basis: DMatrix<f64>,
    /// Per sample: its components.
    values: DMatrix<f64>,
}

/// Where the columns of a series begin: with the drift or after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Drift {
    /// The samples repeat after a period.
    Without,
    /// A drift that grows evenly along the samples comes on top; it is no part of the series.
    Beside,
}

/// A series: a row of coefficients for 1, cos φ, sin φ, cos 2φ, … .
#[derive(Debug, Clone)]
pub(super) struct Series(DMatrix<f64>);

impl Samples {
    /// `values` has a row per phase (rad); `most` harmonics can be fitted.
    pub(super) fn new(phases: &[f64], values: DMatrix<f64>, most: usize) -> Samples {
        let (first, last) = (phases[0], phases[phases.len() - 1]);
        let middle = (first + last) / 2.0;
        let basis = DMatrix::from_fn(phases.len(), 2 + 2 * most, |i, column| match column {
            0 => (phases[i] - middle) / (last - first),
            column => term(column - 1, phases[i]),
        });
        Samples { basis, values }
    }

    /// The series with so many harmonics that is nearest to the `kept` samples; `None` where they do not
    /// determine it.
    pub(super) fn fit(&self, harmonics: usize, drift: Drift, kept: &[bool]) -> Option<Series> {
        let start = usize::from(drift == Drift::Without);
        let count = 2 + 2 * harmonics - start;
        let rows: Vec<usize> = (0..kept.len()).filter(|i| kept[*i]).collect();
        if rows.len() < count {
            return None;
        }
        let basis = self.basis.columns(start, count).select_rows(&rows);
        let values = self.values.select_rows(&rows);
        let solved = basis
            .tr_mul(&basis)
            .cholesky()?
            .solve(&basis.tr_mul(&values));
        Some(Series(solved.rows(1 - start, count + start - 1).into()))
    }

    /// The series at every sample.
    pub(super) fn at_samples(&self, series: &Series) -> DMatrix<f64> {
        self.basis.columns(1, series.0.nrows()) * &series.0
    }
}

impl Series {
    /// Its components at φ.
    pub(super) fn at(&self, phi: f64) -> RowDVector<f64> {
        let terms = RowDVector::from_fn(self.0.nrows(), |_, i| term(i, phi));
        terms * &self.0
    }

    /// Leaves a component out.
    pub(super) fn clear(&mut self, component: usize) {
        self.0.column_mut(component).fill(0.0);
    }
}

/// 1, cos φ, sin φ, cos 2φ, …
fn term(index: usize, phi: f64) -> f64 {
    let harmonic = index.div_ceil(2) as f64;
    match index % 2 {
        1 => (harmonic * phi).cos(),
        _ if index == 0 => 1.0,
        _ => (harmonic * phi).sin(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_found_from_uneven_samples_with_a_drift_beside_it() {
        let phases: Vec<f64> = (0..40)
            .map(|i| 0.16 * f64::from(i) + 0.03 * f64::from(i % 3))
            .collect();
        let wanted = |phi: f64| 1.5 - 0.4 * phi.sin() + 0.2 * (3.0 * phi).cos();
        let drifting = |phi: f64| wanted(phi) + 0.7 * (phi - phases[20]);
        let values = DMatrix::from_fn(40, 1, |i, _| drifting(phases[i]));
        let samples = Samples::new(&phases, values, 5);
        let kept = [true; 40];
        let series = samples.fit(3, Drift::Beside, &kept).unwrap();
        let shift = series.at(0.0)[0] - wanted(0.0);
        for phi in [0.4, 2.2, 5.9] {
            assert!((series.at(phi)[0] - wanted(phi) - shift).abs() < 1e-10);
        }
        let without = samples.fit(3, Drift::Without, &kept).unwrap();
        let away = |phi: f64| (without.at(phi)[0] - wanted(phi) - shift).abs();
        assert!(away(0.4).max(away(5.9)) > 0.1);
    }

    #[test]
    fn too_few_samples_determine_nothing() {
        let phases = [0.0, 1.0, 2.0];
        let samples = Samples::new(&phases, DMatrix::zeros(3, 1), 2);
        assert!(samples.fit(2, Drift::Without, &[true; 3]).is_none());
    }
}
