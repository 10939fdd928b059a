//! Motion kind `path`: the curve of an end-effector, turned into poses.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use num_dual::Dual2_64;
use serde::{Deserialize, Serialize};

use super::Class;
use super::csv_numbers;
use super::expression::Expression;
use super::jet::{about_z, compose, z_to};
use super::keyframes::{minus_phi, parse_own_turn};
use super::rows::{Row, RowShape};
use crate::{Error, Problem, Problems, Result};

/// Fewest points of a path.
const MIN_POINTS: usize = 6;

/// Points may be off their circle or sphere by this share of its radius; only their direction counts.
const ROUNDNESS: f64 = 1e-3;

/// Motion kind `path`: a closed curve of the end-effector in Σ, mm, at least 6 points.
///
/// * 3R: the end-effector sits on the follower's axis; the points lie on a sphere around O.
/// * 3R1T: the same with the joint's centre moving along z; `radius_mm` is its distance to the
///   end-effector, which is above it.
/// * 1R, 1R1T: the end-effector sits beside the axis; the points lie on a circle or cylinder around
///   z, and their angle is the turn of the follower. In 1R1T the stroke is their z, from its middle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Path {
    /// Points `[phi_deg, x, y, z]`, or `[x, y, z]` to be passed at constant speed from φ = 0 on.
    pub points: Vec<Vec<f64>>,
    /// How the end-effector spins about the follower's axis (3R, 3R1T): an expression in `phi`, rad.
    #[serde(default = "minus_phi")]
    pub own_turn: String,
    /// Distance of the end-effector from the joint's centre (3R1T), mm.
    pub radius_mm: Option<f64>,
}

/// A point and the phase (rad) at which it is passed.
struct Passing {
    place: String,
    phi: f64,
    point: Vector3<f64>,
}

impl Path {
    /// A path from the text of a CSV file of points; `name` is what problems call the file.
    ///
    /// # Errors
    /// [`Error::Input`] with the line and column of what is no number.
    pub fn from_csv(text: &str, name: &str) -> Result<Path> {
        let points = parse_points(text, name).map_err(|problems| Error::input(name, problems))?;
        Ok(Path {
            points,
            own_turn: minus_phi(),
            radius_mm: None,
        })
    }

    pub(super) fn shape(&self, class: Class) -> Result<RowShape> {
        let mut problems = Problems::default();
        let own_turn = parse_own_turn(&self.own_turn, &mut problems);
        let passings = self.passings(&mut problems);
        if class == Class::R3T1 && self.radius_mm.is_none() {
            let what = "is missing: how far the end-effector is from the joint's centre";
            problems.push(Problem::new(
                "motion.radius_mm",
                what,
                "for example radius_mm = 40",
            ));
        }
        if class != Class::R3T1 && self.radius_mm.is_some() {
            let what = format!("class {class} takes the radius from the points");
            problems.push(Problem::new("motion.radius_mm", what, "remove it"));
        }
        if !class.is_spherical() && self.own_turn != minus_phi() {
            let what = format!("in class {class} the points alone say how the follower turns");
            problems.push(Problem::new("motion.own_turn", what, "remove it"));
        }
        if problems.is_empty() {
            problems.append(self.off_surface(class, &passings));
        }
        if !problems.is_empty() {
            return Err(Error::input("motion", problems));
        }
        let middle = middle(passings.iter().map(|passing| passing.point.z));
        let rows: Vec<Row> = passings
            .into_iter()
            .map(|passing| self.row(class, passing, &own_turn, middle))
            .collect();
        RowShape::new(&rows, own_turn)
    }

    /// Points with phases.
    fn passings(&self, problems: &mut Problems) -> Vec<Passing> {
        let count = self.points.len();
        if count < MIN_POINTS {
            let what = format!("has {count} points, at least {MIN_POINTS} are needed");
            problems.push(Problem::new(
                "motion.points",
                what,
                "24 points describe a curve well",
            ));
            return Vec::new();
        }
        let width = self.points[0].len();
        let mut list = Vec::with_capacity(count);
        for (i, numbers) in self.points.iter().enumerate() {
            let place = format!("motion.points[{}]", i + 1);
            let what = if numbers.len() != width || !(3..=4).contains(&width) {
                "must have 3 numbers x, y, z, or 4 numbers phi_deg, x, y, z, like all the others"
            } else if !numbers.iter().all(|v| v.is_finite()) {
                "has a number that is not finite"
            } else {
                list.push(Passing {
                    place,
                    phi: if width == 4 {
                        numbers[0].to_radians()
                    } else {
                        0.0
                    },
                    point: Vector3::from_column_slice(&numbers[width - 3..]),
                });
                continue;
            };
            problems.push(Problem::new(place, what, ""));
        }
        if width == 3 && list.len() == count {
            at_constant_speed(&mut list, problems);
        }
        list
    }

