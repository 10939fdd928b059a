//! Why a motion has no mechanism, where it is worst, and what to change.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::candidates::{Candidate, Workshop};
use crate::Error;
use crate::motion::{Motion, survey};
use crate::settings::{PairCount, Settings};
use crate::sub_gear::Flaw;

/// No band was usable by itself; `flaws` counts what the `drawn` ones failed of, `tooth` says which
/// tooth is hardest ([`worst_tooth`]) where that is known.
pub(super) fn no_band(
    (motion, settings): (&Motion, &Settings),
    (flaws, drawn): (&BTreeMap<Flaw, usize>, usize),
    tooth: &str,
) -> Error {
    let worst = flaws.iter().max_by_key(|(_, count)| **count);
    let out_of_reach = out_of_reach(flaws, drawn);
    let unequal = unequal(settings);
    let (reason, hint) = match worst.map(|(flaw, _)| *flaw) {
        _ if out_of_reach => (
            "the motion range is so large that the follower reaches the driver's hub or the socket",
            "smaller tilt or stroke, larger gear.center_distance_mm, thinner hubs",
        ),
        Some(Flaw::Gap | Flaw::Cusp | Flaw::Fold | Flaw::Degenerate) => (
            "the motion turns too sharply for teeth: their surfaces cross or fold beside the contact",
            "smaller tilt, stroke or change of speed, or the same spread over more of the turn; \
             more teeth (gear.teeth), a smaller contact ratio (gear.contact_ratio)",
        ),
        _ => (
            "teeth of every band tried collide with each other",
            "thinner teeth, fewer teeth, or a smaller contact ratio",
        ),
    };
    let place = match out_of_reach {
        true => farthest(motion, settings),
        false => sharpest(motion, settings),
    };
    let counts: Vec<String> = flaws
        .iter()
        .map(|(flaw, count)| format!("{count} {flaw}"))
        .collect();
    Error::Infeasible {
        reason: format!("{reason}{}", strangers(settings)),
        place: format!(
            "{place}; {tooth}none of {drawn} candidate bands is usable: {}",
            counts.join(", ")
        ),
        hint: format!("{unequal}{hint}"),
    }
}

/// A share of the bands that has teeth that can be made is enough to say what those teeth fail of.
const MADE: f64 = 0.2;

/// Whether most of the teeth that can be made by themselves are where the other gear's hub or the socket is.
fn out_of_reach(flaws: &BTreeMap<Flaw, usize>, drawn: usize) -> bool {
    let count = |list: &[Flaw]| -> usize { list.iter().filter_map(|flaw| flaws.get(flaw)).sum() };
    let blocked = count(&[Flaw::Hub, Flaw::Joint]);
    let made = blocked + count(&[Flaw::Spacing, Flaw::Teeth]);
    made as f64 > MADE * drawn as f64 && 2 * blocked > made
}

/// What becomes of teeth where the driver has more of them than the follower; empty where it has not.
fn strangers(settings: &Settings) -> String {
    let gear = &settings.gear;
    if gear.drive().copies() == 1 {
        return String::new();
    }
    format!(
        "; with {} teeth on the driver and {} on the follower the driver's are longer, stand closer together, \
         and meet teeth of the follower that are not their mates",
        gear.teeth_on_driver(),
        gear.tooth_pairs()
    )
}

/// The tooth that most bands fail at, by its contact interval; empty when few fail by themselves.
pub(super) fn worst_tooth(workshop: &Workshop, settings: &Settings) -> String {
    let failures = workshop.failures(settings.search.seed, TRIED);
    let worst = (0..failures.len()).max_by_key(|&j| (failures[j], std::cmp::Reverse(j)));
    let Some(j) = worst.filter(|&j| failures[j] >= MANY) else {
        return String::new();
    };
    let cycle = workshop.grid.cycle;
    let edge = |j: usize| cycle.part(j, failures.len()).to_degrees();
    format!(
        "tooth {} (φ = {:.0}° to {:.0}°) fails by itself in {} of {TRIED} bands, whatever their height; ",
        j + 1,
        edge(j),
        edge(j + 1),
        failures[j]
    )
}

/// Bands looked at tooth by tooth.
const TRIED: usize = 128;
/// So many of them make a tooth the place.
const MANY: usize = 16;

