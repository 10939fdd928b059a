//! What the Customizer shows: parameters with their ranges, in groups.

use serde::Serialize;

use super::scad_teeth::{self, number};
use super::{Source, scad_csg};
use crate::design::{Design, SubGearPair};
use crate::solid::recipe::{Body, Parameter, Recipe};

/// Smallest flank radius that the Customizer offers, mm.
const LEAST_FLANK: f64 = 0.4;

/// A Customizer entry.
#[derive(Serialize)]
pub(super) struct Entry {
    name: String,
    value: String,
    min: String,
    max: String,
    step: &'static str,
    description: String,
}

impl Entry {
    fn new(p: &Parameter) -> Entry {
        Entry {
            name: p.name.clone(),
            value: number(p.value, 4),
            min: number(p.min, 4),
            max: number(p.max, 4),
            step: if p.max - p.min < 2.0 { "0.01" } else { "0.1" },
            description: p.description.clone(),
        }
    }
}

#[derive(Serialize)]
pub(super) struct Group {
    name: String,
    entries: Vec<Entry>,
}

/// Parameters that the bodies' features and pieces use, in display order.
pub(super) fn used_parameters<'a>(recipe: &'a Recipe, bodies: &[Body]) -> Vec<&'a Parameter> {
    let mut names = std::collections::BTreeSet::new();
    for body in bodies {
        names.extend(scad_csg::names(&body.features));
        for piece in &body.pieces {
            names.extend(scad_csg::names(&piece.features));
        }
    }
    let parameters = recipe.parameters.iter();
    parameters.filter(|p| names.contains(&p.name)).collect()
}

/// The Customizer's groups of the parameters that may be turned.
pub(super) fn groups(parameters: &[&Parameter]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for p in parameters.iter().filter(|p| p.min < p.max) {
        match groups.iter_mut().find(|g| g.name == p.group) {
            Some(group) => group.entries.push(Entry::new(p)),
            None => groups.push(Group {
                name: p.group.clone(),
                entries: vec![Entry::new(p)],
            }),
        }
    }
    groups
}

/// What teeth and motion dictate: not in the Customizer.
pub(super) fn fixed(parameters: &[&Parameter]) -> Vec<Entry> {
    let dictated = parameters.iter().filter(|p| p.min >= p.max);
    dictated.map(|p| Entry::new(p)).collect()
}

/// Customizer group of the section.
pub(super) fn tooth_group(source: &Source) -> Group {
    let design = source.design;
    let s = &design.section;
    let wall = design.settings.gear.minimum_wall_mm;
    let entry = |name: &str, value: f64, (min, max): (f64, f64), description: &str| Entry {
        name: name.into(),
        value: number(value, 4),
        min: number(min.min(value), 4),
        max: number(max.max(value), 4),
        step: "0.01",
        description: description.into(),
    };
    let flank = |(k, pair): (usize, &SubGearPair)| {
        let radius = design.section_of(pair).flank_radius;
        entry(
            &format!("flank_radius_{}", k + 1),
            radius,
            (LEAST_FLANK, radius),
            &format!(
                "radius of the flanks of sub-gear pair {}; a larger one would break conjugation, a smaller \
                 one keeps the contact but carries less",
                k + 1
            ),
        )
    };
    let mut teeth = vec![
        entry(
            "tooth_thickness",
            s.thickness,
            (wall, s.thickness),
            "thickness across the bead, measured away from the contact; a thicker one would meet the next tooth",
        ),
        entry(
            "tooth_tip",
            s.tip,
            (0.3 * s.bead_radius(), s.tip),
            "height beyond the contact point; lower is harmless",
        ),
        entry(
            "tooth_root",
            s.root,
            (0.1, s.root),
            "depth of the section behind the contact point; harmless while the wall covers it",
        ),
        entry(
            "clearance",
            s.clearance,
            (0.0, 2.0 * scad_teeth::SPARE),
            "flank-to-flank gap, half of it off this gear; both gears want the same value; 0 is the exact contact and binds, more is play",
        ),
    ];
    let flanks = design.sub_gear_pairs.iter().enumerate().map(flank);
    teeth.splice(1..1, flanks);
    Group {
        name: "Teeth".into(),
        entries: teeth,
    }
}

/// Limits of the walls that carry the teeth, mm.
#[derive(Serialize)]
pub(super) struct Spokes {
    /// Least wall.
    wall: String,
    /// Thickness of the walls as designed.
    rib: String,
    /// Thickness of the teeth, which no wall may exceed.
    thickness: String,
    /// Largest fillet: with the thinnest wall.
    fillet: String,
}

impl Spokes {
    pub(super) fn of(design: &Design) -> Spokes {
        let section = &design.section;
        let wall = design.settings.gear.minimum_wall_mm.min(section.rib);
        Spokes {
            wall: number(wall, 4),
            rib: number(section.rib, 4),
            thickness: number(section.thickness, 4),
            fillet: number(0.5 * (section.thickness - wall).max(0.0), 4),
        }
    }
}
