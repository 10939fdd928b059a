//! Joint polish of K chosen bands: an evolution strategy on all their design variables that accepts
//! only feasible improvements of min Q, so its result is never worse than its start.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::candidates::{Candidate, Workshop};
use super::select::min_q;
use crate::closure::Wrench;
use crate::sub_gear::BandLaw;

/// Chosen bands and their min Q.
#[derive(Debug, Clone)]
pub struct Team {
    /// The K bands.
    pub bands: Vec<Candidate>,
    /// Smallest Q over the workshop's phases.
    pub q: f64,
    /// Room that a band may take, mm: that of the tallest at the start.
    height: f64,
    step: f64,
    generation: u64,
}

/// Proposals a generation; fixed, so that the result does not depend on the number of threads.
const PROPOSALS: usize = 16;

impl Team {
    /// Starts from compatible bands.
    pub fn new(workshop: &Workshop, bands: Vec<Candidate>) -> Team {
        let q = team_q(
            workshop,
            bands.iter().map(|b| b.wrenches.as_slice()),
            f64::NEG_INFINITY,
        );
        Team {
            height: bands.iter().map(|b| workshop.height(b)).fold(0.0, f64::max),
            bands,
            q,
            step: 1.0,
            generation: 0,
        }
    }

    /// This team and the one of `candidates` that goes with all of its bands and adds most to Q; `None`
    /// when none fits.
    pub fn grow(&self, workshop: &Workshop, candidates: &[Candidate]) -> Option<Team> {
        let q = |i: usize| {
            let team = self.bands.iter().chain([&candidates[i]]);
            team_q(
                workshop,
                team.map(|b| b.wrenches.as_slice()),
                f64::NEG_INFINITY,
            )
        };
        let fits: Vec<Option<f64>> = (0..candidates.len())
            .into_par_iter()
            .map(|i| {
                let swept = &candidates[i].swept;
                let mut others = self.bands.iter();
                let fits = others.all(|b| workshop.scene.compatible(&b.swept, swept));
                fits.then(|| q(i))
            })
            .collect();
        let fits = fits
            .iter()
            .enumerate()
            .filter_map(|(i, q)| Some((i, (*q)?)));
        let (best, _) = fits.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        let bands = self.bands.iter().chain([&candidates[best]]);
        Some(Team::new(workshop, bands.cloned().collect()))
    }

    /// One generation: the best feasible proposal replaces its band. Returns whether Q grew.
    pub fn improve(&mut self, workshop: &Workshop, seed: u64) -> bool {
        let best = (0..PROPOSALS)
            .into_par_iter()
            .filter_map(|i| {
                self.propose(workshop, seed, i)
                    .map(|(slot, c, q)| (i, slot, c, q))
            })
            .max_by(|a, b| a.3.total_cmp(&b.3).then(b.0.cmp(&a.0)));
        self.generation += 1;
        match best {
            Some((_, slot, candidate, q)) => {
                self.bands[slot] = candidate;
                self.q = q;
                self.step = (self.step * 1.25).min(2.0);
                true
            }
            None => {
                self.step = (self.step * 0.93).max(0.01);
                false
            }
        }
    }

    fn propose(&self, workshop: &Workshop, seed: u64, i: usize) -> Option<(usize, Candidate, f64)> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream((2 << 40) + self.generation * PROPOSALS as u64 + i as u64);
        let slot = rng.random_range(0..self.bands.len());
        let law = mutate(
            &mut rng,
            self.bands[slot].law.clone(),
            self.step,
            workshop.scale(),
        );
        let band = workshop.trace(law).ok()?;
        let wrenches = workshop.wrenches(&band);
        let team = self.bands.iter().enumerate().map(|(s, b)| {
            if s == slot {
                wrenches.as_slice()
            } else {
                b.wrenches.as_slice()
            }
        });
        let q = team_q(workshop, team, self.q);
        if q <= self.q {
            return None;
        }
        let candidate = workshop.finish(&band).ok()?;
        if workshop.height(&candidate) > self.height {
            return None;
        }
        let fits = self
            .bands
            .iter()
            .enumerate()
            .all(|(s, b)| s == slot || workshop.scene.compatible(&b.swept, &candidate.swept));
        fits.then_some((slot, candidate, q))
    }
}

fn team_q<'a>(workshop: &Workshop, team: impl Iterator<Item = &'a [Wrench]>, floor: f64) -> f64 {
    let team: Vec<&[Wrench]> = team.collect();
    let phases: Vec<usize> = (0..team.first().map_or(0, |w| w.len())).collect();
    min_q(&team, &phases, workshop.class.dof(), floor)
}

/// Changes about a third of the design variables by normal steps of natural size × `step`.
pub(super) fn mutate(rng: &mut impl Rng, mut law: BandLaw, step: f64, scale: f64) -> BandLaw {
    let nudge = |rng: &mut dyn Rng, x: &mut f64, size: f64, share: f64| {
        if rng.random::<f64>() < share {
            // Sum of uniforms: close to normal, bounded.
            let draw: f64 = (0..4).map(|_| rng.random::<f64>() - 0.5).sum::<f64>() * 1.7;
            *x += draw * size * step;
        }
    };
    let t = &mut law.sketch;
    for (x, size) in [
        (&mut t.alpha, 0.1),
        (&mut t.roll, 0.1),
        (&mut t.alpha_change, 0.1),
        (&mut t.beta_change, 0.1),
        (&mut t.z, 0.8 * scale),
        (&mut t.travel, 0.8 * scale),
        (&mut t.offset, 0.3 * scale),
        (&mut t.ride, 0.15),
        (&mut t.stay, 0.15),
    ] {
        nudge(rng, x, size, 0.35);
    }
    // Single teeth, in some of the proposals: a stretch of neighbours moves together.
    if rng.random::<f64>() < 0.6 {
        let teeth = law.shifts.len();
        let (first, length) = (
            rng.random_range(0..teeth),
            rng.random_range(1..=teeth / 2 + 1),
        );
        for (which, size) in [0.08, 0.08, 0.3 * scale, 0.4 * scale]
            .into_iter()
            .enumerate()
        {
            let mut shift = 0.0;
            nudge(rng, &mut shift, size, 0.4);
            for j in first..first + length {
                law.shifts[j % teeth][which] += shift;
            }
        }
    }
    law
}
