//! Random candidate bands: sample the design variables, keep what is fabricable by itself.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::clearance::Scene;
use super::near::Place;
use super::swept::Swept;
use super::tooth::Tooth;
use crate::closure::{Wrench, wrench};
use crate::contact::{Grid, Trace};
use crate::design::Gear;
use crate::flank;
use crate::motion::{Class, Motion};
use crate::settings::{FlankRadius, PairCount, Settings};
use crate::sub_gear::{Band, BandLaw, Flaw, Margins, Sketch, natural_sizes};

/// Everything a candidate is judged by; built once per search.
#[derive(Debug, Clone)]
pub struct Workshop {
    /// Class of the motion.
    pub class: Class,
    /// Contact intervals.
    pub grid: Grid,
    /// Collision model.
    pub scene: Scene,
    /// Limits of a fabricable band.
    pub margins: Margins,
    /// Stations of every tooth at which wrenches are taken.
    samples: Vec<usize>,
    /// Joint centre at those phases, of each tooth.
    centres: Vec<Vec<Vector3<f64>>>,
    /// Length scale L/25 of all sampled sizes.
    scale: f64,
    /// Length that moments are divided by, mm: 1 where all wrenches are moments, L/2 where units mix.
    length: f64,
    /// K that is asked for, or the least that closes the class.
    pairs: usize,
    flattens: bool,
}

/// A band that is fabricable by itself, ready to be combined.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Design variables.
    pub law: BandLaw,
    /// n̄ at the workshop's phases, in the workshop's units.
    pub wrenches: Vec<Wrench>,
    /// Collision model.
    pub swept: Swept,
}

impl Workshop {
    /// Prepares the search for `motion`.
    pub fn new(motion: &Motion, settings: &Settings) -> Workshop {
        let grid = Grid::new(motion, &settings.gear, STEPS);
        let scale = settings.gear.center_distance_mm / 25.0;
        let thickness = settings.gear.tooth_thickness_mm;
        let bead_radius = 0.5 * thickness;
        let scene = Scene::new(motion, settings, PHASES, 2);
        let foot = |gear| (scene.axis(gear), scene.hub_radius(gear));
        let margins = Margins {
            gap: 0.5 * scale,
            curvature: flank::least_curvature(settings),
            tangent: 1.5 * scale,
            spacing: thickness + settings.fit.safety_gap_mm + 0.2 * scale,
            bead_radius,
            flank_radius: match settings.gear.flank_radius_mm {
                FlankRadius::Fixed(radius) => radius.max(bead_radius),
                FlankRadius::Auto(_) => bead_radius,
            },
            rib: scene.radii().rib,
            feet: [Gear::Driver, Gear::Follower].map(foot),
        };
        // Stations of tooth j inside its own subinterval (the rest of the interval is overlap).
        let share = 0.5 / settings.gear.contact_ratio;
        let inside = |i: &usize| (*i as f64 / grid.steps as f64 - 0.5).abs() <= share + 1e-9;
        let samples: Vec<usize> = (0..=grid.steps).filter(inside).collect();
        let centres = grid.teeth.iter().map(|nodes| {
            let centre = |&i: &usize| motion.joint_centre(nodes[2 * i].phi);
            samples.iter().map(centre).collect()
        });
        let centres = centres.collect();
        Workshop {
            class: motion.class(),
            scene,
            grid,
            margins,
            samples,
            centres,
            scale,
            length: match motion.class().slides() {
                true => 0.5 * settings.gear.center_distance_mm,
                false => 1.0,
            },
            flattens: matches!(settings.gear.flank_radius_mm, FlankRadius::Auto(_)),
            pairs: match settings.gear.sub_gear_pairs {
                PairCount::Fixed(k) => k,
                PairCount::Auto(_) => motion.class().dof() + 1,
            },
        }
    }

