//! Measured or hand-made poses as they come, and their departure from a uniform turn.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, RowDVector, UnitQuaternion, Vector3};

use super::class::Class;
use super::csv_numbers;
use super::fit::Deviation;
use super::hub::{align_to, mean_direction, net_turns, unwrapped};
use super::rows::Row;
use super::table::COLUMNS;
use crate::{Error, Problem, Problems, Result};

/// Fewest and most poses.
const ROWS: [usize; 2] = [8, 20_000];

/// Longest stretch of φ without a pose, rad.
const LONGEST_GAP: f64 = TAU / 4.0;

/// How far the last pose may be from one period after the first to be its repetition, rad.
const REPEATED: f64 = 1e-6;

/// Components of a pose: rotation vector (rad), position (mm).
pub(super) const COMPONENTS: usize = 6;

/// Poses at phases, as measured: with noise, outliers and a gap where the period closes.
#[derive(Debug, Clone)]
pub struct Measured {
    /// In the order of their phases.
    pub(super) rows: Vec<Row>,
    /// Line of the file that each is on.
    pub(super) lines: Vec<u64>,
}

impl Measured {
    /// Poses from the text of a CSV file with the columns of a pose table; `name` is what problems call
    /// the file. Rows may be in any order and need not end where they began.
    ///
    /// # Errors
    /// [`Error::Input`] with the line of everything that is no pose, and when there are too few or too
    /// many, or none over more than a quarter of the period.
    pub fn from_csv(text: &str, name: &str) -> Result<Measured> {
        let fail = |problems| Err(Error::input(name, problems));
        let lines = match csv_numbers::parse_lines(text, name, &COLUMNS) {
            Ok(lines) => lines,
            Err(problems) => return fail(problems),
        };
        let mut problems = Problems::default();
        let mut placed: Vec<(u64, Row)> = Vec::new();
        for (line, numbers) in lines {
            let numbers = std::array::from_fn(|i| numbers[i]);
            match Row::checked(format!("{name} line {line}"), &numbers) {
                Ok(row) => placed.push((line, row)),
                Err(problem) => problems.push(problem),
            }
        }
        let [least, most] = ROWS;
        let count = placed.len();
        if problems.is_empty() && !(least..=most).contains(&count) {
            let what = format!("the table has {count} rows, allowed {least} to {most}");
            let hint = "36 to 720 rows describe a motion well";
            problems.push(Problem::new(name, what, hint));
        }
        placed.sort_by(|a, b| a.1.phi.total_cmp(&b.1.phi));
        let (lines, rows): (Vec<u64>, Vec<Row>) = placed.into_iter().unzip();
        if problems.is_empty() {
            problems.extend(unseen(&rows).map(|what| {
                let hint = "a motion is fitted to poses from all of its period";
                Problem::new(name, what, hint)
            }));
        }
        if !problems.is_empty() {
            return fail(problems);
        }
        Ok(Measured { rows, lines })
    }

    /// How many poses there are.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// How far the last pose is from the first, where it is one period after it.
    pub(super) fn closing_gap(&self) -> Option<Deviation> {
        let (first, last) = (&self.rows[0], self.rows.last()?);
        let repeats = (last.phi - first.phi - TAU).abs() < REPEATED;
        repeats.then(|| Deviation {
            mm: (last.position - first.position).norm(),
            deg: last.rotation.angle_to(&first.rotation).to_degrees(),
        })
    }

    /// Largest number of harmonics that the poses can tell apart, at least 0.
    pub(super) fn most_harmonics(&self) -> usize {
        let by_count = (self.rows.len() - 1) / 3;
        let by_gap = TAU / 2.0 / longest_gap(&self.rows).1;
        by_count.min(by_gap as usize)
    }
}

/// The longest stretch of the period without a pose: where it begins and how long it is, rad.
fn longest_gap(rows: &[Row]) -> (f64, f64) {
    let mut phases: Vec<f64> = rows.iter().map(|row| row.phi.rem_euclid(TAU)).collect();
    phases.sort_by(f64::total_cmp);
    phases.push(phases[0] + TAU);
    phases
        .windows(2)
        .map(|pair| (pair[0], pair[1] - pair[0]))
        .fold(
            (0.0, 0.0),
            |longest, gap| {
                if gap.1 > longest.1 { gap } else { longest }
            },
        )
}

fn unseen(rows: &[Row]) -> Option<String> {
    let (start, length) = longest_gap(rows);
    (length > LONGEST_GAP + 1e-9).then(|| {
        let [from, to, most] = [start, start + length, LONGEST_GAP].map(f64::to_degrees);
        format!("there is no pose between φ = {from:.1}° and {to:.1}°, allowed are {most:.0}° without one")
    })
}

/// How poses become six numbers that repeat, and back: the rotation vector of what is left of the turn
/// when −φ and a constant turn about z are taken off, and the position.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    /// Takes the body frame to the one that turns about z; see [`super::hub`].
    align: UnitQuaternion<f64>,
    /// Constant turn about z.
    start: UnitQuaternion<f64>,
}

impl Frame {
    /// The frame in which the rows are a motion of `class`.
    ///
    /// # Errors
    /// As [`mean_direction`].
    pub(super) fn new(class: Class, rows: &[Row]) -> Result<Frame> {
        let count = rows.len() as f64;
        let align = match class.is_spherical() {
            true => align_to(mean_direction(
                rows.iter()
                    .map(|row| (row.rotation.inverse() * Vector3::z()) / count),
            )?),
            false => UnitQuaternion::identity(),
        };
        let level = Frame {
            align,
            start: UnitQuaternion::identity(),
        };
        let turns = unwrapped(rows.iter().map(|row| level.wobble(row)));
        let mut turns: Vec<f64> = turns.collect();
        let middle = turns.len() / 2;
        let start = *turns.select_nth_unstable_by(middle, f64::total_cmp).1;
        Ok(Frame {
            start: about_z(start),
            ..level
        })
    }

    fn wobble(&self, row: &Row) -> UnitQuaternion<f64> {
        row.rotation * self.align * about_z(row.phi) * self.start.inverse()
    }

    /// The components of every row.
    pub(super) fn components(&self, rows: &[Row]) -> DMatrix<f64> {
        let rows: Vec<RowDVector<f64>> = rows
            .iter()
            .map(|row| {
                let turn = self.wobble(row).scaled_axis();
                let p = row.position;
                RowDVector::from_row_slice(&[turn.x, turn.y, turn.z, p.x, p.y, p.z])
            })
            .collect();
        DMatrix::from_rows(&rows)
    }

    /// Rotation and position with these components at φ.
    pub(super) fn pose(&self, phi: f64, components: &[f64]) -> (UnitQuaternion<f64>, Vector3<f64>) {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from_column_slice(&components[..3]));
        let rotation = turn * self.start * about_z(-phi) * self.align.inverse();
        (rotation, Vector3::from_column_slice(&components[3..]))
    }

    /// Turns about z of the rows beside −φ, over all of them.
    pub(super) fn turns_beside(&self, rows: &[Row]) -> f64 {
        net_turns(rows.iter().map(|row| self.wobble(row)))
    }
}

fn about_z(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
}
