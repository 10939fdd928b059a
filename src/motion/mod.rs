//! Periodic rigid-body motions M²(φ) of the follower, with exact first and second derivatives.

mod class;

pub use class::Class;

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Rigid pose: a body point q is at `rotation * q + translation` in Σ (mm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation matrix, body → Σ.
    pub rotation: Matrix3<f64>,
    /// Position of the body origin in Σ, mm.
    pub translation: Vector3<f64>,
}

impl Pose {
    /// Body point → Σ.
    pub fn apply(&self, q: Vector3<f64>) -> Vector3<f64> {
        self.rotation * q + self.translation
    }

    /// Σ point → body.
    pub fn inverse_apply(&self, p: Vector3<f64>) -> Vector3<f64> {
        self.rotation.transpose() * (p - self.translation)
    }

    /// `self⁻¹ · other`: the pose of `other` seen from `self`.
    pub fn inverse_mul(&self, other: &Pose) -> Pose {
        let rt = self.rotation.transpose();
        Pose {
            rotation: rt * other.rotation,
            translation: rt * (other.translation - self.translation),
        }
    }
}

/// Pose, twist and twist rate of a body at one φ; derivatives are per radian of φ, in Σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionState {
    /// Pose M(φ).
    pub pose: Pose,
    /// Angular velocity ω.
    pub omega: Vector3<f64>,
    /// Velocity of the body point that is at the origin O of Σ: v(p) = v_origin + ω × p, mm/rad.
    pub v_origin: Vector3<f64>,
    /// dω/dφ.
    pub omega_rate: Vector3<f64>,
    /// d(v_origin)/dφ, mm/rad².
    pub v_origin_rate: Vector3<f64>,
}

impl MotionState {
    /// Velocity of the body point at `p` (Σ), mm/rad.
    pub fn velocity(&self, p: Vector3<f64>) -> Vector3<f64> {
        self.v_origin + self.omega.cross(&p)
    }

    /// State of the driver at φ: rotation by φ about the line x = −L, y = 0, parallel to z.
    pub fn driver(center_distance: f64, phi: f64) -> MotionState {
        let axis_point = Vector3::new(-center_distance, 0.0, 0.0);
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), phi).into_inner();
        let omega = Vector3::z();
        MotionState {
            pose: Pose {
                rotation,
                translation: axis_point - rotation * axis_point,
            },
            omega,
            v_origin: -omega.cross(&axis_point),
            omega_rate: Vector3::zeros(),
            v_origin_rate: Vector3::zeros(),
        }
    }
}

/// A motion as the user gave it, self-contained.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum MotionSource {
    /// Uniform rotation −φ about z (placeholder of every class; also the simplest test motion).
    Uniform {},
}

/// The follower's motion M²(φ), 2π-periodic up to whole turns about its own axis.
#[derive(Debug, Clone)]
pub struct Motion {
    class: Class,
}

impl Motion {
    /// Builds the evaluator of a checked source.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the source is not a motion of the class.
    pub fn new(class: Class, _source: &MotionSource) -> crate::Result<Motion> {
        Ok(Motion { class })
    }

    /// Class the motion belongs to.
    pub fn class(&self) -> Class {
        self.class
    }

    /// Pose, twist and twist rate at driver angle `phi` (rad), exact derivatives.
    pub fn state(&self, phi: f64) -> MotionState {
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), -phi).into_inner();
        MotionState {
            pose: Pose {
                rotation,
                translation: Vector3::zeros(),
            },
            omega: -Vector3::z(),
            v_origin: Vector3::zeros(),
            omega_rate: Vector3::zeros(),
            v_origin_rate: Vector3::zeros(),
        }
    }

    /// Centre C(φ) of the follower-support joint in Σ: O, moved along z where the class slides.
    pub fn joint_centre(&self, phi: f64) -> Vector3<f64> {
        if self.class.slides() {
            Vector3::new(0.0, 0.0, self.state(phi).pose.translation.z)
        } else {
            Vector3::zeros()
        }
    }
}
