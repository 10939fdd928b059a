//! How far ribs thicken towards their hub: as far as all that passes between them leaves room.
//!
//! A wall that is as thick everywhere gives most where it is clamped. What moves between the walls of a gear
//! are the teeth of the other, which reach less and less far down; the room below them is there for the taking.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::Result;
use crate::design::{Design, Gear, Section};
use crate::envelope::Envelope;
use crate::motion::{Motion, Pose};
use crate::solid::rib::{self, Wall};
use crate::solid::sweep::{self, Frame, Standing};
use crate::solid::{layout, section};

/// Phases of the period at which the other gear's teeth are looked at.
const PHASES: usize = 120;

/// What is added to the gap to all that moves past, mm at L = 25: for what happens between phases and points.
const BETWEEN: f64 = 0.15;

/// Share of the room that a wall may take where it is less than the gap already.
const TAKEN: f64 = 0.3;

/// Corners of a full circle of the section, of which every second frame is taken.
const CORNERS: u32 = 10;
const EVERY: usize = 2;

/// Steps from the bead to the foot at which walls are looked at.
const ROWS: usize = 8;

/// Lets the ribs of `design` thicken towards their hubs, by at most what its settings allow: the driver's
/// first, then the follower's between them.
pub fn grow(design: &mut Design, motion: &Motion) {
    let most = design.settings.spokes.flare_mm;
    if most <= 0.0 {
        return;
    }
    for gear in [Gear::Driver, Gear::Follower] {
        let room = Room::new(design, motion, gear).flares(most);
        let numbers = design.sub_gear_pairs.iter().map(|pair| pair.teeth.len());
        let numbers: Vec<usize> = numbers.collect();
        let mut least: Vec<Vec<[f64; 2]>> = numbers.iter().map(|&n| vec![[most; 2]; n]).collect();
        for (pair, number, flare) in room {
            let own = &mut least[pair][number % numbers[pair]];
            *own = [0, 1].map(|side| own[side].min(flare[side]));
        }
        for (pair, least) in design.sub_gear_pairs.iter_mut().zip(least) {
            for (tooth, flare) in pair.teeth.iter_mut().zip(least) {
                tooth.flare[gear as usize] = flare.map(rounded);
            }
        }
        for tooth in sweep::standing(design, gear, sweep::MAX_STATIONS) {
            let unfolded = unfolded(design, gear, &tooth);
            let pair = &mut design.sub_gear_pairs[tooth.pair];
            let count = pair.teeth.len();
            pair.teeth[tooth.number % count].flare[gear as usize] = unfolded;
        }
    }
}

/// Walls are to stay whole when they are made so much thicker than their teeth, mm: scripts let users thicken both.
const THICKER: f64 = 0.3;

/// The flare of a tooth, halved until its rib does not fold where it twists.
fn unfolded(design: &Design, gear: Gear, tooth: &Standing) -> [f64; 2] {
    let mut wall = wall(design, gear, tooth);
    wall.section.rib = wall.section.thickness + THICKER;
    while wall.flare != [0.0; 2] && wall.mesh(&tooth.frames, "rib").is_err() {
        wall.flare = wall.flare.map(|flare| rounded(0.5 * flare));
    }
    wall.flare
}

/// The rib of a tooth.
fn wall(design: &Design, gear: Gear, tooth: &Standing) -> Wall {
    Wall {
        section: design.section_of(&design.sub_gear_pairs[tooth.pair]),
        axis: sweep::axis_point(gear, design.settings.gear.center_distance_mm),
        foot: layout::rib_foot(design, gear),
        flare: tooth.flare,
    }
}

/// Whether any rib thickens.
pub fn is_flared(design: &Design) -> bool {
    let teeth = design.sub_gear_pairs.iter().flat_map(|pair| &pair.teeth);
    teeth
        .flat_map(|tooth| tooth.flare.iter().flatten())
        .any(|&f| f > 0.0)
}

/// `design` with a `share` of the flare that its ribs have, and the recipe that belongs to them.
///
/// # Errors
/// As [`layout::recipe`].
pub fn flared(mut design: Design, motion: &Motion, share: f64) -> Result<Design> {
    if share < 1.0 && is_flared(&design) {
        let teeth = design
            .sub_gear_pairs
            .iter_mut()
            .flat_map(|pair| &mut pair.teeth);
        for flare in teeth.flat_map(|tooth| tooth.flare.iter_mut().flatten()) {
            *flare = rounded(share * *flare);
        }
        design.recipe = layout::recipe(&design, motion)?;
    }
    Ok(design)
}

