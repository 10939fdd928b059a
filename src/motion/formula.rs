//! Motion kind `formula`: rotation and translation as expressions in `phi`.

use std::collections::BTreeMap;

use num_dual::Dual2_64;
use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::document::as_key;
use super::expression::{Constants, Expression, builtin_constants, is_taken};
use super::jet::{PoseJet, QuaternionJet, about_vector, about_z, compose, z_to};
use crate::{Problem, Problems};

/// Motion kind `formula`: M²(φ) = translation · rotation · own turn about z (applied first).
///
/// Expressions may use `phi` (rad), `pi`, `deg` (= π/180) and the names in `constants`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Formula {
    /// Names for the other expressions, each an expression without `phi`.
    pub constants: BTreeMap<String, String>,
    /// Turn about the follower's own z axis, rad; it must amount to −1 turn per period.
    pub own_turn: String,
    /// Direction of the follower's axis (any length): the smallest rotation from z to it.
    pub axis: Option<[String; 3]>,
    /// Axis-angle vector of the rotation, rad; instead of `axis`.
    pub rotation: Option<[String; 3]>,
    /// Position of the joint centre, mm.
    pub translation: [String; 3],
    /// Whether the driver turns on and on or goes there and back.
    #[serde(skip_serializing_if = "DriveKind::is_turning")]
    pub drive: DriveKind,
    /// The range of a reciprocating driver, deg; 0 is in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_deg: Option<[f64; 2]>,
}

/// How the driver is driven.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DriveKind {
    /// On and on.
    #[default]
    Turning,
    /// There and back over a range: teeth fill a sector, nothing wraps, the net turn is free.
    Reciprocating,
}

impl DriveKind {
    fn is_turning(&self) -> bool {
        *self == DriveKind::Turning
    }
}

/// Shortest and longest range of a reciprocating driver, deg.
const RANGE: [f64; 2] = [20.0, 330.0];

impl Default for Formula {
    fn default() -> Self {
        Formula {
            constants: BTreeMap::new(),
            own_turn: "-phi".to_owned(),
            axis: None,
            rotation: None,
            translation: ["0", "0", "0"].map(str::to_owned),
            drive: DriveKind::Turning,
            range_deg: None,
        }
    }
}

/// Most characters that all formulas of a motion may have together, bytes.
const MAX_TOTAL: usize = 100_000;

/// Parsed [`Formula`].
#[derive(Debug, Clone)]
pub(super) struct FormulaShape {
    own_turn: Expression,
    wobble: Wobble,
    translation: [Expression; 3],
}

/// The rotation on top of the own turn.
#[derive(Debug, Clone)]
enum Wobble {
    None,
    Axis([Expression; 3]),
    Vector([Expression; 3]),
}

impl Formula {
    /// The phases that the motion runs through; a whole period where the range is none
    /// ([`Formula::shape`] says so).
    pub(super) fn cycle(&self) -> Cycle {
        match (self.drive, self.range_deg) {
            (DriveKind::Reciprocating, Some([from, to])) => {
                Cycle::reciprocating(from.to_radians(), to.to_radians())
            }
            _ => Cycle::turning(),
        }
    }

    fn range_problem(&self) -> Option<Problem> {
        let [least, most] = RANGE;
        let problem = |what: String, hint: &str| Some(Problem::new("motion.range_deg", what, hint));
        let written = "write drive = \"reciprocating\" and range_deg = [-60, 60]";
        match (self.drive, self.range_deg) {
            (DriveKind::Turning, None) => None,
            (DriveKind::Turning, Some(_)) => problem(
                "is given, but drive is not \"reciprocating\"".into(),
                written,
            ),
            (DriveKind::Reciprocating, None) => problem("is missing".into(), written),
            (DriveKind::Reciprocating, Some([from, to])) => {
                let length = to - from;
                if !(least..=most).contains(&length) {
                    let what =
                        format!("goes from {from} to {to}, allowed are {least} to {most} degrees");
                    return problem(what, "a driver that turns on needs no range");
                }
                (!(from <= 0.0 && to >= 0.0)).then(|| {
                    let what = format!("goes from {from} to {to}, 0 must be in it");
                    Problem::new(
                        "motion.range_deg",
                        what,
                        "bodies are drawn at φ = 0: shift phi in the formulas",
                    )
                })
            }
        }
    }

