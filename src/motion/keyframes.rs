//! Motion kind `keyframes`: a few poses in the motion file itself.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::expression::{Expression, builtin_constants};
use super::formula::FORMULA_HINT;
use super::rows::{Row, RowShape};
use crate::{Error, Problem, Problems, Result};

/// Fewest keyframes.
const MIN_KEYFRAMES: usize = 3;

/// Motion kind `keyframes`: poses at increasing phases within one period, joined by a periodic
/// spline of degree five in rotation and translation.
///
/// Degree five is smooth up to the fourth derivative but swings over where the spacing of the
/// keyframes changes a lot; keep them about evenly spaced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframes {
    /// Turn about the follower's own z axis, rad, as an expression in `phi`; applied first.
    #[serde(default = "minus_phi")]
    pub own_turn: String,
    /// The poses.
    pub keyframes: Vec<Keyframe>,
}

/// −φ, the own turn of every gear that is not told otherwise.
pub(super) fn minus_phi() -> String {
    "-phi".to_owned()
}

/// One pose at one phase.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Keyframe {
    /// Driver angle, degrees.
    pub phi_deg: f64,
    /// Position of the joint's centre, mm. Default 0, 0, 0.
    pub position: [f64; 3],
    /// Rotation on top of the own turn, as an axis-angle vector, degrees.
    pub rotation_deg: Option<[f64; 3]>,
    /// Instead: the whole rotation, own turn included, as (w, x, y, z).
    pub quaternion: Option<[f64; 4]>,
}

impl Keyframes {
    pub(super) fn shape(&self) -> Result<RowShape> {
        let mut problems = Problems::default();
        let own_turn = parse_own_turn(&self.own_turn, &mut problems);
        if self.keyframes.len() < MIN_KEYFRAMES {
            let what = format!(
                "has {} keyframes, at least {MIN_KEYFRAMES} are needed",
                self.keyframes.len()
            );
            problems.push(Problem::new("motion.keyframes", what, ""));
        }
        let mut rows = Vec::new();
        for (i, keyframe) in self.keyframes.iter().enumerate() {
            let place = format!("motion.keyframes[{}]", i + 1);
            match keyframe.row(place, &own_turn) {
                Ok(row) => rows.push(row),
                Err(problem) => problems.push(problem),
            }
        }
        if !problems.is_empty() {
            return Err(Error::input("motion", problems));
        }
        RowShape::new(&rows, own_turn)
    }
}

impl Keyframe {
    fn row(&self, place: String, own_turn: &Expression) -> std::result::Result<Row, Problem> {
        let quaternion = match (self.quaternion, self.rotation_deg) {
            (Some(_), Some(_)) => {
                let what = "has both `quaternion` and `rotation_deg`";
                return Err(Problem::new(place, what, "keep one of them"));
            }
            (Some(quaternion), None) => quaternion,
            (None, rotation_deg) => {
                let vector = Vector3::from(rotation_deg.unwrap_or_default());
                if !vector.iter().all(|v| v.is_finite()) {
                    let what = "rotation_deg is not a finite number";
                    return Err(Problem::new(place, what, ""));
                }
                let own = own_turn.at(self.phi_deg.to_radians()).re;
                let q = UnitQuaternion::from_scaled_axis(vector.map(f64::to_radians))
                    * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), own);
                [q.w, q.i, q.j, q.k]
            }
        };
        let [x, y, z] = self.position;
        let [w, i, j, k] = quaternion;
        Row::checked(place, &[self.phi_deg, x, y, z, w, i, j, k])
    }
}

/// The own turn as an expression; zero, and a problem, if it is none.
pub(super) fn parse_own_turn(text: &str, problems: &mut Problems) -> Expression {
    Expression::parse(text, &builtin_constants()).unwrap_or_else(|what| {
        problems.push(Problem::new("motion.own_turn", what, FORMULA_HINT));
        Expression::Constant(0.0)
    })
}