/// Downwards to a hundredth of a millimetre.
fn rounded(flare: f64) -> f64 {
    (flare * 100.0).floor() / 100.0
}

/// Ribs of one gear and what they must leave alone.
struct Room<'a> {
    design: &'a Design,
    motion: &'a Motion,
    gear: Gear,
    walls: Vec<Place>,
    gap: f64,
    /// L as a share of 25 mm.
    scale: f64,
}

impl<'a> Room<'a> {
    fn new(design: &'a Design, motion: &'a Motion, gear: Gear) -> Room<'a> {
        let settings = &design.settings;
        let teeth = sweep::standing(design, gear, sweep::MAX_STATIONS);
        Room {
            walls: teeth.iter().map(|t| Place::new(design, gear, t)).collect(),
            gap: settings.fit.safety_gap_mm,
            scale: settings.gear.center_distance_mm / 25.0,
            design,
            motion,
            gear,
        }
    }

    /// Sub-gear pair, number and flares of every tooth.
    fn flares(&self, most: f64) -> Vec<(usize, usize, [f64; 2])> {
        let passing = self.passing(most);
        let socket = self.beside_the_socket(most);
        let walls = self.walls.iter().enumerate();
        let all = walls.map(|(i, wall)| {
            let least = |side: usize| passing[i][side].min(socket[i][side]).max(0.0);
            (wall.pair, wall.number, [least(0), least(1)])
        });
        all.collect()
    }

    /// What the other gear's teeth leave when they pass.
    fn passing(&self, most: f64) -> Vec<[f64; 2]> {
        let other = match self.gear {
            Gear::Driver => Gear::Follower,
            Gear::Follower => Gear::Driver,
        };
        let teeth = sweep::standing(self.design, other, sweep::MAX_STATIONS);
        let teeth = teeth.iter().map(|t| Place::new(self.design, other, t));
        let points: Vec<Vector3<f64>> = teeth.flat_map(|tooth| tooth.points).collect();
        let gap = self.gap + BETWEEN * self.scale;
        let leave = |free: f64| (free - gap).max(TAKEN * free);
        self.narrowest(most, |poses, flares| {
            let seen = match self.gear {
                Gear::Driver => poses[0].inverse_mul(&poses[1]),
                Gear::Follower => poses[1].inverse_mul(&poses[0]),
            };
            for &point in &points {
                let point = seen.apply(point);
                for (wall, flare) in self.walls.iter().zip(&mut *flares) {
                    wall.meets(point, flare, leave);
                }
            }
        })
    }

    /// What the socket leaves.
    fn beside_the_socket(&self, most: f64) -> Vec<[f64; 2]> {
        let Some(joint) = Envelope::new(self.motion, &self.design.settings).ball_joint else {
            return vec![[most; 2]; self.walls.len()];
        };
        let near = self.gap + most;
        self.narrowest(most, |poses, flares| {
            let pose = &poses[self.gear as usize];
            for (wall, flare) in self.walls.iter().zip(&mut *flares) {
                for (point, side, share) in wall.sides() {
                    let point = pose.apply(point);
                    if joint.is_near(point, near) {
                        let room = (joint.distance(point) - self.gap).max(0.0);
                        flare[side] = flare[side].min(room / share);
                    }
                }
            }
        })
    }

    /// The least of what `look` leaves at any phase, told the poses of driver and follower.
    fn narrowest(
        &self,
        most: f64,
        look: impl Fn([Pose; 2], &mut [[f64; 2]]) + Sync,
    ) -> Vec<[f64; 2]> {
        let drive = self.design.settings.gear.drive();
        let phases: Vec<f64> = self.motion.cycle().phases(PHASES).collect();
        let free = || vec![[most; 2]; self.walls.len()];
        let at = |mut flares: Vec<[f64; 2]>, &phi: &f64| {
            let poses = [drive.state(phi).pose, self.motion.state(phi).pose];
            look(poses, &mut flares);
            flares
        };
        let less = |mut a: Vec<[f64; 2]>, b: Vec<[f64; 2]>| {
            for (a, b) in a.iter_mut().zip(b) {
                *a = [0, 1].map(|side| a[side].min(b[side]));
            }
            a
        };
        phases.par_iter().fold(free, at).reduce(free, less)
    }
}

