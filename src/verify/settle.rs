//! Where a push leaves the follower when only flanks hold it: along the push until a flank stops it, then
//! on along that flank, and along the next, until nothing gives way any more. Ribs and hubs are left out,
//! and the driver stands still.

use microlp::{ComparisonOp, OptimizationDirection, Problem};
use nalgebra::{DVector, Rotation3, Vector3};
use rayon::prelude::*;

use super::Mechanism;
use super::collide::{Near, Placed};
use super::escape::parts;
use super::tree::Tree;
use crate::Result;
use crate::closure::wrench;
use crate::design::{Design, Gear};
use crate::motion::Pose;
use crate::solid::assembly::Carrier;
use crate::solid::sweep::{self, Standing};

/// Distance that a step leaves between two flanks, mm.
const REST: f64 = 1e-4;

/// Longest and shortest step, mm at the centre distance from the joint; a shorter one is no step.
const STEPS: [f64; 2] = [0.2, 2e-3];

/// Share of a gap that the search for the smallest one leaves undecided: flat flanks are nearly as far apart
/// all over.
const SLACK: f64 = 0.05;

/// Stations of a bead, at most: its chords leave the tooth by less than 0.01 mm.
const STATIONS: usize = 17;

/// Steps after which a push that still moves counts as not stopped.
const MOST: usize = 400;

/// Where a push ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rest {
    /// Driver angle, rad.
    pub phi: f64,
    /// Direction of the push, unit in span(U).
    pub push: DVector<f64>,
    /// Turn from the design's pose, rad.
    pub turn: f64,
    /// Displacement of the point asked for, mm.
    pub point: f64,
    /// How it ended.
    pub end: End,
}

/// How a push ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// Flanks stopped it.
    Held,
    /// It went beyond the limits.
    Loose,
    /// Flanks met before it began.
    Met,
}

/// The beads of all teeth of both gears, without ribs, each in its gear's frame.
pub(super) struct Beads {
    driver: Vec<Tree>,
    follower: Vec<Tree>,
    /// Largest distance of a point of the follower's from the joint's centre, mm.
    lever: f64,
}

impl Beads {
    /// # Errors
    /// [`crate::Error::Infeasible`] when a tooth folds.
    pub fn new(design: &Design) -> Result<Beads> {
        let of = |gear: Gear| -> Result<Vec<Tree>> {
            let teeth = sweep::standing(design, gear, STATIONS);
            let bead = |tooth: &Standing| {
                let section = design.section_of(&design.sub_gear_pairs[tooth.pair]);
                let mesh = sweep::tooth(&tooth.frames, &section, "tooth")?;
                Ok(Tree::new(&mesh))
            };
            teeth.par_iter().map(bead).collect()
        };
        let (driver, follower) = (of(Gear::Driver)?, of(Gear::Follower)?);
        // The joint's centre is the origin of the follower's frame.
        let boxes = follower.iter().filter_map(|tree| tree.nodes.first());
        let farthest = boxes.map(|b| b.centre.norm() + b.half.norm());
        Ok(Beads {
            lever: farthest.fold(0.0, f64::max),
            driver,
            follower,
        })
    }
}

/// What a push may reach before it counts as not stopped.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// rad.
    pub turn: f64,
    /// mm, of the point and of the joint's slide.
    pub shift: f64,
}

/// Flanks, bodies and joint with which pushes are tried.
pub(super) struct Pushes<'a> {
    pub beads: &'a Beads,
    pub mechanism: Mechanism<'a>,
    /// Point whose displacement is told, follower frame, mm.
    pub point: Vector3<f64>,
    pub limits: Limits,
}

/// Displacement of the follower from its pose: a turn about the joint centre, then a slide along z.
#[derive(Clone, Copy)]
struct Moved {
    turn: Rotation3<f64>,
    slide: f64,
}

