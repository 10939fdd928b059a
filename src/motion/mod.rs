//! Periodic rigid-body motions M²(φ) of the follower, with exact first and second derivatives.

mod change;
mod checks;
mod class;
mod csv_numbers;
mod cycle;
mod derivative;
pub(crate) mod document;
mod drive;
pub mod examples;
mod expression;
pub(crate) mod file;
pub mod fit;
mod formula;
mod fourier;
mod hub;
mod jet;
mod keyframes;
mod measured;
mod path;
mod rows;
mod source;
mod spline;
mod starter;
pub mod survey;
mod table;

pub use change::Change;
pub use class::Class;
pub use cycle::Cycle;
pub use drive::Drive;
pub use file::{MotionFile, read_csv, unusable_name};
pub use formula::Formula;
pub use keyframes::{Keyframe, Keyframes};
pub use measured::Measured;
pub use path::Path;
pub use starter::starter;
pub use table::{COLUMNS as TABLE_COLUMNS, Table};

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
    /// Its rotation as a quaternion. In closed form: `UnitQuaternion::from_matrix` iterates, and stays
    /// where it began at exactly half a turn.
    pub fn quaternion(&self) -> UnitQuaternion<f64> {
        Rotation3::from_matrix_unchecked(self.rotation).into()
    }

    /// Body point → Σ.
    pub fn apply(&self, q: Vector3<f64>) -> Vector3<f64> {
        self.rotation * q + self.translation
    }

    /// Σ point → body.
    pub fn inverse_apply(&self, p: Vector3<f64>) -> Vector3<f64> {
        self.rotation.transpose() * (p - self.translation)
    }

    /// `self · other`: first `other`, then `self`.
    pub fn mul(&self, other: &Pose) -> Pose {
        Pose {
            rotation: self.rotation * other.rotation,
            translation: self.apply(other.translation),
        }
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
}

/// A motion as the user gave it, self-contained (files inlined).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[allow(clippy::large_enum_variant)] // there is one of them
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

impl MotionSource {
    /// The phases that the motion runs through; only formulas can be told to go there and back.
    pub fn cycle(&self) -> Cycle {
        match self {
            MotionSource::Formula(formula) => formula.cycle(),
            _ => Cycle::turning(),
        }
    }
}

/// The follower's motion M²(φ), 2π-periodic up to whole turns about its own axis, or over a range of φ.
#[derive(Debug, Clone)]
pub struct Motion {
    class: Class,
    cycle: Cycle,
    /// Mean speed at which the follower turns against the driver, per phase.
    turning: f64,
    shape: Shape,
    align: UnitQuaternion<f64>,
    /// Share of the departure from the uniform turn; `None` is all of it.
    share: Option<f64>,
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
    /// make −1 turn about its mean axis per period (in a range: does not turn against the driver all
    /// the way), or leans too far.
    pub fn new(class: Class, source: &MotionSource) -> Result<Motion> {
        let shape = Shape::new(class, source)?;
        let cycle = source.cycle();
        let identity = UnitQuaternion::identity();
        let align = if class.is_spherical() {
            let axes = cycle.phases(checks::SAMPLES).map(|phi| {
                let rotation = shape.at(phi).state().pose.rotation;
                rotation.row(2).transpose() / checks::SAMPLES as f64
            });
            // What is not a number is named by the checks below.
            let hub = hub::mean_direction(axes)?;
            hub::align_to(hub)
        } else {
            identity
        };
        let turning = checks::check((class, cycle), |phi| shape.at(phi).turned(&align).state())?;
        Ok(Motion {
            class,
            cycle,
            turning,
            shape,
            align,
            share: None,
        })
    }

    /// The same motion with `share` (0 to 1) of its departure from the uniform turn: tilts, changes of
    /// speed and translations.
    pub fn scaled(&self, share: f64) -> Motion {
        Motion {
            share: Some(share),
            ..self.clone()
        }
    }

    /// The phases that it runs through.
    pub fn cycle(&self) -> Cycle {
        self.cycle
    }

    /// Mean speed at which the follower turns against the driver, per phase: 1 where it is periodic.
    pub fn turning(&self) -> f64 {
        self.turning
    }

    /// Class the motion belongs to.
    pub fn class(&self) -> Class {
        self.class
    }

    /// Pose, twist and twist rate of the follower at driver angle `phi` (rad), exact derivatives.
    ///
    /// The follower's frame has its origin at the joint's centre and its z axis on the hub axis.
    pub fn state(&self, phi: f64) -> MotionState {
        self.projected(self.jet(phi)).state()
    }

    /// Pose of the follower's frame with derivatives.
    fn jet(&self, phi: f64) -> PoseJet {
        let jet = self.shape.at(phi).turned(&self.align);
        self.share.map_or(jet, |share| jet.scaled(share, phi))
    }

    /// Pose of the frame that the motion file speaks of (of the whole motion, not a scaled one); differs from [`Motion::state`]'s by a
    /// constant turn if that frame's z axis is not the hub axis.
    pub fn user_pose(&self, phi: f64) -> Pose {
        self.projected(self.shape.at(phi)).state().pose
    }

    /// Centre C(φ) of the follower-support joint in Σ: O, moved along z where the class slides.
    pub fn joint_centre(&self, phi: f64) -> Vector3<f64> {
        let translation = self.projected(self.jet(phi)).translation;
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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_scaled_motion_goes_from_the_uniform_turn_to_the_whole() {
        let source: MotionSource = serde_json::from_value(serde_json::json!({
            "kind": "formula", "own_turn": "-phi + 0.2*sin(phi)",
            "axis": ["0.2*sin(phi)", "0.15*cos(2*phi)", "1"], "translation": ["0", "0", "2*sin(phi)"]
        }))
        .unwrap();
        let motion = Motion::new(Class::R3T1, &source).unwrap();
        let uniform = Motion::new(Class::R3T1, &MotionSource::Uniform {}).unwrap();
        for phi in [0.3, 1.7, 4.4, 6.1] {
            let close = |a: MotionState, b: MotionState| {
                assert_relative_eq!(a.pose.rotation, b.pose.rotation, epsilon = 1e-12);
                assert_relative_eq!(a.pose.translation, b.pose.translation, epsilon = 1e-12);
                assert_relative_eq!(a.omega, b.omega, epsilon = 1e-12);
                assert_relative_eq!(a.omega_rate, b.omega_rate, epsilon = 1e-12);
                assert_relative_eq!(a.v_origin_rate, b.v_origin_rate, epsilon = 1e-12);
            };
            close(motion.scaled(1.0).state(phi), motion.state(phi));
            close(motion.scaled(0.0).state(phi), uniform.state(phi));
            let half = motion.scaled(0.5);
            let (before, at, after) = (
                half.state(phi - 1e-5),
                half.state(phi),
                half.state(phi + 1e-5),
            );
            assert_relative_eq!(
                (after.omega - before.omega) / 2e-5,
                at.omega_rate,
                epsilon = 1e-7
            );
            let tilt = |state: &MotionState| state.pose.rotation[(2, 2)].acos();
            assert_relative_eq!(tilt(&at), 0.5 * tilt(&motion.state(phi)), epsilon = 2e-3);
            assert_relative_eq!(half.joint_centre(phi), 0.5 * motion.joint_centre(phi));
        }
    }
}
