//! How flat the flanks of a band may be: the radius across its teeth that condition (4) leaves free.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::contact::Contact;
use crate::design::{Gear, Section, ToothPair};
use crate::motion::{Drive, Motion, Pose};
use crate::settings::{FLATTEST, Settings};
use crate::solid::section::{self, FLANK};
use crate::solid::sweep::{self, Frame};

/// A radius that is less of a gain over the bead's is not worth an edge.
const WORTH: f64 = 1.2;

/// Radii closer than this to each other, as a share, are the same.
const PRECISION: f64 = 0.02;

/// How much nearer than at the contact flanks may come beside it, mm: what the chords of a section
/// leave.
const SLACK: f64 = 0.005;

/// Share of the gap at the contact that teeth leave which are not in contact.
const PASSING: f64 = 0.75;

/// Phases of the turn at which that is tried.
const PHASES: usize = 240;

/// Frames of two teeth that are farther apart than this have nothing to do with each other, mm.
const NEAR: f64 = 4.0;

/// So many planes to either side of the nearest frame may hold a point beside it.
const PLANES: usize = 3;

/// Least induced normal curvature of two flanks in any direction, 1/mm: 0.004 at L = 25 mm.
pub fn least_curvature(settings: &Settings) -> f64 {
    0.004 / (settings.gear.center_distance_mm / 25.0)
}

/// A band whose flanks are to be made flat.
#[derive(Debug)]
pub struct Band<'a> {
    /// The contacts of all its teeth.
    pub contacts: Vec<Contact>,
    /// Its teeth.
    pub teeth: &'a [ToothPair],
}

impl Band<'_> {
    /// The largest flank radius, mm, with which the flanks part in every direction beside their
    /// contacts: by at least the induced curvature [`least_curvature`] (the published condition (4),
    /// with the radius as the unknown), and as far as the teeth of `section` reach, before and after
    /// their contact too. `None` where that is hardly more than a round bead's.
    pub fn flattest(&self, section: &Section, settings: &Settings, motion: &Motion) -> Option<f64> {
        let least = least_curvature(settings);
        let curved = |radius: f64| {
            let mut contacts = self.contacts.iter();
            contacts.all(|c| c.induced_curvature(radius) > least)
        };
        let flat = |radius: f64| {
            Outline::new(&Section {
                flank_radius: radius,
                ..*section
            })
        };
        let bead = section.bead_radius();
        let most = (section.root.min(section.tip) / FLANK).min(FLATTEST);
        let curved = largest((bead, most), curved);
        let passing = Passing::new(self.teeth, settings.gear.drive(), motion);
        // A rounder flank lies inside a flatter one: what passes with that passes with all.
        let tight = passing.tight(&flat(curved));
        let clear = |radius: f64| {
            let outline = flat(radius);
            tight.par_iter().all(|m| passing.is_clear(m, &outline))
        };
        let radius = largest((bead, curved), clear);
        (radius > WORTH * bead).then_some(radius)
    }
}