/// Two beads that may come near.
#[derive(Clone, Copy)]
struct Couple {
    beads: (usize, usize),
    /// Where they were nearest when it was last looked at; `None` before.
    near: Option<Near>,
    /// They are not nearer than this where the follower is, mm.
    least: f64,
}

impl Pushes<'_> {
    /// Pushes at `phi` along every direction.
    pub fn at(&self, phi: f64, directions: &[DVector<f64>]) -> Vec<Rest> {
        let place = self.place(phi);
        let push = |u: &DVector<f64>| place.push(u);
        directions.par_iter().map(push).collect()
    }

    fn place(&self, phi: f64) -> Place<'_> {
        let mut place = Place {
            pushes: self,
            phi,
            driver: self.mechanism.pose(Carrier::Driver, phi),
            follower: self.mechanism.pose(Carrier::Follower, phi),
            centre: self.mechanism.motion.joint_centre(phi),
            start: None,
        };
        let mut couples = Vec::new();
        let reach = self.limits.shift + self.limits.turn * self.beads.lever;
        let pose = place.relative(&Moved::none());
        for (i, first) in self.beads.driver.iter().enumerate() {
            for (j, second) in self.beads.follower.iter().enumerate() {
                let least = Placed::new(first, second, pose).least();
                if least <= reach {
                    let beads = (i, j);
                    let near = None;
                    couples.push(Couple { beads, near, least });
                }
            }
        }
        let start = (0.0, STEPS[0]);
        place.start = place.follow(&couples, &Moved::none(), start);
        place
    }
}

impl Moved {
    fn none() -> Moved {
        Moved {
            turn: Rotation3::identity(),
            slide: 0.0,
        }
    }
}

/// Pushes at one driver angle.
struct Place<'a> {
    pushes: &'a Pushes<'a>,
    phi: f64,
    driver: Pose,
    follower: Pose,
    centre: Vector3<f64>,
    /// Beads that may come near, in the design's pose; `None` where some meet there.
    start: Option<Vec<Couple>>,
}

