//! Which shafts, screws and bearings a design has room for: the scripts offer no others.

use serde::Serialize;

use super::scad_teeth::number;
use crate::solid::recipe::{Parameter, Recipe};

/// Least wall around a bore, mm.
const BORE_WALL: f64 = 0.8;

/// Gap around a shaft that the Customizer begins with, mm.
const BORE_FIT: f64 = 0.1;

/// Least wall around a bearing, and gap around it that the Customizer begins with, mm.
const SEAT: (f64, f64) = (1.2, 0.05);

/// Largest bore and boss of any design, mm.
const LARGEST: (f64, f64) = (40.0, 20.0);

/// Radius of a boss that the Customizer begins with, mm.
const BOSS: f64 = 6.0;

/// Shafts: name, what people call it, diameter and flat, mm. `bore_preset()` of the library has them, too.
const SHAFTS: [(&str, &str, f64, f64); 5] = [
    ("nema14", "NEMA 14", 5.0, 0.5),
    ("nema17", "NEMA 17", 5.0, 0.5),
    ("nema23", "NEMA 23", 6.35, 0.6),
    ("servo_25t", "Servo 25T", 5.9, 0.0),
    ("servo_23t", "Servo 23T", 5.7, 0.0),
];

/// Screws: name, width across flats of the nut and its height, mm; as in `screw_size()`.
const SCREWS: [(&str, f64, f64); 5] = [
    ("M2", 4.0, 1.6),
    ("M2.5", 5.0, 2.0),
    ("M3", 5.5, 2.4),
    ("M4", 7.0, 3.2),
    ("M5", 8.0, 4.7),
];

/// Ball bearings: name, bore, outer diameter and width, mm; as in `bearing_size()`.
const BEARINGS: [(&str, f64, f64, f64); 5] = [
    ("MR84", 4.0, 8.0, 3.0),
    ("MR105", 5.0, 10.0, 4.0),
    ("MR126", 6.0, 12.0, 4.0),
    ("688", 8.0, 16.0, 5.0),
    ("608", 8.0, 22.0, 7.0),
];

/// Smallest shaft with a keyway, half the keyway's width and its depth in the hub, mm (DIN 6885).
const KEYWAY: (f64, f64, f64) = (6.0, 1.0, 1.0);

/// What fits into a round piece of material.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct Bores {
    /// Presets: name and label.
    shafts: Vec<(&'static str, &'static str)>,
    /// Set screws whose nut has room beside the smallest bore.
    screws: Vec<&'static str>,
    /// Whether any keyway fits.
    keyway: bool,
    /// Largest diameter of a bore, mm.
    diameter: String,
    /// The diameter that the Customizer begins with, mm.
    start: String,
    /// Radius of the material at its largest, mm.
    radius: String,
    /// Radius of a boss that the Customizer begins with, mm.
    boss: String,
}

/// What the scripts of a design offer.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct Options {
    /// In the driver's shaft end.
    pub(super) shaft: Option<Bores>,
    /// Smallest flat of the shaft end, mm.
    flat: String,
    /// In a boss on the mount.
    pub(super) boss: Option<Bores>,
    /// Bearings in base and bridge.
    bearings: Vec<&'static str>,
    /// Thickest wall around them, mm.
    eye: String,
}

/// Material for bores: its radius, how much of it a flat takes off one side, the widest nut that its length
/// allows, and the bore that the Customizer begins with, mm.
struct Room {
    radius: f64,
    flat: f64,
    nuts: f64,
    start: f64,
}

impl Options {
    /// What `recipe` has room for, with its parameters as favourable as they can be.
    pub(super) fn of(recipe: &Recipe) -> Options {
        let find = |name: &str| recipe.parameters.iter().find(|p| p.name == name);
        let most = |name: &str| find(name).map_or(0.0, |p| p.max);
        let flat = find("shaft_flat").map_or(0.0, |p| p.min);
        let bearing = |&&(_, bore, outer, width): &&(&str, f64, f64, f64)| {
            let journal = find("journal_radius");
            let journal =
                journal.is_some_and(|p: &Parameter| (p.min..=p.max).contains(&(bore / 2.0)));
            let play = find("joint_play").map_or(0.0, |p| p.value);
            let eye = bore / 2.0 + play + most("bearing_wall");
            let thick = most("plate_thickness").min(most("bridge_thickness"));
            journal && outer / 2.0 + SEAT.1 + SEAT.0 <= eye && width < thick
        };
        Options {
            shaft: bores(Room {
                radius: most("journal_radius"),
                flat,
                nuts: most("shaft_end") / 2.0,
                start: 3.0,
            }),
            flat: number(flat, 4),
            boss: bores(Room {
                radius: most("mount_radius").min(LARGEST.1),
                flat: 0.0,
                nuts: LARGEST.1,
                start: 5.0,
            }),
            bearings: BEARINGS.iter().filter(bearing).map(|b| b.0).collect(),
            eye: number(most("bearing_wall"), 4),
        }
    }

