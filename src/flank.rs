//! How flat the flanks of a band may be: the radius across its teeth that condition (4) leaves free.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::contact::Contact;
use crate::design::{Gear, Section, ToothPair};
use crate::motion::{Motion, MotionState, Pose};
use crate::settings::{FLATTEST, Settings};
use crate::solid::section::{self, FLANK};
use crate::solid::sweep::{self, Frame};

/// A radius that is less of a gain over the bead's is not worth an edge.
const WORTH: f64 = 1.05;

/// Radii closer than this to each other, as a share, are the same.
const PRECISION: f64 = 0.01;

/// How much nearer than at the contact flanks may come beside it, mm: what the chords of a section
/// leave.
const SLACK: f64 = 0.005;

/// Stations farther from the contact than so many centre distances do not come near it.
const NEAR: f64 = 0.2;

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
    /// with the radius as the unknown), and as far as the teeth of `section` reach. `None` where that is
    /// no more than a round bead's.
    pub fn flattest(&self, section: &Section, settings: &Settings, motion: &Motion) -> Option<f64> {
        let least = least_curvature(settings);
        let distance = settings.gear.center_distance_mm;
        let pairs: Vec<Flanks> = self
            .teeth
            .iter()
            .map(|tooth| Flanks::new(tooth, distance, motion))
            .collect();
        let parts = |radius: f64| {
            let flat = Section {
                flank_radius: radius,
                ..*section
            };
            let curved = |c: &Contact| c.induced_curvature(radius) > least;
            self.contacts.iter().all(curved) && pairs.par_iter().all(|flanks| flanks.part(&flat))
        };
        let bead = section.bead_radius();
        let most = (section.root.min(section.tip) / FLANK).min(FLATTEST);
        let (mut low, mut high) = (bead, most);
        if most > bead && parts(most) {
            return Some(most);
        }
        while high - low > PRECISION * low {
            let middle = 0.5 * (low + high);
            match parts(middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        (low > WORTH * bead).then_some(low)
    }
}

/// The two teeth of a pair, driver and follower, through their contact.
struct Flanks {
    frames: [Vec<Frame>; 2],
    /// For every frame's phase the driver's tooth seen from the follower, and the other way round.
    seen: Vec<[Pose; 2]>,
    near: f64,
}

impl Flanks {
    fn new(tooth: &ToothPair, distance: f64, motion: &Motion) -> Flanks {
        let gears = [Gear::Driver, Gear::Follower];
        let frames =
            gears.map(|gear| sweep::frames(tooth, gear, sweep::axis_point(gear, distance)));
        let seen = |frame: &Frame| {
            let driver = MotionState::driver(distance, frame.phi).pose;
            let follower = motion.state(frame.phi).pose;
            [follower.inverse_mul(&driver), driver.inverse_mul(&follower)]
        };
        Flanks {
            seen: frames[0].iter().map(seen).collect(),
            frames,
            near: NEAR * distance,
        }
    }

    /// Whether the teeth with this `section` come nowhere nearer to each other than at their contacts.
    fn part(&self, section: &Section) -> bool {
        let outline = section::polygon(section, sweep::SECTION_SEGMENTS);
        // The side of the contact, from the root to the tip.
        let middle = 0.5 * (section.clearance + section.thickness);
        let side: Vec<[f64; 2]> = outline
            .into_iter()
            .rev()
            .filter(|c| c[0] < middle)
            .collect();
        self.seen.iter().enumerate().all(|(i, seen)| {
            (0..2).all(|gear| {
                let (mine, other) = (&self.frames[gear], &self.frames[1 - gear]);
                let contact = mine[i].p;
                let near = mine.iter().filter(|f| (f.p - contact).norm() < self.near);
                let mut corners = near.flat_map(|f| side.iter().map(|&c| f.place(c)));
                corners
                    .all(|c| nearest(other, &side, seen[gear].apply(c)) > section.clearance - SLACK)
            })
        })
    }
}

/// Distance of `point` in front of a tooth's flank `side`, mm, in the planes across the tooth that hold
/// the point; infinite beside the tooth.
fn nearest(frames: &[Frame], side: &[[f64; 2]], point: Vector3<f64>) -> f64 {
    let ahead = |f: &Frame| (point - f.p).dot(&f.t);
    let holds = |pair: &&[Frame]| ahead(&pair[0]) >= 0.0 && ahead(&pair[1]) <= 0.0;
    let planes = frames.windows(2).filter(holds).map(|pair| {
        let (before, after) = (ahead(&pair[0]), ahead(&pair[1]));
        let share = before / (before - after).max(f64::MIN_POSITIVE);
        let away = point - pair[0].p.lerp(&pair[1].p, share);
        let along = |of: fn(&Frame) -> Vector3<f64>| {
            away.dot(&of(&pair[0]).lerp(&of(&pair[1]), share).normalize())
        };
        in_front(side, [along(|f| f.n), along(|f| f.b)])
    });
    planes.fold(f64::INFINITY, f64::min)
}

/// Distance of a point of the section's plane in front of `side`, mm; negative behind it.
fn in_front(side: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let edges = side.windows(2).map(|edge| {
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