    /// Distance that the surface of the class keeps from its centre or axis.
    fn radius(class: Class, point: Vector3<f64>) -> f64 {
        match class {
            Class::R1 | Class::R1T1 => point.xy().norm(),
            Class::R3 | Class::R3T1 => point.norm(),
        }
    }

    /// Points that the class's end-effector cannot reach.
    fn off_surface(&self, class: Class, passings: &[Passing]) -> Problems {
        let mut problems = Problems::default();
        if let (Class::R3T1, Some(radius)) = (class, self.radius_mm) {
            if !(radius > 0.0 && radius.is_finite()) {
                let what = format!("is {radius}, allowed more than 0");
                problems.push(Problem::new("motion.radius_mm", what, ""));
            }
            for passing in passings {
                let aside = passing.point.xy().norm();
                if aside >= radius {
                    let what = format!(
                        "is {aside:.3} mm away from the z axis at φ = {:.1}°, radius_mm = {radius} allows less",
                        passing.phi.to_degrees()
                    );
                    problems.push(Problem::new(&passing.place, what, ""));
                }
            }
            return problems;
        }
        let mean = passings
            .iter()
            .map(|p| Self::radius(class, p.point))
            .sum::<f64>()
            / passings.len() as f64;
        let surface = match class {
            Class::R3 | Class::R3T1 => "sphere around O",
            Class::R1 | Class::R1T1 => "cylinder around z",
        };
        for passing in passings {
            let off = Self::radius(class, passing.point) - mean;
            if !(off.abs() <= ROUNDNESS * mean && mean > 0.0) {
                let what = format!(
                    "is off the {surface} of radius {mean:.3} mm by {off:.4} mm at φ = {:.1}°; class {class} cannot leave it",
                    passing.phi.to_degrees()
                );
                problems.push(Problem::new(
                    &passing.place,
                    what,
                    "project the points onto it",
                ));
            }
        }
        problems
    }

    /// Pose of the follower that brings its end-effector to the point.
    fn row(&self, class: Class, passing: Passing, own_turn: &Expression, middle: f64) -> Row {
        let Passing { place, phi, point } = passing;
        let z = Vector3::z_axis();
        let own = own_turn.at(phi).re;
        let (rotation, lift) = match (class, self.radius_mm) {
            (Class::R1 | Class::R1T1, _) => {
                let angle = point.y.atan2(point.x);
                (UnitQuaternion::from_axis_angle(&z, angle), point.z - middle)
            }
            (Class::R3T1, Some(radius)) => {
                let height = (radius * radius - point.xy().norm_squared()).sqrt();
                let axis = Vector3::new(point.x, point.y, height);
                (spinning(axis, own), point.z - height)
            }
            (Class::R3 | Class::R3T1, _) => (spinning(point, own), 0.0),
        };
        Row {
            place,
            phi,
            position: Vector3::new(0.0, 0.0, lift),
            rotation,
        }
    }
}

/// Smallest turn from z to `axis` after the turn `own` about z.
fn spinning(axis: Vector3<f64>, own: f64) -> UnitQuaternion<f64> {
    let constant = [axis.x, axis.y, axis.z].map(Dual2_64::from_re);
    let [w, x, y, z] = compose(&z_to(&constant), &about_z(Dual2_64::from_re(own)));
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w.re, x.re, y.re, z.re))
}

/// Phases from the lengths of the chords, the closing one included.
fn at_constant_speed(list: &mut [Passing], problems: &mut Problems) {
    let n = list.len();
    let chords: Vec<f64> = (0..n)
        .map(|i| (list[(i + 1) % n].point - list[i].point).norm())
        .collect();
    let total: f64 = chords.iter().sum();
    let mut passed = 0.0;
    for (i, (passing, chord)) in list.iter_mut().zip(&chords).enumerate() {
        passing.phi = TAU * passed / total;
        passed += chord;
        if *chord <= 1e-6 * total {
            let place = format!("motion.points[{}]", i + 1);
            let what = "is the same as the next point (the first one follows the last)";
            problems.push(Problem::new(place, what, "remove one of them"));
        }
    }
}

/// Middle between the smallest and the largest value.
fn middle(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    (low + high) / 2.0
}

/// Reads the text of a CSV file of points, with or without phases; `name` is what problems call it.
pub(super) fn parse_points(text: &str, name: &str) -> std::result::Result<Vec<Vec<f64>>, Problems> {
    let first = text
        .lines()
        .find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let columns = first.map_or(0, |line| line.split(',').count());
    if columns == 3 {
        csv_numbers::parse(text, name, &["x", "y", "z"])
    } else {
        csv_numbers::parse(text, name, &["phi_deg", "x", "y", "z"])
    }
}