    /// Whether the shaft end has room for a bore of this name.
    pub(super) fn has_shaft(&self, name: &str) -> bool {
        let shafts = self.shaft.iter().flat_map(|bores| &bores.shafts);
        shafts.into_iter().any(|shaft| shaft.0 == name)
    }

    /// Whether base and bridge have room for a bearing of this name.
    pub(super) fn has_bearing(&self, name: &str) -> bool {
        self.bearings.contains(&name)
    }
}

/// What fits into `room`; `None` where no bore does.
fn bores(room: Room) -> Option<Bores> {
    let radius = room.radius - BORE_WALL;
    let diameter = (40.0 * (radius - BORE_FIT)).floor() / 20.0;
    let shaft = |&&(_, _, diameter, flat): &&(&str, &str, f64, f64)| {
        let reach = diameter / 2.0 + BORE_FIT;
        reach <= radius && reach - flat <= radius - room.flat
    };
    let smallest = 0.5 + BORE_FIT;
    let screw = |&&(_, width, height): &&(&str, f64, f64)| {
        room.radius - smallest >= height + 2.0 && room.nuts >= width
    };
    let (least, half, depth) = KEYWAY;
    (diameter >= 1.0).then(|| Bores {
        shafts: SHAFTS.iter().filter(shaft).map(|s| (s.0, s.1)).collect(),
        screws: SCREWS.iter().filter(screw).map(|s| s.0).collect(),
        keyway: half.hypot(least / 2.0 + BORE_FIT + depth) <= radius,
        diameter: number(diameter.min(LARGEST.0), 2),
        start: number(diameter.min(room.start), 2),
        radius: number(room.radius, 4),
        boss: number(room.radius.min(BOSS), 4),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIBRARY: &str = include_str!("../../cad/openscad/mpcgear.scad");

    /// The line of the library that has `name` in quotes after `==`.
    fn row(name: &str) -> &'static str {
        let start = LIBRARY.find(&format!("== \"{name}\" ?"));
        let rest = &LIBRARY[start.unwrap_or_else(|| panic!("no {name}"))..];
        let (from, to) = (rest.find('[').expect("["), rest.find(']').expect("]"));
        &rest[from + 1..to]
    }

    #[test]
    fn the_library_has_the_same_sizes() {
        for (name, _, diameter, flat) in SHAFTS {
            let numbers = format!("{diameter}, {flat}, ");
            assert!(row(name).contains(&numbers), "{name}: {}", row(name));
        }
        for (name, width, height) in &SCREWS[..4] {
            assert!(
                row(name).ends_with(&format!(", {width}, {height}")),
                "{name}"
            );
        }
        assert!(LIBRARY.contains("[5.3, 8, 4.7]"), "M5");
        for (name, bore, outer, width) in BEARINGS {
            assert_eq!(row(name), format!("{bore}, {outer}, {width}"));
        }
        assert!(LIBRARY.contains("shaft <= 8 ? [2, 1]"), "keyway");
    }

    #[test]
    fn a_slim_shaft_is_offered_little_and_a_thick_one_all() {
        let room = |radius: f64| Room {
            radius,
            flat: 0.0,
            nuts: 20.0,
            start: 3.0,
        };
        assert_eq!(bores(room(1.3)), None);
        let slim = bores(room(4.0)).expect("bores");
        let names: Vec<&str> = slim.shafts.iter().map(|s| s.0).collect();
        assert_eq!(names, ["nema14", "nema17", "servo_25t", "servo_23t"]);
        assert!(slim.screws.is_empty() && !slim.keyway);
        assert_eq!(slim.diameter, "6.2");
        let thick = bores(room(12.0)).expect("bores");
        assert!(thick.shafts.len() == 5 && thick.screws.len() == 5 && thick.keyway);
    }
}
