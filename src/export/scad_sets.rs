//! Parameter sets for OpenSCAD's Customizer: ready-made values for common printers and motors.

use std::collections::BTreeMap;

use serde::Serialize;

use super::File;
use super::scad_options::Options;
use super::scad_teeth::number;
use crate::settings::Profile;
use crate::solid::recipe::Recipe;
use crate::{Error, Result};

/// File of the sets, for `openscad -p parameters.json -P NAME driver.scad`.
pub const NAME: &str = "parameters.json";

/// A set: its name, and values as the Customizer writes them.
type Set = (&'static str, &'static [(&'static str, &'static str)]);

/// How finely the teeth are made. Parameters that a script does not have are passed over by OpenSCAD.
const QUALITIES: [Set; 2] = [
    ("draft", &[("quality", "draft")]),
    ("fine", &[("quality", "fine")]),
];

/// Motors and bearings; their values go before a printer's.
const DRIVES: [Set; 4] = [
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

/// Printers that there are sets for.
const PRINTERS: [Profile; 4] = [Profile::Sla, Profile::Sls, Profile::Fdm04, Profile::Fdm06];

/// What a set for a printer makes: everything, flat on the bed.
const PRINTED: [(&str, &str); 3] = [("layout", "print"), ("piece", "whole"), ("part", "all")];

/// Values for parts made as `profile` says, in words of the scripts.
fn made(profile: Profile) -> Values {
    let needs = profile.allowances();
    let mut values = values(&[&PRINTED]);
    for (name, value) in [
        ("clearance", needs.clearance_mm),
        ("joint_play", needs.joint_play_mm),
        ("piece_fit", needs.piece_fit_mm),
        ("bore_fit", needs.bore_fit_mm),
        ("bearing_fit", needs.bearing_fit_mm),
        ("elephant_foot", needs.elephant_foot_mm),
    ] {
        values.insert(name.to_string(), number(value, 3));
    }
    if profile == Profile::Sla {
        values.insert("quality".into(), "fine".into());
    }
    values
}

/// Values by parameter, as text.
type Values = BTreeMap<String, String>;

#[derive(Serialize)]
struct Page {
    #[serde(rename = "fileFormatVersion")]
    version: &'static str,
    #[serde(rename = "parameterSets")]
    sets: BTreeMap<String, Values>,
}

/// The sets that a design allows, in the Customizer's format: qualities, printers, motors and bearings,
/// these with each printer (`motor_nema17+fdm_0.4`), and each printer for a single piece (`sla+bridge`).
///
/// # Errors
/// [`Error::Internal`] when they cannot be written.
pub fn file(recipe: &Recipe) -> Result<File> {
    let mut sets = BTreeMap::new();
    let alone = QUALITIES.iter().chain(&DRIVES);
    sets.extend(alone.map(|(name, own)| (name.to_string(), values(&[own]))));
    let pieces = recipe.bodies.iter().flat_map(|body| &body.pieces);
    let pieces: Vec<&str> = pieces.map(|piece| piece.name.as_str()).collect();
    for profile in PRINTERS {
        let (printer, own) = (profile.name(), made(profile));
        let with = |more: &[(&str, &str)]| {
            let mut all = own.clone();
            all.extend(values(&[more]));
            all
        };
        sets.insert(printer.to_string(), own.clone());
        for (drive, more) in DRIVES {
            sets.insert(format!("{drive}+{printer}"), with(more));
        }
        for piece in &pieces {
            let only = [("piece", *piece), ("part", *piece)];
            sets.insert(format!("{printer}+{piece}"), with(&only));
        }
    }
    let offered = Options::of(recipe);
    sets.retain(|_, values| allowed(values, recipe, &offered));
    let page = Page { version: "1", sets };
    let text =
        serde_json::to_string_pretty(&page).map_err(|e| Error::Internal(format!("{NAME}: {e}")))?;
    Ok(File::new(NAME, text + "\n"))
}

/// Values of several lists, the later ones before the earlier ones.
fn values(lists: &[&[(&str, &str)]]) -> Values {
    let all = lists.iter().copied().flatten();
    all.map(|(name, value)| (name.to_string(), value.to_string()))
        .collect()
}

/// Whether every value that belongs to a parameter of the recipe lies in its range, and there is room for
/// shaft and bearing.
fn allowed(values: &Values, recipe: &Recipe, offered: &Options) -> bool {
    values.iter().all(|(name, value)| {
        let parameter = recipe.parameters.iter().find(|p| p.name == *name);
        match (name.as_str(), parameter, value.parse::<f64>()) {
            ("bore_preset", ..) => offered.has_shaft(value),
            ("bearing", ..) => offered.has_bearing(value),
            (_, Some(p), Ok(value)) => (p.min..=p.max).contains(&value),
            _ => true,
        }
    })
}