impl Place<'_> {
    fn pose(&self, moved: &Moved) -> Pose {
        let arm = self.follower.translation - self.centre;
        Pose {
            rotation: moved.turn.matrix() * self.follower.rotation,
            translation: self.centre + moved.turn * arm + Vector3::z() * moved.slide,
        }
    }

    fn relative(&self, moved: &Moved) -> Pose {
        self.driver.inverse_mul(&self.pose(moved))
    }

    fn push(&self, u: &DVector<f64>) -> Rest {
        let lever = self.pushes.mechanism.drive.center_distance();
        let class = self.pushes.mechanism.motion.class();
        let mut moved = Moved::none();
        let Some(mut couples) = self.start.clone() else {
            return self.rest(u, &moved, End::Met);
        };
        // What a unit of each coordinate of span(U) moves at the lever, mm.
        let scales = crate::load::lengths(class, 2.0 * lever);
        let mut step = STEPS[0];
        for _ in 0..MOST {
            let rows = self.rows(&couples, &moved, step);
            let Some(way) = best_way(&rows, (u, &scales), step) else {
                break;
            };
            let (linear, angular) = parts(class, &way);
            let next = Moved {
                turn: Rotation3::new(angular) * moved.turn,
                slide: moved.slide + linear.z,
            };
            // What the follower moves at most, anywhere.
            let size = linear.norm() + angular.norm() * self.pushes.beads.lever;
            if linear.norm() + angular.norm() * lever < 0.1 * STEPS[1] {
                return self.rest(u, &moved, End::Held);
            }
            match self.follow(&couples, &next, (size, step)) {
                Some(now) => {
                    couples = now;
                    moved = next;
                    step = (1.5 * step).min(STEPS[0]);
                }
                None if step > STEPS[1] => step *= 0.5,
                None => return self.rest(u, &moved, End::Held),
            }
            if !self.is_within(&moved) {
                break;
            }
        }
        self.rest(u, &moved, End::Loose)
    }

    fn rest(&self, u: &DVector<f64>, moved: &Moved, end: End) -> Rest {
        Rest {
            phi: self.phi,
            push: u.clone(),
            turn: moved.turn.angle(),
            point: self.shift(moved),
            end,
        }
    }

    fn shift(&self, moved: &Moved) -> f64 {
        let point = self.pushes.point;
        (self.pose(moved).apply(point) - self.follower.apply(point)).norm()
    }

    fn is_within(&self, moved: &Moved) -> bool {
        let limits = self.pushes.limits;
        moved.turn.angle() <= limits.turn
            && self.shift(moved) <= limits.shift
            && moved.slide.abs() <= limits.shift
    }

    /// Gaps that the longest step after one of `step` could close, mm.
    fn matters(&self, step: f64) -> f64 {
        let levers = self.pushes.beads.lever / self.pushes.mechanism.drive.center_distance();
        2.0 * (1.5 * step).min(STEPS[0]) * (1.0 + levers)
    }

    /// The couples after a step to `next` that moves no point by more than `size`; `None` when two meet.
    fn follow(
        &self,
        couples: &[Couple],
        next: &Moved,
        (size, step): (f64, f64),
    ) -> Option<Vec<Couple>> {
        let pose = self.relative(next);
        let beads = self.pushes.beads;
        let matters = self.matters(step);
        let follow = |couple: &Couple| {
            let least = couple.least - size;
            if least > matters {
                return Some(Couple { least, ..*couple });
            }
            let (i, j) = couple.beads;
            let placed = Placed::new(&beads.driver[i], &beads.follower[j], pose);
            let hint = couple.near.map(|near| near.pair);
            let Some(near) = placed.nearest(2.0 * matters, SLACK, hint) else {
                return Some(Couple {
                    least: 2.0 * matters,
                    ..*couple
                });
            };
            let least = (1.0 - SLACK) * near.closest.distance;
            (least > 0.5 * REST).then_some(Couple {
                near: Some(near),
                least,
                ..*couple
            })
        };
        couples.iter().map(follow).collect()
    }

    /// How the near gaps change with a displacement in span(U), and how much each leaves.
    fn rows(&self, couples: &[Couple], moved: &Moved, step: f64) -> Vec<([f64; 4], f64)> {
        let class = self.pushes.mechanism.motion.class();
        let centre = self.centre + Vector3::z() * moved.slide;
        let matters = self.matters(step);
        let near = couples.iter().filter(|c| c.least < matters);
        let near = near.filter_map(|couple| couple.near);
        near.map(|near| {
            let closest = near.closest;
            let q = self.driver.apply(closest.q);
            let n = self.driver.rotation * (closest.q - closest.p) / closest.distance;
            (wrench(class, q, n, centre, 1.0), closest.distance - REST)
        })
        .collect()
    }
}

/// The displacement in span(U), no coordinate larger than `step`, that goes farthest along `u` and leaves
/// every gap at least at rest; `None` when no solution is found.
fn best_way(
    rows: &[([f64; 4], f64)],
    (u, scales): (&DVector<f64>, &DVector<f64>),
    step: f64,
) -> Option<DVector<f64>> {
    let mut program = Problem::new(OptimizationDirection::Maximize);
    let coordinates: Vec<_> = u
        .iter()
        .zip(scales.iter())
        .map(|(u, scale)| program.add_var(u / scale, (-step, step)))
        .collect();
    for (row, gap) in rows {
        let terms = coordinates.iter().enumerate();
        let terms: Vec<_> = terms.map(|(i, &v)| (v, row[i] / scales[i])).collect();
        // A gap that is below rest already must only not close further.
        program.add_constraint(terms, ComparisonOp::Ge, -gap.max(0.0));
    }
    let solution = program.solve().ok()?.into_solution().ok()?;
    let way = coordinates.iter().map(|&v| solution.var_value(v));
    let way = DVector::from_iterator(u.len(), way);
    Some(way.component_div(scales))
}
