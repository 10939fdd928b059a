//! Hertz contact of two elastic bodies with general curvature.

use std::f64::consts::PI;

use nalgebra::Matrix2;

use super::Material;
use super::contacts::Contact;

/// Elliptic contact patch under a normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Longer half axis, mm.
    pub a: f64,
    /// Shorter half axis, mm.
    pub b: f64,
    /// Largest pressure, in the middle, MPa.
    pub pressure: f64,
    /// Approach of the two bodies, mm.
    pub approach: f64,
}

/// Effective modulus E* of two materials, MPa.
pub fn effective_modulus(one: Material, two: Material) -> f64 {
    let compliance = |m: Material| (1.0 - m.poisson_ratio().powi(2)) / m.young_modulus();
    1.0 / (compliance(one) + compliance(two))
}

/// Curvature of the gap between both flanks of a contact, principal values (small, large), 1/mm.
pub fn relative_curvatures(contact: &Contact) -> [f64; 2] {
    let sum: Matrix2<f64> = contact.driver_curvature + contact.follower_curvature;
    let mean = 0.5 * sum.trace();
    let spread = (0.5 * (sum[(0, 0)] - sum[(1, 1)])).hypot(0.5 * (sum[(0, 1)] + sum[(1, 0)]));
    [mean - spread, mean + spread]
}

/// Force, N, at which a point contact reaches the pressure `allowed` (MPa); otherwise as [`patch`].
/// The pressure grows with the cube root of the force.
pub fn force_at(curvatures: [f64; 2], allowed: f64, modulus: f64) -> Option<f64> {
    patch(curvatures, 1.0, modulus).map(|one| (allowed / one.pressure).powi(3))
}

/// Patch of a contact with relative principal curvatures `curvatures` (1/mm) under `force` (N) and
/// effective modulus `modulus` (MPa); `None` unless both curvatures are positive (a point contact)
/// and the force is positive.
///
/// The gap is A x² + B y² with 2A, 2B the curvatures; the eccentricity e solves
/// B/A = [E/(1−e²) − K] / [K − E] with the complete elliptic integrals of e².
pub fn patch(curvatures: [f64; 2], force: f64, modulus: f64) -> Option<Patch> {
    let [small, large] = curvatures;
    let point_contact = small > 0.0 && large >= small;
    if !point_contact || force.max(0.0) * modulus.max(0.0) == 0.0 {
        return None;
    }
    let integrals = |m: f64| Some((ellip::ellipk(m).ok()?, ellip::ellipe(m).ok()?));
    // Below this the difference K − E loses its digits; the contact is round to 1e-6.
    let (mut low, mut high) = (1e-6, 1.0 - 1e-12);
    let ratio = |m: f64| integrals(m).map(|(k, e)| (e / (1.0 - m) - k) / (k - e));
    let goal = large / small;
    let m = if ratio(low)? >= goal {
        low
    } else if ratio(high)? <= goal {
        return None;
    } else {
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if ratio(middle)? < goal {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let (k, e) = integrals(m)?;
    let a = (3.0 * force * (k - e) / (PI * modulus * small * m)).cbrt();
    let b = a * (1.0 - m).sqrt();
    Some(Patch {
        a,
        b,
        pressure: 1.5 * force / (PI * a * b),
        approach: 1.5 * force * k / (PI * modulus * a),
    })
}
