//! A pose together with its first two derivatives: what every kind of motion evaluates to.
//!
//! Numbers are second-order dual numbers (value, d/dφ, d²/dφ²), so that composing rotations keeps
//! exact derivatives without any formula of its own.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use num_dual::{Dual2_64, DualNum};

use super::{MotionState, Pose};

/// Quaternion (w, x, y, z) with derivatives, of any length ≠ 0.
pub(super) type QuaternionJet = [Dual2_64; 4];

/// Hamilton product `a · b`: first turn by `b`, then by `a`.
pub(super) fn compose(a: &QuaternionJet, b: &QuaternionJet) -> QuaternionJet {
    let [aw, ax, ay, az] = *a;
    let [bw, bx, by, bz] = *b;
    [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
}

/// Turn by `angle` (rad) about z.
pub(super) fn about_z(angle: Dual2_64) -> QuaternionJet {
    let (sin, cos) = (angle * 0.5).sin_cos();
    let zero = Dual2_64::from_re(0.0);
    [cos, zero, zero, sin]
}

/// Turn by the axis-angle vector `v` (rad).
pub(super) fn about_vector(v: &[Dual2_64; 3]) -> QuaternionJet {
    let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    // Both functions are analytic in θ²; below 1e-4 the next term of the series is under 1e-18.
    let (cos, half_sinc) = if square.re < 1e-4 {
        let cos = square * (square * (square * (-1.0 / 46080.0) + 1.0 / 384.0) - 1.0 / 8.0) + 1.0;
        let half_sinc =
            square * (square * (square * (-1.0 / 645120.0) + 1.0 / 3840.0) - 1.0 / 48.0) + 0.5;
        (cos, half_sinc)
    } else {
        let angle = square.sqrt();
        let (sin, cos) = (angle * 0.5).sin_cos();
        (cos, sin / angle)
    };
    [cos, v[0] * half_sinc, v[1] * half_sinc, v[2] * half_sinc]
}

/// Smallest turn that takes z to the direction of `axis` (any length; not −z).
pub(super) fn z_to(axis: &[Dual2_64; 3]) -> QuaternionJet {
    let length = (axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]).sqrt();
    [length + axis[2], -axis[1], axis[0], Dual2_64::from_re(0.0)]
}

/// Rotation (any quaternion length) and translation (mm) with two derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoseJet {
    /// Body → Σ.
    pub rotation: QuaternionJet,
    /// Body origin in Σ.
    pub translation: [Dual2_64; 3],
}

impl PoseJet {
    /// The same motion of a body frame that is turned by the constant `align`.
    pub(super) fn turned(&self, align: &UnitQuaternion<f64>) -> PoseJet {
        let constant = [align.w, align.i, align.j, align.k].map(Dual2_64::from_re);
        PoseJet {
            rotation: compose(&self.rotation, &constant),
            translation: self.translation,
        }
    }

    /// The same motion with `share` of its departure from the uniform turn −φ: turns about the same axes
    /// by smaller angles, smaller translations.
    pub(super) fn scaled(&self, share: f64, phi: f64) -> PoseJet {
        let angle = Dual2_64::new(phi, 1.0, 0.0);
        let [w, x, y, z] = compose(&self.rotation, &about_z(angle));
        let length = (w * w + x * x + y * y + z * z).sqrt();
        let length = if w.re < 0.0 { -length } else { length };
        let departure = [
            length * (1.0 - share) + w * share,
            x * share,
            y * share,
            z * share,
        ];
        PoseJet {
            rotation: compose(&departure, &about_z(-angle)),
            translation: self.translation.map(|t| t * share),
        }
    }

    /// Pose, twist and twist rate.
    pub(super) fn state(&self) -> MotionState {
        let part = |f: fn(&Dual2_64) -> f64| {
            let [w, x, y, z] = [0, 1, 2, 3].map(|i| f(&self.rotation[i]));
            let [a, b, c] = [0, 1, 2].map(|i| f(&self.translation[i]));
            (Quaternion::new(w, x, y, z), Vector3::new(a, b, c))
        };
        let (q, t) = part(|d| d.re);
        let (q1, t1) = part(|d| d.v1);
        let (q2, t2) = part(|d| d.v2);
        // ω = 2 Im(q̇ q*) / |q|²; Im(q̇ q̇*) = 0, so only q̈ and the length's change are left in ω̇.
        let square = q.norm_squared();
        let omega = 2.0 * (q1 * q.conjugate()).imag() / square;
        let square_rate = 2.0 * q.dot(&q1);
        let omega_rate =
            2.0 * (q2 * q.conjugate()).imag() / square - omega * (square_rate / square);
        MotionState {
            pose: Pose {
                rotation: UnitQuaternion::new_normalize(q)
                    .to_rotation_matrix()
                    .into_inner(),
                translation: t,
            },
            omega,
            v_origin: t1 - omega.cross(&t),
            omega_rate,
            v_origin_rate: t2 - omega_rate.cross(&t) - omega.cross(&t1),
        }
    }
}