    /// Traces a band and runs the tests that need no collision model.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn trace(&self, law: BandLaw) -> Result<Band, Flaw> {
        self.check_spacing(Band::trace(&self.grid, law, &self.margins)?)
    }

    /// Runs the collision tests on a traced band.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn finish(&self, band: &Band) -> Result<Candidate, Flaw> {
        let swept = self.scene.prepare(band, &self.grid)?;
        Ok(Candidate {
            law: band.law.clone(),
            wrenches: self.wrenches(band),
            swept,
        })
    }

    /// n̄ of a band at the workshop's phases. Where units mix, moments are divided by L/2: a choice is
    /// then as good as its Q*, since raw Q says little about the hold (1 and mm are no equals).
    pub fn wrenches(&self, band: &Band) -> Vec<Wrench> {
        let teeth = band.teeth.iter().enumerate();
        teeth
            .flat_map(|(j, tooth)| self.wrenches_of(j, tooth))
            .collect()
    }

    /// n̄ of tooth `j` at its phases.
    pub fn wrenches_of(&self, j: usize, tooth: &Trace) -> impl Iterator<Item = Wrench> {
        let samples = self.samples.iter().zip(&self.centres[j]);
        samples.map(|(&i, &centre)| {
            let c = &tooth[i];
            wrench(self.class, c.p, c.n, centre, self.length)
        })
    }

    /// Whether neighbouring teeth keep their distance; the band if they do.
    ///
    /// # Errors
    /// [`Flaw::Spacing`].
    pub(super) fn check_spacing(&self, band: Band) -> Result<Band, Flaw> {
        let tight = [Gear::Driver, Gear::Follower]
            .into_iter()
            .any(|gear| self.is_tight(&band, gear));
        if tight { Err(Flaw::Spacing) } else { Ok(band) }
    }

    /// Whether neighbouring teeth of `gear` come closer than the margin.
    fn is_tight(&self, band: &Band, gear: Gear) -> bool {
        let count = band.teeth.len();
        let axes: Vec<_> = (0..count)
            .map(|j| band.bead_axis(&self.grid, j, gear, self.margins.bead_radius, 3))
            .collect();
        let last = count - usize::from(!self.grid.cycle.wraps());
        (0..last).any(|j| {
            // Behind the last tooth the next copy of the first one stands.
            let copy = match gear {
                Gear::Driver if j + 1 == count => self.grid.drive.copy(1),
                _ => self.grid.drive.copy(0),
            };
            let next: Vec<_> = axes[(j + 1) % count]
                .iter()
                .map(|&p| copy.apply(p))
                .collect();
            let near = axes[j]
                .iter()
                .flat_map(|a| next.iter().map(move |b| (a - b).norm_squared()))
                .fold(f64::INFINITY, f64::min);
            near.sqrt() < self.margins.spacing
        })
    }

    /// What a hold of Q* = 1 is in the unit of the search: L/2 where Q is in mm, 1 where the search goes
    /// by Q* itself.
    pub fn hold_unit(&self) -> f64 {
        25.0 * self.scale / 2.0 / self.length
    }

    /// Length scale of the gear, L/25.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Draws the law of a band. Sizes are for L = 25 and scale with L; where the joint is a pin, bands
    /// sit anywhere around O, where it is a ball they sit above or below it.
    pub fn draw(&self, rng: &mut impl Rng) -> BandLaw {
        let s = self.scale;
        let sign = |rng: &mut dyn Rng| if rng.random::<bool>() { 1.0 } else { -1.0 };
        let (drive, turning) = (self.grid.drive, self.grid.turning);
        let around = drive.follower_share(turning) * turning * self.grid.cycle.share();
        let pitch = around * std::f64::consts::PI * 25.0 / self.grid.teeth.len() as f64;
        let travel = rng.random_range(0.6..1.5) * pitch * s * sign(rng);
        let z = if self.class.is_spherical() {
            // Room for as many bands above each other as one side of the ball has to take.
            let above = self.pairs.div_ceil(2);
            (rng.random_range(5.0..8.0 + 9.0 * above as f64) * s + 0.5 * travel.abs()) * sign(rng)
        } else {
            let room = 16.0 * (self.pairs as f64 / 3.0).max(1.0);
            rng.random_range(-room..room) * s
        };
        let sketch = Sketch {
            alpha: rng.random_range(10f64.to_radians()..55f64.to_radians()),
            alpha_change: rng.random_range(-0.3..0.3),
            roll: rng.random_range(0.2..1.2),
            beta_change: rng.random_range(-0.3..0.3),
            side: sign(rng),
            z,
            travel,
            offset: rng.random_range(-1.5..1.5) * s,
            ride: 0.0,
            stay: 0.0,
        };
        let mut law = BandLaw::uniform(sketch, self.grid.teeth.len());
        // Half of the bands take part in what the motion does from tooth to tooth.
        if rng.random::<bool>() {
            law.sketch.ride = rng.random_range(0.0..1.0);
            law.sketch.stay = rng.random_range(0.0..0.7);
        }
        law
    }

    /// In how many of `count` bands each tooth fails by itself.
    pub(super) fn failures(&self, seed: u64, count: usize) -> Vec<usize> {
        let mut failures = vec![0; self.grid.teeth.len()];
        for i in 0..count {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(i as u64);
            let law = self.draw(&mut rng);
            let failed = Band::flaws(&self.grid, law, &self.margins);
            for (failures, failed) in failures.iter_mut().zip(failed) {
                *failures += usize::from(failed.is_some());
            }
        }
        failures
    }

    /// A band like one that is usable: on the other side, the other hand or the other end of the gears
    /// in some of the cases.
    fn vary(&self, rng: &mut impl Rng, mut law: BandLaw) -> BandLaw {
        for x in [
            &mut law.sketch.side,
            &mut law.sketch.travel,
            &mut law.sketch.z,
        ] {
            if rng.random::<f64>() < 0.1 {
                *x = -*x;
            }
        }
        let step = rng.random_range(0.3..2.0);
        mutate(rng, law, step, self.scale)
    }

    /// Whether flanks are made as flat as contacts allow.
    pub(super) fn flattens(&self) -> bool {
        self.flattens
    }

    /// Where bands come near each other, hubs, joint and themselves: slack below `window`, mm.
    pub(super) fn places(&self, bands: &[Vec<Tooth>], window: f64) -> Vec<Place> {
        self.scene.places(bands, self.margins.spacing, window)
    }

    /// Height that the room of a band is counted from: the joint's where that is a ball, the band's middle
    /// on a pin.
    pub(super) fn base(&self, law: &BandLaw) -> f64 {
        match self.class.is_spherical() {
            true => 0.0,
            false => law.sketch.z,
        }
    }

    /// Candidates that are drawn in a fraction of a second: fewer where bands have many teeth; a power
    /// of two.
    pub fn draws_between_looks(&self) -> usize {
        let draws = 32 * 10 / self.grid.teeth.len().max(10);
        1 << draws.max(1).ilog2()
    }

    /// Draws candidates number `first..first + count` of the stream of `seed`: the usable ones, in
    /// order, and how many failed of what. Where there are `parents`, candidates are variations of them.
    pub fn sample(
        &self,
        seed: u64,
        (first, count): (usize, usize),
        parents: &[BandLaw],
    ) -> (Vec<Candidate>, BTreeMap<Flaw, usize>) {
        let made: Vec<Result<Candidate, Flaw>> = (first..first + count)
            .into_par_iter()
            .map(|i| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(i as u64);
                let law = match parents {
                    [] => self.draw(&mut rng),
                    _ => {
                        let parent = &parents[rng.random_range(0..parents.len())];
                        self.vary(&mut rng, parent.clone())
                    }
                };
                let band = Band::mend(&self.grid, law, &self.margins)?;
                self.finish(&self.check_spacing(band)?)
            })
            .collect();
        let mut flaws = BTreeMap::new();
        let mut usable = Vec::new();
        for result in made {
            match result {
                Ok(candidate) => usable.push(candidate),
                Err(flaw) => *flaws.entry(flaw).or_insert(0) += 1,
            }
        }
        (usable, flaws)
    }
}

