//! Hertz contact of two elastic bodies with general curvature.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

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

/// What a point contact bears, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearable {
    /// Until the pressure is as large as allowed.
    pub by_pressure: f64,
    /// Until the patch reaches the end of a flank.
    pub by_patch: f64,
}

/// What `contact` bears with the pressure `allowed` (MPa) and effective modulus `modulus` (MPa); `None` as
/// for [`patch`]. Pressure and patch grow with the cube root of the force.
pub fn bearable(contact: &Contact, allowed: f64, modulus: f64) -> Option<Bearable> {
    let one = patch(relative_curvatures(contact), 1.0, modulus)?;
    // Half of the patch's height across a tooth: it is longest where the curvature is least.
    let long = longest(contact);
    let height = |across: &Vector2<f64>| {
        let along = across.dot(&long);
        (one.a * along).hypot(one.b * across.perp(&long))
    };
    let [driver, follower] = contact.across.each_ref().map(height);
    Some(Bearable {
        by_pressure: (allowed / one.pressure).powi(3),
        by_patch: (contact.flank_height / driver.max(follower)).powi(3),
    })
}

/// The direction, on the contact's tangents, in which the gap opens least.
fn longest(contact: &Contact) -> Vector2<f64> {
    let sum = contact.driver_curvature + contact.follower_curvature;
    let twice = (sum[(0, 1)] + sum[(1, 0)]).atan2(sum[(0, 0)] - sum[(1, 1)]);
    let (sin, cos) = (0.5 * twice).sin_cos();
    Vector2::new(-sin, cos)
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
