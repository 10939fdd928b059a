//! Motion kind `table`: poses at many phases, from a CSV file.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::csv_numbers;
use super::expression::Expression;
use super::rows::{Row, RowShape};
use crate::{Error, Problem, Problems, Result};

/// Columns of a pose table.
pub const COLUMNS: [&str; 8] = ["phi_deg", "x", "y", "z", "qw", "qx", "qy", "qz"];

/// Fewest rows of a pose table.
const MIN_ROWS: usize = 8;

/// How far the last row's pose may be from the first row's, mm and rad.
const CLOSING_MM: f64 = 1e-3;
const CLOSING_RAD: f64 = 2e-4;

/// Motion kind `table`: rows `phi_deg, x, y, z, qw, qx, qy, qz` (mm; the quaternion takes the
/// follower's frame to Σ), the first and the last one period apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// The rows.
    pub rows: Vec<[f64; 8]>,
}

impl Table {
    pub(super) fn shape(&self) -> Result<RowShape> {
        let fail = |problems| Err(Error::input("motion", problems));
        let mut problems = Problems::default();
        if self.rows.len() < MIN_ROWS {
            problems.push(Problem::new(
                "motion",
                format!(
                    "the table has {} rows, at least {MIN_ROWS} are needed",
                    self.rows.len()
                ),
                "36 rows or more describe a smooth motion well",
            ));
        }
        let mut rows = Vec::with_capacity(self.rows.len());
        for (i, numbers) in self.rows.iter().enumerate() {
            match Row::checked(format!("motion row {}", i + 1), numbers) {
                Ok(row) => rows.push(row),
                Err(problem) => problems.push(problem),
            }
        }
        let (Some(last), true) = (rows.pop(), problems.is_empty()) else {
            return fail(problems);
        };
        let first = &rows[0];
        let length = last.phi - first.phi;
        if rows.windows(2).all(|pair| pair[1].phi > pair[0].phi) && (length - TAU).abs() > 1e-9 {
            problems.push(Problem::new(
                &last.place,
                format!(
                    "phi_deg runs from {:.6} to {:.6}, a period is 360",
                    first.phi.to_degrees(),
                    last.phi.to_degrees()
                ),
                "first and last row must be one period apart, with the same pose",
            ));
            return fail(problems);
        }
        let apart = (last.position - first.position).norm();
        let turned = last.rotation.angle_to(&first.rotation);
        if apart > CLOSING_MM || turned > CLOSING_RAD {
            problems.push(Problem::new(
                &last.place,
                format!(
                    "the motion does not close: the last pose is {apart:.4} mm and {:.3}° away from the first",
                    turned.to_degrees()
                ),
                "the last row must repeat the pose of the first",
            ));
            return fail(problems);
        }
        RowShape::new(&rows, Expression::own_turn()?)
    }
}

impl Table {
    /// A table from the text of a CSV file; `name` is what problems call the file.
    ///
    /// # Errors
    /// [`Error::Input`] with the line and column of what is no number.
    pub fn from_csv(text: &str, name: &str) -> Result<Table> {
        let rows = parse_rows(text, name).map_err(|problems| Error::input(name, problems))?;
        let row = |row: Vec<f64>| std::array::from_fn(|i| row[i]);
        Ok(Table {
            rows: rows.into_iter().map(row).collect(),
        })
    }
}

/// Reads the text of a pose table; `name` is what problems call the file.
pub(super) fn parse_rows(text: &str, name: &str) -> std::result::Result<Vec<Vec<f64>>, Problems> {
    csv_numbers::parse(text, name, &COLUMNS)
}