/// How many usable bands there are at either end, pushing either way, and the heights they stand at.
pub(super) fn places(motion: &Motion, usable: &[Candidate]) -> String {
    let ends = if motion.class().is_spherical() {
        [(0.0, f64::INFINITY), (f64::NEG_INFINITY, 0.0)].to_vec()
    } else {
        vec![(f64::NEG_INFINITY, f64::INFINITY)]
    };
    let places: Vec<String> = ends
        .into_iter()
        .map(|(low, high)| {
            let sketches: Vec<_> = usable
                .iter()
                .map(|c| c.law.sketch)
                .filter(|s| s.z > low && s.z <= high)
                .collect();
            let forward = sketches.iter().filter(|s| s.side > 0.0).count();
            let heights = sketches.iter().map(|s| s.z);
            let (from, to) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| {
                (a.min(z), b.max(z))
            });
            match sketches.len() {
                0 => "none on one side of the joint".into(),
                n => format!(
                    "{forward} that push forwards and {} backwards at z = {from:.0} to {to:.0} mm",
                    n - forward
                ),
            }
        })
        .collect();
    format!(": {}", places.join("; "))
}

/// Bands were usable, but no K of them go together; `places` says which there are ([`places`]) where
/// that is known, `tooth` which tooth is hardest.
pub(super) fn no_choice(
    (motion, settings): (&Motion, &Settings),
    (usable, places): (usize, &str),
    tooth: &str,
) -> Error {
    let least = motion.class().dof() + 1;
    let fewer = match settings.gear.sub_gear_pairs {
        PairCount::Fixed(k) if k > least => {
            format!("fewer sub-gear pairs (gear.sub_gear_pairs = {k}, {least} may do), ")
        }
        _ => String::new(),
    };
    Error::Infeasible {
        reason: format!(
            "no set of bands fits side by side on the gears{}",
            strangers(settings)
        ),
        place: format!(
            "{}; {tooth}{usable} usable bands, too few of which go together{places}",
            sharpest(motion, settings)
        ),
        hint: format!(
            "{}{fewer}smaller tilt or stroke, thinner teeth (gear.tooth_thickness_mm = {}), or search.effort above {}",
            unequal(settings),
            settings.gear.tooth_thickness_mm,
            settings.search.effort
        ),
    }
}

/// What helps where the driver has more teeth than the follower; empty where it has not.
fn unequal(settings: &Settings) -> String {
    let drive = settings.gear.drive();
    if drive.copies() == 1 {
        return String::new();
    }
    // Where teeth stand as far apart as those of equal gears.
    let distance = drive.center_distance() / drive.follower_share(1.0);
    format!(
        "a larger gear.center_distance_mm (at {distance:.1} teeth stand as far apart as with equal numbers), or \
         gear.driver_teeth = {}; ",
        settings.gear.tooth_pairs()
    )
}

/// Where the motion changes fastest, as a phrase.
fn sharpest(motion: &Motion, settings: &Settings) -> String {
    let at = survey::sharpest(motion, settings.gear.center_distance_mm);
    format!(
        "it changes fastest at φ = {:.0}° ({:.1} mm/rad² at the pitch radius)",
        at.phi_deg, at.most_mm_rad2
    )
}

/// Where the axis of the motion file's frame is farthest from upright, as a phrase; where the motion changes fastest
/// if it never tilts.
fn farthest(motion: &Motion, settings: &Settings) -> String {
    let tilt = |phi: f64| {
        let axis = motion.user_pose(phi).rotation.column(2).into_owned();
        (phi.to_degrees(), axis.angle(&Vector3::z()).to_degrees())
    };
    let tilts = motion.cycle().phases(PHASES).map(tilt);
    match tilts.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((phi, tilt)) if tilt > 0.5 => {
            format!("it leans farthest at φ = {phi:.0}° ({tilt:.1}°)")
        }
        _ => sharpest(motion, settings),
    }
}

/// Phases at which the tilt is looked at.
const PHASES: usize = 360;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Class, MotionSource};

    #[test]
    fn the_sharpest_phase_of_a_stroke_is_at_its_end() {
        let stroke: MotionSource = serde_json::from_value(serde_json::json!({
            "kind": "formula", "own_turn": "-phi", "translation": ["0", "0", "3*sin(phi)"]
        }))
        .unwrap();
        let motion = Motion::new(Class::R1T1, &stroke).unwrap();
        let place = sharpest(&motion, &Settings::default());
        assert!(place.contains("φ = 90°"), "{place}");
        assert!(place.contains("(3.0 mm/rad²"), "{place}");
    }
}
