//! Parameter sets for OpenSCAD's Customizer: ready-made values for common printers and motors.

use std::collections::BTreeMap;

use serde::Serialize;

use super::File;
use crate::solid::recipe::Recipe;
use crate::{Error, Result};

/// File of the sets, for `openscad -p parameters.json -P NAME driver.scad`.
pub const NAME: &str = "parameters.json";

/// A set: its name, and values as the Customizer writes them.
type Set = (&'static str, &'static [(&'static str, &'static str)]);

/// All sets. Parameters that a script does not have are passed over by OpenSCAD; sets with a value
/// that a design does not allow are left out.
const SETS: [Set; 9] = [
    ("draft", &[("quality", "draft")]),
    ("fine", &[("quality", "fine")]),
    (
        "sla",
        &[
            ("quality", "fine"),
            ("layout", "print"),
            ("joint_play", "0.08"),
            ("piece_fit", "0.05"),
            ("bore_fit", "0.05"),
        ],
    ),
    (
        "fdm_0.4",
        &[
            ("layout", "print"),
            ("clearance", "0.15"),
            ("joint_play", "0.2"),
            ("piece_fit", "0.15"),
            ("bore_fit", "0.15"),
            ("bearing_fit", "0.1"),
            ("elephant_foot", "0.2"),
        ],
    ),
    (
        "fdm_0.6",
        &[
            ("layout", "print"),
            ("clearance", "0.25"),
            ("joint_play", "0.3"),
            ("piece_fit", "0.2"),
            ("bore_fit", "0.2"),
            ("bearing_fit", "0.15"),
            ("elephant_foot", "0.3"),
        ],
    ),
    (
        "motor_nema17",
        &[("bore_preset", "nema17"), ("shaft_flat", "0.5")],
    ),
    (
        "servo_25t",
        &[
            ("bore_preset", "servo_25t"),
            ("bore_depth", "4"),
            ("bore_fit", "0.05"),
            ("shaft_flat", "0.1"),
        ],
    ),
    (
        "bearings_mr105",
        &[
            ("bearing", "MR105"),
            ("journal_radius", "2.5"),
            ("bearing_wall", "3.9"),
        ],
    ),
    (
        "bearings_608",
        &[
            ("bearing", "608"),
            ("journal_radius", "4"),
            ("bearing_wall", "8.4"),
            ("bridge_thickness", "8"),
            ("plate_thickness", "8"),
        ],
    ),
];

#[derive(Serialize)]
struct Page {
    #[serde(rename = "fileFormatVersion")]
    version: &'static str,
    #[serde(rename = "parameterSets")]
    sets: BTreeMap<&'static str, BTreeMap<&'static str, &'static str>>,
}

/// The sets that a design allows, in the Customizer's format.
///
/// # Errors
/// [`Error::Internal`] when they cannot be written.
pub fn file(recipe: &Recipe) -> Result<File> {
    let sets = SETS
        .into_iter()
        .filter(|(_, values)| allowed(values, recipe));
    let page = Page {
        version: "1",
        sets: sets
            .map(|(name, values)| (name, values.iter().copied().collect()))
            .collect(),
    };
    let text =
        serde_json::to_string_pretty(&page).map_err(|e| Error::Internal(format!("{NAME}: {e}")))?;
    Ok(File::new(NAME, text + "\n"))
}

/// Whether every value that belongs to a parameter of the recipe lies in its range.
fn allowed(values: &[(&str, &str)], recipe: &Recipe) -> bool {
    values.iter().all(|(name, value)| {
        let parameter = recipe.parameters.iter().find(|p| p.name == *name);
        match (parameter, value.parse::<f64>()) {
            (Some(p), Ok(value)) => (p.min..=p.max).contains(&value),
            _ => true,
        }
    })
}
