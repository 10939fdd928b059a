//! One tooth pair as the polish sees it: where its beads run, how it holds, how far it is from the
//! limits it has to keep by itself, and how all that follows its band's design variables.

use nalgebra::Vector3;

use super::candidates::Workshop;
use crate::closure::Wrench;
use crate::contact::trace;
use crate::design::Gear;
use crate::sub_gear::{Band, BandLaw, Margins, OWN, SKETCH, in_body, natural_sizes, slacks};

/// Design variables that a tooth depends on: its band's sketch and its own numbers.
pub(super) const VARIABLES: usize = SKETCH + OWN;

/// What a band has to keep, besides the workshop's margins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Room that it may take, mm, counted from [`Workshop::base`].
    pub height: f64,
    /// Radius of its flanks, mm.
    pub flank_radius: f64,
}

/// A tooth pair, or the change of one.
#[derive(Debug, Clone)]
pub(super) struct Tooth {
    /// n̄ at the workshop's phases.
    pub wrenches: Vec<Wrench>,
    /// Slack of each limit that it keeps by itself, of about the size of mm.
    pub slacks: Vec<f64>,
    /// Axes of the beads on driver and follower by layer and station, in the frame of the gear, mm.
    pub beads: [Vec<Vec<Vector3<f64>>>; 2],
}

impl Tooth {
    /// Tooth `j` of a band; `None` where it degenerates.
    pub fn new(workshop: &Workshop, j: usize, law: &BandLaw, bounds: Bounds) -> Option<Tooth> {
        let grid = &workshop.grid;
        let tooth = trace(grid, j, &law.at(grid, j))?;
        let base = workshop.base(law);
        let tall = tooth.iter().map(|c| bounds.height - (c.p.z - base).abs());
        let beads = [Gear::Driver, Gear::Follower].map(|gear| {
            let layer = |depth: &f64| {
                let stations = tooth.iter().enumerate();
                let axis = stations.map(|(i, c)| {
                    let (p, n, _) = in_body(grid, j, i, c, gear);
                    p + *depth * n
                });
                axis.collect()
            };
            workshop.scene.bead_depths().iter().map(layer).collect()
        });
        let margins = Margins {
            flank_radius: bounds.flank_radius,
            ..workshop.margins
        };
        let mut all: Vec<f64> = slacks(grid, j, &tooth, &margins)
            .map(|(_, slack)| slack)
            .collect();
        all.extend(tall);
        let made = Tooth {
            wrenches: workshop.wrenches_of(j, &tooth).collect(),
            slacks: all,
            beads,
        };
        let finite = made.slacks.iter().all(|x| x.is_finite())
            && made.wrenches.iter().flatten().all(|x| x.is_finite());
        finite.then_some(made)
    }

    /// Change of the tooth by each design variable, per natural size of it.
    pub fn slopes(
        &self,
        workshop: &Workshop,
        j: usize,
        law: &BandLaw,
        bounds: Bounds,
    ) -> Option<Vec<Tooth>> {
        let (sketch, own) = natural_sizes(workshop.scale());
        (0..VARIABLES)
            .map(|v| {
                let mut moved = law.clone();
                if v < SKETCH {
                    *moved.sketch.free()[v] += DIFFERENCE * sketch[v];
                } else {
                    moved.shifts[j][v - SKETCH] += DIFFERENCE * own[v - SKETCH];
                }
                let moved = Tooth::new(workshop, j, &moved, bounds)?;
                Some(moved.less(self))
            })
            .collect()
    }

    /// Difference quotient of this tooth and the one it was moved from.
    fn less(mut self, from: &Tooth) -> Tooth {
        let scale = 1.0 / DIFFERENCE;
        for (a, b) in self.slacks.iter_mut().zip(&from.slacks) {
            *a = (*a - b) * scale;
        }
        let wrenches = self.wrenches.iter_mut().flatten();
        for (a, b) in wrenches.zip(from.wrenches.iter().flatten()) {
            *a = (*a - b) * scale;
        }
        let points = self.beads.iter_mut().flatten().flatten();
        for (a, b) in points.zip(from.beads.iter().flatten().flatten()) {
            *a = (*a - b) * scale;
        }
        self
    }
}

/// Step of the difference quotients in natural sizes: everything is smooth and of about the size of
/// mm, so that both errors stay below 1e-5.
const DIFFERENCE: f64 = 1e-5;

/// All teeth of a band.
pub(super) fn teeth(workshop: &Workshop, law: &BandLaw, bounds: Bounds) -> Option<Vec<Tooth>> {
    (0..workshop.grid.teeth.len())
        .map(|j| Tooth::new(workshop, j, law, bounds))
        .collect()
}

/// Moves a band's law by `step`, its design variables in natural sizes: those of the sketch, then those
/// of each tooth.
pub(super) fn moved(workshop: &Workshop, law: &BandLaw, step: &[f64]) -> BandLaw {
    let (sketch, own) = natural_sizes(workshop.scale());
    let mut law = law.clone();
    for (v, x) in law.sketch.free().into_iter().enumerate() {
        *x += step[v] * sketch[v];
    }
    let shifts = law.shifts.iter_mut().flatten();
    for ((x, s), size) in shifts.zip(&step[SKETCH..]).zip(own.iter().cycle()) {
        *x += s * size;
    }
    law
}

impl Bounds {
    /// Those of a band: its own height (see [`Workshop::base`]) and flanks a step of [`FLAT`] flatter than its
    /// contacts allow.
    pub fn of(workshop: &Workshop, law: &BandLaw) -> Bounds {
        let base = workshop.base(law);
        let margins = &workshop.margins;
        let mut bounds = Bounds {
            height: 0.0,
            flank_radius: margins.flank_radius,
        };
        let Ok(band) = Band::trace(&workshop.grid, law.clone(), margins) else {
            return bounds;
        };
        let contacts = || band.teeth.iter().flatten();
        let heights = contacts().map(|c| (c.p.z - base).abs());
        bounds.height = heights.fold(0.0, f64::max) + 1e-6;
        let parts =
            |radius: f64| contacts().all(|c| c.induced_curvature(radius) > margins.curvature);
        if workshop.flattens() {
            let flat = FLAT.map(|flat| flat * workshop.scale());
            let own = flat.iter().take_while(|&&radius| parts(radius)).count();
            bounds.flank_radius = flat[own.min(flat.len() - 1)].max(margins.flank_radius);
        }
        bounds
    }
}

/// Radii of flat flanks, mm at L = 25: a polish that only saw the hold would give up what carries the load.
const FLAT: [f64; 2] = [3.0, 4.0];
