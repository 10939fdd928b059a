//! External load on the follower, projected onto the joint's motion space span(U).

use nalgebra::{DVector, Vector3};

use super::contacts::Configuration;
use super::settings::Load;

/// Standard gravity, m/s² (N per kg).
pub const GRAVITY: f64 = 9.80665;

/// Weight of one kilogram, N, which is the acceleration of gravity, m/s²; in Σ.
pub fn gravity(load: &Load) -> Vector3<f64> {
    Vector3::from(load.gravity).normalize() * GRAVITY
}

/// Force (N) at a point and torque (N·mm), both in Σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    /// Point of application, mm.
    pub point: Vector3<f64>,
    /// Force, N.
    pub force: Vector3<f64>,
    /// Free torque, N·mm.
    pub torque: Vector3<f64>,
}

impl Wrench {
    /// Weight of one kilogram at the load point of `load`.
    pub fn unit_weight(load: &Load, at: &Configuration) -> Wrench {
        Wrench {
            point: at.follower.pose.apply(load.point_mm.into()),
            force: gravity(load),
            torque: Vector3::zeros(),
        }
    }

    /// The extra force and torque of `load` at the angle of `at`; zero without a table.
    pub fn extra(load: &Load, at: &Configuration) -> Wrench {
        let point = at.follower.pose.apply(load.point_mm.into());
        let rows = &load.extra;
        let degrees = at.phi.to_degrees().rem_euclid(360.0);
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        if let (Some(first), Some(last)) = (rows.first(), rows.last()) {
            let next = rows.iter().position(|row| row.phi_deg > degrees);
            // Before the first and after the last row the table continues with the other end.
            let (a, b, from, to) = match next {
                Some(0) => (last, first, last.phi_deg - 360.0, first.phi_deg),
                Some(i) => (&rows[i - 1], &rows[i], rows[i - 1].phi_deg, rows[i].phi_deg),
                None => (last, first, last.phi_deg, first.phi_deg + 360.0),
            };
            let t = if to > from {
                (degrees - from) / (to - from)
            } else {
                0.0
            };
            let mix =
                |x: [f64; 3], y: [f64; 3]| Vector3::from(x) * (1.0 - t) + Vector3::from(y) * t;
            force = mix(a.force_n, b.force_n);
            torque = mix(a.torque_nmm, b.torque_nmm);
        }
        Wrench {
            point,
            force,
            torque,
        }
    }

    /// Projection onto span(U) ≅ R^N about the present joint centre (order: linear, angular).
    pub fn project(&self, at: &Configuration) -> DVector<f64> {
        let mut projected = at.class.project(self.point, self.force, at.centre);
        let last = projected.len() - 1;
        if at.class.is_spherical() {
            for (i, component) in self.torque.iter().enumerate() {
                projected[last - 2 + i] += component;
            }
        } else {
            projected[last] += self.torque.z;
        }
        projected
    }

    /// Work this load does on the follower per radian of φ, N·mm.
    pub fn power(&self, at: &Configuration) -> f64 {
        self.force.dot(&at.follower.velocity(self.point)) + self.torque.dot(&at.follower.omega)
    }
}
