//! Best plane through points, with the derivatives of its residual and of its normal.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Least-squares plane of a set of points.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Centroid of the points.
    pub centre: Vector3<f64>,
    /// Unit normal, of either sign.
    pub normal: Vector3<f64>,
    /// Mean squared distance of the points from the plane: smallest eigenvalue of the scatter.
    pub thickness: f64,
    /// Mean squared distance from the centroid: trace of the scatter.
    pub spread: f64,
    /// The two directions within the plane and the scatter along them.
    within: [(Vector3<f64>, f64); 2],
    /// Number of points.
    count: f64,
}

impl Plane {
    /// Plane of `points`; non-finite where there are none.
    pub fn fit(points: &[Vector3<f64>]) -> Plane {
        let count = points.len() as f64;
        let centre = points.iter().sum::<Vector3<f64>>() / count;
        let scatter = points
            .iter()
            .map(|p| (p - centre) * (p - centre).transpose())
            .sum::<Matrix3<f64>>()
            / count;
        if scatter.iter().any(|x| !x.is_finite()) {
            let nan = Vector3::repeat(f64::NAN);
            return Plane {
                centre,
                normal: nan,
                thickness: f64::NAN,
                spread: f64::NAN,
                within: [(nan, f64::NAN); 2],
                count,
            };
        }
        let eigen = SymmetricEigen::new(scatter);
        let smallest = eigen.eigenvalues.imin();
        let axis = |k: usize| {
            let k = (smallest + k) % 3;
            (
                eigen.eigenvectors.column(k).into_owned(),
                eigen.eigenvalues[k],
            )
        };
        Plane {
            centre,
            normal: axis(0).0,
            thickness: axis(0).1,
            spread: scatter.trace(),
            within: [axis(1), axis(2)],
            count,
        }
    }

    /// Derivative of the thickness by `point`, one of those the plane was fitted to.
    pub fn thickness_by(&self, point: Vector3<f64>) -> Vector3<f64> {
        2.0 / self.count * self.normal.dot(&(point - self.centre)) * self.normal
    }

    /// Derivative of the spread by `point`.
    pub fn spread_by(&self, point: Vector3<f64>) -> Vector3<f64> {
        2.0 / self.count * (point - self.centre)
    }

    /// Derivative of `cotangent`·normal by `point`: first-order perturbation of the eigenvector,
    /// dm = Σ u (u·dS m)/(λ_m − λ_u) over the two directions u within the plane. Not finite where
    /// the points lie on a line.
    pub fn normal_by(&self, point: Vector3<f64>, cotangent: Vector3<f64>) -> Vector3<f64> {
        let d = point - self.centre;
        let g: Vector3<f64> = self
            .within
            .iter()
            .map(|(u, scatter)| cotangent.dot(u) / (self.thickness - scatter) * u)
            .sum();
        (self.normal.dot(&d) * g + g.dot(&d) * self.normal) / self.count
    }
}