/// A tooth with its rib.
struct Place {
    pair: usize,
    number: usize,
    /// The rib's middle at every frame.
    lines: Vec<Line>,
    /// Half its thickness at the bead.
    half: f64,
    /// Points on the surfaces of bead and rib.
    points: Vec<Vector3<f64>>,
    /// The ball around the rib.
    centre: Vector3<f64>,
    radius: f64,
}

/// The middle of a rib at one frame.
struct Line {
    outer: Vector3<f64>,
    /// From the bead to the foot.
    inwards: Vector3<f64>,
    length: f64,
    across: Vector3<f64>,
    /// Along the tooth.
    along: Vector3<f64>,
}

impl Place {
    fn new(design: &Design, gear: Gear, tooth: &Standing) -> Place {
        let wall = wall(design, gear, tooth);
        let section = wall.section;
        let ribbed = rib::span(&tooth.frames);
        let foot = wall.reaches_to(ribbed);
        let lines: Vec<Line> = ribbed.iter().map(|f| Line::new(f, &wall, foot)).collect();
        let mut points = bead(&tooth.frames, &section);
        for line in &lines {
            for row in 1..=ROWS {
                let share = row as f64 / ROWS as f64;
                let [left, right] = wall.halves(share);
                let middle = line.at(share);
                points.extend([middle + left * line.across, middle - right * line.across]);
            }
        }
        let ends = || lines.iter().flat_map(|l| [l.outer, l.at(1.0)]);
        let centre = ends().sum::<Vector3<f64>>() / (2 * lines.len()) as f64;
        let away = ends().map(|p| (p - centre).norm());
        Place {
            pair: tooth.pair,
            number: tooth.number,
            half: 0.5 * section.rib,
            radius: away.fold(0.0, f64::max) + REACH,
            centre,
            points,
            lines,
        }
    }

    /// Points of the rib's sides, which side it is, and the share of the way to the foot.
    fn sides(&self) -> impl Iterator<Item = (Vector3<f64>, usize, f64)> {
        self.lines.iter().flat_map(move |line| {
            (1..=ROWS).flat_map(move |row| {
                let share = row as f64 / ROWS as f64;
                [1.0, -1.0]
                    .into_iter()
                    .enumerate()
                    .map(move |(side, sign)| {
                        let point = line.at(share) + sign * self.half * line.across;
                        (point, side, share)
                    })
            })
        })
    }

    /// Lowers `flare` to what `leave` leaves of the distance, mm, between the rib's side and a `point` beside
    /// it.
    fn meets(&self, point: Vector3<f64>, flare: &mut [f64; 2], leave: impl Fn(f64) -> f64) {
        if (point - self.centre).norm_squared() > self.radius * self.radius {
            return;
        }
        let last = self.lines.len() - 1;
        let ahead = |i: usize| (point - self.lines[i].outer).dot(&self.lines[i].along);
        let mut before = ahead(0);
        if (-BEYOND..0.0).contains(&before) {
            self.lines[0].meets(point, (self.half, &leave), flare);
        }
        for i in 1..=last {
            let here = ahead(i);
            if before >= 0.0 && here <= 0.0 {
                let nearest = if before < -here { i - 1 } else { i };
                self.lines[nearest].meets(point, (self.half, &leave), flare);
            }
            before = here;
        }
        if (0.0..BEYOND).contains(&before) {
            self.lines[last].meets(point, (self.half, &leave), flare);
        }
    }
}

/// Points farther than this beside a rib leave it all the room that it may take, mm.
const REACH: f64 = 4.0;

/// So far beyond its ends points count as if they were beside it, mm.
const BEYOND: f64 = 0.5;

/// Above this share of the way from the bead nothing changes.
const BEAD: f64 = 0.03;

impl Line {
    fn new(frame: &Frame, wall: &Wall, foot: f64) -> Line {
        let [outer, inner, across] = rib::line(frame, &wall.section, wall.axis, foot);
        let inwards = (inner - outer).normalize();
        Line {
            outer,
            length: (inner - outer).norm(),
            along: across.cross(&inwards),
            inwards,
            across,
        }
    }

    fn at(&self, share: f64) -> Vector3<f64> {
        self.outer + share * self.length * self.inwards
    }

