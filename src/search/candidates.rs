//! Random candidate bands: sample the design variables, keep what is fabricable by itself.

use std::collections::BTreeMap;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::clearance::{Scene, Swept};
use crate::closure::{Wrench, wrench};
use crate::contact::{Grid, ToothLaw};
use crate::design::Gear;
use crate::motion::{Class, Motion};
use crate::settings::Settings;
use crate::sub_gear::{Band, BandLaw, Flaw, Margins};

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
    /// Phases at which wrenches are taken: tooth, station.
    samples: Vec<(usize, usize)>,
    /// Joint centre at those phases.
    centres: Vec<nalgebra::Vector3<f64>>,
    /// Length scale L/25 of all sampled sizes.
    scale: f64,
}

/// A band that is fabricable by itself, ready to be combined.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Design variables.
    pub law: BandLaw,
    /// n̄ at the workshop's phases.
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
        let margins = Margins {
            gap: 0.5 * scale,
            tangent: 1.5 * scale,
            spacing: thickness + settings.fit.safety_gap_mm + 0.2 * scale,
            bead_radius: (0.5 * thickness).max(settings.gear.flank_radius_mm),
        };
        // Stations of tooth j inside its own subinterval (the rest of the interval is overlap).
        let share = 0.5 / settings.gear.contact_ratio;
        let samples: Vec<(usize, usize)> = (0..settings.gear.teeth)
            .flat_map(|j| {
                (0..=grid.steps)
                    .filter(|i| (*i as f64 / grid.steps as f64 - 0.5).abs() <= share + 1e-9)
                    .map(move |i| (j, i))
            })
            .collect();
        let centres =
            samples.iter().map(|&(j, i)| motion.joint_centre(grid.teeth[j][2 * i].phi)).collect();
        Workshop {
            class: motion.class(),
            scene: Scene::new(motion, settings, PHASES, 2),
            grid,
            margins,
            samples,
            centres,
            scale,
        }
    }

    /// Makes a band of `law` and tests it by itself.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn make(&self, law: BandLaw) -> Result<Candidate, Flaw> {
        let band = self.trace(law)?;
        self.finish(&band)
    }

    /// Traces and runs the tests that need no collision model.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn trace(&self, law: BandLaw) -> Result<Band, Flaw> {
        let band = Band::trace(&self.grid, law)?;
        band.check_teeth(&self.grid, &self.margins)?;
        for gear in [Gear::Driver, Gear::Follower] {
            self.check_spacing(&band, gear)?;
        }
        Ok(band)
    }

    /// Runs the collision tests on a traced band.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn finish(&self, band: &Band) -> Result<Candidate, Flaw> {
        let swept = self.scene.prepare(band, &self.grid)?;
        Ok(Candidate { law: band.law, wrenches: self.wrenches(band), swept })
    }

    /// n̄ of a band at the workshop's phases.
    pub fn wrenches(&self, band: &Band) -> Vec<Wrench> {
        self.samples
            .iter()
            .zip(&self.centres)
            .map(|(&(j, i), &centre)| {
                let c = &band.teeth[j][i];
                wrench(self.class, c.p, c.n, centre, 1.0)
            })
            .collect()
    }

    fn check_spacing(&self, band: &Band, gear: Gear) -> Result<(), Flaw> {
        let count = band.teeth.len();
        let axes: Vec<_> = (0..count)
            .map(|j| band.bead_axis(&self.grid, j, gear, self.margins.bead_radius, 3))
            .collect();
        for j in 0..count {
            let next = &axes[(j + 1) % count];
            let near = axes[j]
                .iter()
                .flat_map(|a| next.iter().map(move |b| (a - b).norm_squared()))
                .fold(f64::INFINITY, f64::min);
            if near.sqrt() < self.margins.spacing {
                return Err(Flaw::Spacing);
            }
        }
        Ok(())
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
        let travel = rng.random_range(4.0..14.0) * s * sign(rng);
        let z = if self.class.is_spherical() {
            rng.random_range(6.0..30.0) * s * sign(rng)
        } else {
            rng.random_range(-16.0..16.0) * s
        };
        let tooth = ToothLaw {
            alpha: rng.random_range(5f64.to_radians()..50f64.to_radians()),
            beta: rng.random_range(-(60f64.to_radians())..60f64.to_radians()),
            alpha_change: rng.random_range(-0.6..0.6),
            beta_change: rng.random_range(-0.6..0.6),
            side: sign(rng),
            z,
            travel,
            offset: rng.random_range(-2.0..2.0) * s,
        };
        BandLaw { tooth, waves: [[0.0; 4]; 4] }
    }

    /// Draws candidates number `first..first + count` of the stream of `seed`: the usable ones, in
    /// order, and how many failed of what.
    pub fn sample(&self, seed: u64, first: usize, count: usize) -> (Vec<Candidate>, BTreeMap<Flaw, usize>) {
        let made: Vec<Result<Candidate, Flaw>> = (first..first + count)
            .into_par_iter()
            .map(|i| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(i as u64);
                self.make(self.draw(&mut rng))
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

/// Integration steps a tooth during the search: residuals are far below the search's other errors.
const STEPS: usize = 24;

/// Phases of the collision model: 3° of driver turn move a tooth by 0.65 mm at L = 25.
const PHASES: usize = 120;