    /// Parses all expressions; all problems at once.
    pub(super) fn shape(&self) -> Result<FormulaShape, Problems> {
        let vectors = [self.axis.as_ref(), self.rotation.as_ref()];
        let components = vectors.into_iter().flatten().chain([&self.translation]);
        let texts = components.flatten().chain(self.constants.values());
        let total = texts.map(String::len).sum::<usize>() + self.own_turn.len();
        if total > MAX_TOTAL {
            let what = format!("its formulas have {total} characters, allowed {MAX_TOTAL}");
            let hint = "a table of poses describes such a motion better";
            return Err(vec![Problem::new("motion", what, hint)].into());
        }
        let mut problems = Problems::default();
        problems.extend(self.range_problem());
        let constants = self.constant_values(&mut problems);
        let mut parse = |place: String, text: &str| {
            Expression::parse(text, &constants).unwrap_or_else(|what| {
                problems.push(Problem::new(place, what, FORMULA_HINT));
                Expression::Constant(0.0)
            })
        };
        let own_turn = parse("motion.own_turn".to_owned(), &self.own_turn);
        let mut parse3 = |name: &str, texts: &[String; 3]| {
            [0, 1, 2].map(|i| parse(format!("motion.{name}[{i}]"), &texts[i]))
        };
        let translation = parse3("translation", &self.translation);
        let wobble = match (&self.axis, &self.rotation) {
            (Some(axis), None) => Wobble::Axis(parse3("axis", axis)),
            (None, Some(vector)) => Wobble::Vector(parse3("rotation", vector)),
            (None, None) => Wobble::None,
            (Some(_), Some(_)) => {
                problems.push(Problem::new(
                    "motion",
                    "has both `axis` and `rotation`",
                    "keep one of them",
                ));
                Wobble::None
            }
        };
        if problems.is_empty() {
            Ok(FormulaShape {
                own_turn,
                wobble,
                translation,
            })
        } else {
            Err(problems)
        }
    }

    /// Constants may use the built-in ones only, so their order does not matter.
    fn constant_values(&self, problems: &mut Problems) -> Constants {
        let builtin = builtin_constants();
        let mut constants = builtin.clone();
        for (name, text) in &self.constants {
            let place = format!("motion.constants.{}", as_key(name));
            if is_taken(name) {
                let what = format!("`{name}` has a meaning in formulas already");
                problems.push(Problem::new(place, what, "choose another name"));
                continue;
            }
            let value = match Expression::parse(text, &builtin) {
                Ok(Expression::Constant(value)) if value.is_finite() => value,
                Ok(Expression::Constant(value)) => {
                    problems.push(Problem::new(place, format!("`{text}` is {value}"), ""));
                    0.0
                }
                Ok(Expression::Variable(_)) => {
                    let what = format!("`{text}` depends on phi and so is no constant");
                    problems.push(Problem::new(place, what, "write it where it is used"));
                    0.0
                }
                Err(what) => {
                    problems.push(Problem::new(place, what, FORMULA_HINT));
                    0.0
                }
            };
            constants.insert(name.clone(), value);
        }
        constants
    }
}

/// What a formula may contain.
pub(super) const FORMULA_HINT: &str = "write formulas as in \"2.5*sin(phi)\" with + - * / ^, sin cos tan asin acos atan \
     sinh cosh tanh exp ln sqrt, phi (rad), pi, deg";

impl FormulaShape {
    pub(super) fn at(&self, phi: f64) -> PoseJet {
        let at3 = |e: &[Expression; 3]| -> [Dual2_64; 3] { [0, 1, 2].map(|i| e[i].at(phi)) };
        let own = about_z(self.own_turn.at(phi));
        let rotation: QuaternionJet = match &self.wobble {
            Wobble::None => own,
            Wobble::Axis(axis) => compose(&z_to(&at3(axis)), &own),
            Wobble::Vector(vector) => compose(&about_vector(&at3(vector)), &own),
        };
        PoseJet {
            rotation,
            translation: at3(&self.translation),
        }
    }
}