    fn meets(
        &self,
        point: Vector3<f64>,
        (half, leave): (f64, &impl Fn(f64) -> f64),
        flare: &mut [f64; 2],
    ) {
        let away = point - self.outer;
        let share = away.dot(&self.inwards) / self.length;
        if !(BEAD..=1.0 + BEAD).contains(&share) {
            return;
        }
        let beside = away.dot(&self.across);
        let own = &mut flare[usize::from(beside < 0.0)];
        *own = own.min(leave((beside.abs() - half).max(0.0)) / share);
    }
}

/// Points on the surface of a tooth's bead.
fn bead(frames: &[Frame], section: &Section) -> Vec<Vector3<f64>> {
    let outline = section::polygon(section, CORNERS);
    let last = frames.len() - 1;
    let chosen = frames
        .iter()
        .enumerate()
        .filter(|(i, _)| i % EVERY == 0 || *i == last);
    chosen
        .flat_map(|(_, frame)| outline.iter().map(|&c| frame.place(c)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::MotionFile;
    use crate::solid::Solids;
    use crate::{search, synthesis};

    /// A small design with ribs as its settings ask for.
    fn designed(flare_mm: f64) -> (Design, Motion) {
        let text = format!(
            "class = \"1R\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi\"\n[spokes]\nflare_mm = {flare_mm}\n[search]\neffort = 0.1\n"
        );
        let (file, motion) = MotionFile::parse(
            &text,
            std::path::Path::new("my.toml"),
            std::path::Path::new("."),
        )
        .expect("a motion");
        let found = search::draft(&motion, &file.settings, &mut |_| {
            std::ops::ControlFlow::Continue(())
        })
        .expect("bands");
        let (bands, _) = found.choices.into_iter().next().expect("a choice");
        let bands = synthesis::Bands::Exact(bands);
        let design = synthesis::design(&file, &motion, &bands, synthesis::Flanks::Flat);
        (design.expect("a design"), motion)
    }

    #[test]
    fn ribs_thicken_and_still_clear_the_other_gear() {
        let (straight, motion) = designed(0.0);
        assert!(!is_flared(&straight));
        let (design, _) = designed(1.5);
        assert!(is_flared(&design));
        let [thin, thick] =
            [&straight, &design].map(|d| Solids::build(d, &motion).expect("solids"));
        let drive = design.settings.gear.drive();
        for (i, body) in thick.bodies.iter().enumerate().take(2) {
            assert!(body.mesh.volume() > 1.02 * thin.bodies[i].mesh.volume());
        }
        // Every rib's surface keeps the gap to the other gear's ribs and beads, at phases in between.
        let room = Room::new(&design, &motion, Gear::Driver);
        let other = Room::new(&design, &motion, Gear::Follower);
        for step in 0..97 {
            let phi = std::f64::consts::TAU * f64::from(step) / 97.0;
            let [driver, follower] = [drive.state(phi).pose, motion.state(phi).pose];
            let seen = driver.inverse_mul(&follower);
            for point in other.walls.iter().flat_map(|w| &w.points) {
                let point = seen.apply(*point);
                for wall in &room.walls {
                    let mut left = [f64::INFINITY; 2];
                    wall.meets(point, &mut left, |free| free);
                    let flare = design.sub_gear_pairs[wall.pair].teeth[wall.number].flare[0];
                    for side in 0..2 {
                        assert!(left[side] > flare[side], "{left:?} {flare:?}");
                    }
                }
            }
        }
        let half = flared(design.clone(), &motion, 0.5).expect("a recipe");
        let sum = |d: &Design| -> f64 {
            let teeth = d.sub_gear_pairs.iter().flat_map(|p| &p.teeth);
            teeth.flat_map(|t| t.flare.iter().flatten()).sum()
        };
        assert!((sum(&half) / sum(&design) - 0.5).abs() < 0.02);
    }

    #[test]
    fn a_point_beside_a_rib_takes_its_share_of_room() {
        let (design, motion) = designed(0.0);
        let room = Room::new(&design, &motion, Gear::Driver);
        let wall = &room.walls[0];
        let line = &wall.lines[wall.lines.len() / 2];
        let mut left = [9.0; 2];
        wall.meets(line.at(0.5) + 2.0 * line.across, &mut left, |free| free);
        assert!((left[0] - (2.0 - wall.half) / 0.5).abs() < 0.1, "{left:?}");
        assert_eq!(left[1], 9.0);
    }
}
