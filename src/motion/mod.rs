//! Periodic rigid-body motions M²(φ) of the follower, with exact first and second derivatives.

mod checks;
mod class;
mod csv_numbers;
mod derivative;
mod document;
mod expression;
mod file;
mod formula;
mod hub;
mod jet;
mod keyframes;
mod path;
mod rows;
mod source;
mod spline;
mod starter;
mod table;

pub use class::Class;
pub use file::{MotionFile, unusable_name};
pub use formula::Formula;
pub use keyframes::{Keyframe, Keyframes};
pub use path::Path;
pub use starter::starter;
pub use table::Table;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::{Error, Result};
use formula::FormulaShape;
use jet::PoseJet;
use rows::RowShape;

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

/// A motion as the user gave it, self-contained (files inlined).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum MotionSource {
    /// Uniform rotation −φ about z.
    Uniform {},
    /// Poses at many phases.
    Table(Table),
    /// A few poses, joined by a spline.
    Keyframes(Keyframes),
    /// Expressions in φ.
    Formula(Formula),
    /// Curve of an end-effector.
    Path(Path),
}

/// The follower's motion M²(φ), 2π-periodic up to whole turns about its own axis.
#[derive(Debug, Clone)]
pub struct Motion {
    class: Class,
    shape: Shape,
    align: UnitQuaternion<f64>,
}

/// What evaluates the motion.
#[derive(Debug, Clone)]
enum Shape {
    Formula(FormulaShape),
    Rows(RowShape),
}

impl Shape {
    fn new(class: Class, source: &MotionSource) -> Result<Shape> {
        let formula = |f: &Formula| {
            f.shape()
                .map(Shape::Formula)
                .map_err(|problems| Error::input("motion", problems))
        };
        match source {
            MotionSource::Uniform {} => formula(&Formula::default()),
            MotionSource::Formula(f) => formula(f),
            MotionSource::Table(table) => table.shape().map(Shape::Rows),
            MotionSource::Keyframes(keyframes) => keyframes.shape().map(Shape::Rows),
            MotionSource::Path(path) => path.shape(class).map(Shape::Rows),
        }
    }

    fn at(&self, phi: f64) -> PoseJet {
        match self {
            Shape::Formula(shape) => shape.at(phi),
            Shape::Rows(shape) => shape.at(phi),
        }
    }
}

impl Motion {
    /// Builds the evaluator of a source and checks that it is a periodic, smooth motion of `class`.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the source is not a motion of the class (all problems found);
    /// [`crate::Error::Infeasible`] when it is, but no gear can perform it: the follower does not
    /// make −1 turn about its mean axis per period, or leans too far.
    pub fn new(class: Class, source: &MotionSource) -> Result<Motion> {
        let shape = Shape::new(class, source)?;
        let identity = UnitQuaternion::identity();
        let align = if class.is_spherical() {
            let axes = (0..checks::SAMPLES).map(|i| {
                let rotation = shape.at(checks::phase(i)).state().pose.rotation;
                rotation.row(2).transpose() / checks::SAMPLES as f64
            });
            // What is not a number is named by the checks below.
            let hub = hub::mean_direction(axes)?;
            hub::align_to(hub)
        } else {
            identity
        };
        checks::check(class, |phi| shape.at(phi).turned(&align).state())?;
        Ok(Motion {
            class,
            shape,
            align,
        })
    }

    /// Class the motion belongs to.
    pub fn class(&self) -> Class {
        self.class
    }

    /// Pose, twist and twist rate of the follower at driver angle `phi` (rad), exact derivatives.
    ///
    /// The follower's frame has its origin at the joint's centre and its z axis on the hub axis.
    pub fn state(&self, phi: f64) -> MotionState {
        self.projected(self.shape.at(phi).turned(&self.align))
            .state()
    }

    /// Pose of the frame that the motion file speaks of; differs from [`Motion::state`]'s by a
    /// constant turn if that frame's z axis is not the hub axis.
    pub fn user_pose(&self, phi: f64) -> Pose {
        self.projected(self.shape.at(phi)).state().pose
    }

    /// Centre C(φ) of the follower-support joint in Σ: O, moved along z where the class slides.
    pub fn joint_centre(&self, phi: f64) -> Vector3<f64> {
        let translation = self.projected(self.shape.at(phi)).translation;
        Vector3::from(translation.map(|t| t.re))
    }

    /// Takes away what is outside the class's motion space (below the tolerance of the checks).
    fn projected(&self, mut jet: PoseJet) -> PoseJet {
        let zero = num_dual::Dual2_64::from_re(0.0);
        let [x, y, z] = &mut jet.translation;
        (*x, *y) = (zero, zero);
        if !self.class.slides() {
            *z = zero;
        }
        if !self.class.is_spherical() {
            (jet.rotation[1], jet.rotation[2]) = (zero, zero);
        }
        jet
    }
}