/// The largest radius between `low`, which is taken to do, and `high` that does, to [`PRECISION`].
fn largest((mut low, mut high): (f64, f64), does: impl Fn(f64) -> bool) -> f64 {
    if high > low && does(high) {
        return high;
    }
    while high - low > PRECISION * low {
        let middle = 0.5 * (low + high);
        match does(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// The teeth of a band passing each other.
struct Passing {
    /// Of the driver and of the follower.
    teeth: [Vec<Tooth>; 2],
    /// Phase by which the driver has made one turn, rad.
    period: f64,
    /// At every phase the driver seen from the follower, and the other way round.
    seen: Vec<(f64, [Pose; 2])>,
}

/// The frames of a tooth in a ball.
struct Tooth {
    frames: Vec<Frame>,
    centre: Vector3<f64>,
    radius: f64,
    /// Its tooth pair.
    pair: usize,
    /// Phases at which its contact begins and ends.
    contact: [f64; 2],
}

impl Tooth {
    fn new(frames: Vec<Frame>, (pair, contact): (usize, [f64; 2])) -> Tooth {
        let centre = frames.iter().map(|f| f.p).sum::<Vector3<f64>>() / frames.len() as f64;
        let away = frames.iter().map(|f| (f.p - centre).norm());
        Tooth {
            radius: away.fold(0.0, f64::max),
            centre,
            pair,
            contact,
            frames,
        }
    }
}

impl Passing {
    fn new(teeth: &[ToothPair], drive: Drive, motion: &Motion) -> Passing {
        let of = |gear: Gear| {
            let around = sweep::around(teeth, gear, (drive, sweep::MAX_STATIONS));
            let tooth = |(number, frames): (usize, Vec<Frame>)| {
                let pair = number % teeth.len();
                let later = TAU * (number / teeth.len()) as f64;
                let ToothPair {
                    phi_start, phi_end, ..
                } = teeth[pair];
                Tooth::new(frames, (pair, [phi_start + later, phi_end + later]))
            };
            around.map(tooth).collect()
        };
        let seen = motion.cycle().phases(PHASES).map(|phi| {
            let driver = drive.state(phi).pose;
            let follower = motion.state(phi).pose;
            let seen = [follower.inverse_mul(&driver), driver.inverse_mul(&follower)];
            (phi, seen)
        });
        Passing {
            period: drive.period(),
            teeth: [Gear::Driver, Gear::Follower].map(of),
            seen: seen.collect(),
        }
    }

    /// Meetings of two teeth with this `outline` in which they come nearer to each other than at their
    /// contacts, or too near where they have none.
    fn tight(&self, outline: &Outline) -> Vec<Meeting> {
        let near = |&(gear, mine, other, phase): &Meeting| {
            let (mine, other) = (&self.teeth[gear][mine], &self.teeth[1 - gear][other]);
            let centre = self.seen[phase].1[gear].apply(mine.centre);
            (centre - other.centre).norm() < mine.radius + other.radius + NEAR
        };
        let count = |gear: usize| self.teeth[gear].len();
        let at = |phase: usize| {
            let teeth = (0..2).flat_map(|gear| (0..count(gear)).map(move |mine| (gear, mine)));
            teeth.flat_map(move |(gear, mine)| {
                (0..count(1 - gear)).map(move |other| (gear, mine, other, phase))
            })
        };
        let meetings = (0..self.seen.len()).into_par_iter().flat_map_iter(at);
        let tight = meetings.filter(|m| near(m) && !self.is_clear(m, outline));
        tight.collect()
    }

    /// Whether two teeth with this `outline` are far enough from each other.
    fn is_clear(&self, &(gear, mine, other, phase): &Meeting, outline: &Outline) -> bool {
        let (mine, other) = (&self.teeth[gear][mine], &self.teeth[1 - gear][other]);
        let (phi, seen) = &self.seen[phase];
        let driver = if gear == 0 { mine } else { other };
        let [start, end] = driver.contact;
        let mates = mine.pair == other.pair;
        let shape = if mates { &outline.side } else { &outline.whole };
        let wanted = match mates && (phi - start).rem_euclid(self.period) < end - start {
            true => outline.clearance - SLACK,
            false => PASSING * outline.clearance,
        };
        clear(mine, other, &seen[gear], (shape, wanted))
    }
}

/// One tooth of a gear (0 the driver, 1 the follower), one of the other gear, and a phase.
type Meeting = (usize, usize, usize, usize);

/// A section as its mates see it.
struct Outline {
    /// All around, closed.
    whole: Vec<[f64; 2]>,
    /// The side of the contact, from the root to the tip: the one that mates face each other with.
    side: Vec<[f64; 2]>,
    clearance: f64,
}

impl Outline {
    fn new(section: &Section) -> Outline {
        let mut whole = section::polygon(section, sweep::SECTION_SEGMENTS);
        whole.reverse();
        let middle = 0.5 * (section.clearance + section.thickness);
        let side = whole.iter().copied().filter(|c| c[0] < middle).collect();
        whole.extend(whole.first().copied());
        Outline {
            whole,
            side,
            clearance: section.clearance,
        }
    }
}

/// Whether one tooth, which `pose` brings beside `other`, is `wanted` (mm) in front of it: `shape` against
/// `shape`, with the material on the right.
fn clear(mine: &Tooth, other: &Tooth, pose: &Pose, (shape, wanted): (&[[f64; 2]], f64)) -> bool {
    mine.frames.iter().all(|frame| {
        let p = pose.apply(frame.p);
        let away = other.frames.iter().map(|f| (f.p - p).norm_squared());
        let Some((nearest, away)) = away.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return true;
        };
        if away > NEAR * NEAR {
            return true;
        }
        let last = (nearest + PLANES + 1).min(other.frames.len());
        let beside = &other.frames[nearest.saturating_sub(PLANES)..last];
        shape
            .iter()
            .all(|&c| in_front_of(beside, shape, pose.apply(frame.place(c))) > wanted)
    })
}

/// Distance of `point` in front of a tooth's `shape`, mm, in the planes across the tooth that hold the
/// point; infinite beside the tooth.
fn in_front_of(frames: &[Frame], shape: &[[f64; 2]], point: Vector3<f64>) -> f64 {
    let ahead = |f: &Frame| (point - f.p).dot(&f.t);
    let holds = |pair: &&[Frame]| ahead(&pair[0]) >= 0.0 && ahead(&pair[1]) <= 0.0;
    let planes = frames.windows(2).filter(holds).map(|pair| {
        let (before, after) = (ahead(&pair[0]), ahead(&pair[1]));
        let share = before / (before - after).max(f64::MIN_POSITIVE);
        let away = point - pair[0].p.lerp(&pair[1].p, share);
        let along = |of: fn(&Frame) -> Vector3<f64>| {
            away.dot(&of(&pair[0]).lerp(&of(&pair[1]), share).normalize())
        };
        in_front(shape, [along(|f| f.n), along(|f| f.b)])
    });
    planes.fold(f64::INFINITY, f64::min)
}

/// Distance of a point of the section's plane in front of `shape`, mm; negative behind it.
fn in_front(shape: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let edges = shape.windows(2).map(|edge| {
        let [along, away] = [edge[1], point].map(|c| [c[0] - edge[0][0], c[1] - edge[0][1]]);
        let length = along[0] * along[0] + along[1] * along[1];
        let share = ((along[0] * away[0] + along[1] * away[1]) / length).clamp(0.0, 1.0);
        let [n, b] = [away[0] - share * along[0], away[1] - share * along[1]];
        // The material lies at larger n: to the right of an edge that leads up.
        n.hypot(b).copysign(along[0] * away[1] - along[1] * away[0])
    });
    edges
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(f64::INFINITY)
}