/// Changes about a third of the design variables by normal steps of natural size × `step`.
fn mutate(rng: &mut impl Rng, mut law: BandLaw, step: f64, scale: f64) -> BandLaw {
    let nudge = |rng: &mut dyn Rng, x: &mut f64, size: f64, share: f64| {
        if rng.random::<f64>() < share {
            // Sum of uniforms: close to normal, bounded.
            let draw: f64 = (0..4).map(|_| rng.random::<f64>() - 0.5).sum::<f64>() * 1.7;
            *x += draw * size * step;
        }
    };
    let (sketch, own) = natural_sizes(scale);
    for (x, size) in law.sketch.free().into_iter().zip(sketch) {
        nudge(rng, x, size, 0.35);
    }
    // Single teeth, in some of the proposals: a stretch of neighbours moves together.
    if rng.random::<f64>() < 0.6 {
        let teeth = law.shifts.len();
        let (first, length) = (
            rng.random_range(0..teeth),
            rng.random_range(1..=teeth / 2 + 1),
        );
        for (which, size) in own.into_iter().enumerate() {
            let mut shift = 0.0;
            nudge(rng, &mut shift, size, 0.4);
            for j in first..first + length {
                law.shifts[j % teeth][which] += shift;
            }
        }
    }
    law
}

/// Integration steps a tooth during the search: residuals are far below the search's other errors.
const STEPS: usize = 24;

/// Phases of the collision model: 3° of driver turn move a tooth by 0.65 mm at L = 25.
const PHASES: usize = 120;
