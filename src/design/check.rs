//! What a design that was read has to be like: ranges and counts.

use super::{Design, Section, Station, ToothPair, check_recipe};
use crate::motion::unusable_name;
use crate::settings::{FLATTEST, MOST_FLARE};
use crate::{Problem, Problems};

/// Largest coordinate or size anywhere, mm: the largest centre distance a hundred times.
pub(super) const REACH: f64 = 50_000.0;

/// Longest text for people (description, problem).
const TEXT: usize = 1000;

/// Stations of a tooth, fewest and most; our own designs have 201.
const STATIONS: [usize; 2] = [5, 1001];

/// How far the length of a unit vector may be from 1.
const UNIT: f64 = 1e-6;

/// Everything that is wrong with `design`; empty when it can be worked with. In the `first` format
/// the stations say where they are on the gears.
pub(super) fn problems(design: &Design, first: bool) -> Problems {
    let mut found = Problems::default();
    found.extend(design.settings.problems(design.class));
    if let Some((what, hint)) = unusable_name(&design.name) {
        found.push(Problem::new("name", what, hint));
    }
    text(&mut found, || "generator".into(), &design.generator);
    found.count(|| "problems".into(), design.problems.len(), 1000);
    teeth(&mut found, design, first);
    section(&mut found, &design.section);
    closure(&mut found, design);
    check_recipe::recipe(&mut found, &design.recipe, design.class);
    found
}

pub(super) fn text(found: &mut Problems, place: impl FnOnce() -> String, text: &str) {
    if text.len() > TEXT || text.chars().any(char::is_control) {
        let what = "is longer than 1000 bytes or has control characters";
        found.add(|| Problem::new(place(), what, "plain text, on one line"));
    }
}

fn teeth(found: &mut Problems, design: &Design, first: bool) {
    let pairs = &design.sub_gear_pairs;
    found.count(|| "sub_gear_pairs".into(), pairs.len(), 12);
    let wanted = design.tooth_pairs();
    for (k, pair) in pairs.iter().enumerate() {
        let place = || format!("sub_gear_pairs[{k}]");
        let count = pair.teeth.len();
        if count != wanted {
            let what = format!("has {count} teeth, by settings.gear there are {wanted}");
            found.add(|| Problem::new(place(), what, ""));
        }
        if let Some(radius) = pair.flank_radius {
            let place = || format!("sub_gear_pairs[{k}].flank_radius");
            found.range(place, radius, [0.0, FLATTEST]);
        }
        let place = || format!("sub_gear_pairs[{k}].parameters");
        found.count(place, pair.parameters.len(), 1000);
        for (j, tooth) in pair.teeth.iter().enumerate() {
            let place = || format!("sub_gear_pairs[{k}].teeth[{j}]");
            tooth_pair(found, &place, tooth);
            for (i, station) in tooth.stations.iter().enumerate() {
                let place = || format!("{}.stations[{i}]", place());
                self::station(found, &place, station);
                if first {
                    on_gears(found, &place, station);
                } else {
                    point(found, || place() + ".v", station.v);
                }
            }
        }
    }
}

fn tooth_pair(found: &mut Problems, place: &dyn Fn() -> String, tooth: &ToothPair) {
    let [least, most] = STATIONS;
    let count = tooth.stations.len();
    if !(least..=most).contains(&count) {
        let what = format!("are {count}, allowed {least} to {most}");
        found.add(|| Problem::new(place() + ".stations", what, ""));
    }
    found.count(
        || place() + ".control_points",
        tooth.control_points.len(),
        100,
    );
    let numbers = tooth.control_points.iter().flatten();
    for &x in numbers.chain([&tooth.fit_error, &tooth.phi_start, &tooth.phi_end]) {
        found.range(place, x, [-REACH, REACH]);
    }
    for &flare in tooth.flare.iter().flatten() {
        found.range(|| place() + ".flare", flare, [0.0, MOST_FLARE]);
    }
    let increasing = |w: &[Station]| w[0].phi < w[1].phi;
    if !tooth.stations.windows(2).all(increasing) {
        found.add(|| Problem::new(place() + ".stations", "have phi that do not increase", ""));
    }
}

/// Contacts that stand still on a gear: no tooth can be swept there.
pub(super) fn tangents(design: &Design) -> Problems {
    let mut found = Problems::default();
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            for (i, s) in tooth.stations.iter().enumerate() {
                if !s.t1.iter().chain(&s.t2).all(|x| x.is_finite()) {
                    let place = format!("sub_gear_pairs[{k}].teeth[{j}].stations[{i}].v");
                    let what = "is the speed of a gear there: the contact stands still on it";
                    found.add(|| Problem::new(place, what, ""));
                }
            }
        }
    }
    found
}

fn station(found: &mut Problems, place: &dyn Fn() -> String, s: &Station) {
    found.range(|| place() + ".phi", s.phi, [-100.0, 100.0]);
    point(found, || place() + ".p", s.p);
    unit(found, || place() + ".n", s.n);
}

fn on_gears(found: &mut Problems, place: &dyn Fn() -> String, s: &Station) {
    for (name, p) in [("p1", s.p1), ("p2", s.p2)] {
        point(found, || format!("{}.{name}", place()), p);
    }
    for (name, v) in [("n1", s.n1), ("t1", s.t1), ("n2", s.n2), ("t2", s.t2)] {
        unit(found, || format!("{}.{name}", place()), v);
    }
}

/// Coordinates, or a speed, within reach.
fn point(found: &mut Problems, place: impl FnOnce() -> String, p: [f64; 3]) {
    if let Some(x) = p.into_iter().find(|x| !(x.abs() <= REACH)) {
        found.range(place, x, [-REACH, REACH]);
    }
}

/// A vector of length 1.
pub(super) fn unit(found: &mut Problems, place: impl FnOnce() -> String, v: [f64; 3]) {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let allowed = [1.0 - UNIT, 1.0 + UNIT];
    found.range(|| format!("length of {}", place()), length, allowed);
}

fn section(found: &mut Problems, section: &Section) {
    for (name, value, most) in [
        ("thickness", section.thickness, 20.0),
        ("flank_radius", section.flank_radius, FLATTEST),
        ("tip", section.tip, 20.0),
        ("root", section.root, 20.0),
        ("clearance", section.clearance, 2.0),
        ("rib", section.rib, 20.0),
    ] {
        found.range(|| format!("section.{name}"), value, [0.0, most]);
    }
}

fn closure(found: &mut Problems, design: &Design) {
    let samples = &design.closure;
    found.count(|| "closure".into(), samples.len(), 60_000);
    for (i, s) in samples.iter().enumerate() {
        let infinite = s.q == f64::NEG_INFINITY; // no closure at all
        if !(s.phi.is_finite() && (s.q.is_finite() || infinite)) {
            let place = format!("closure[{i}]");
            found.add(|| Problem::new(place, "has numbers that are not finite", ""));
        }
    }
}
