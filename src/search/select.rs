//! Choosing K mutually compatible bands with the largest min Q: local search from many random starts,
//! then a genetic algorithm over the local optima (crossover of two, repaired by local search).
//!
//! Compatibility of each pair of bands is tested once, before.

use std::ops::ControlFlow;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::candidates::{Candidate, Workshop};
use super::proved::{Proved, Table, prove};
use crate::closure::{Wrench, measure_above};

/// Candidates with their compatibility.
pub struct Pool<'a> {
    workshop: &'a Workshop,
    candidates: &'a [Candidate],
    compatible: Vec<Vec<bool>>,
    phases: Vec<usize>,
}

/// K compatible bands (indices into the pool, ascending) and their min Q.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Indices of the bands.
    pub bands: Vec<usize>,
    /// Smallest Q over the sampled phases.
    pub q: f64,
}

/// Smallest Q over `phases`, or any value ≤ `floor` once it cannot exceed `floor`.
pub fn min_q(wrenches: &[&[Wrench]], phases: &[usize], dof: usize, floor: f64) -> f64 {
    let mut q = f64::INFINITY;
    let mut set = Vec::with_capacity(wrenches.len());
    for &phase in phases {
        set.clear();
        set.extend(wrenches.iter().map(|w| w[phase]));
        q = q.min(measure_above(&set, dof, floor));
        if q <= floor {
            return q;
        }
    }
    q
}

/// Told the share done, 0 to 1, and the best min Q so far; `Break` ends the work early.
pub type Tell<'a> = dyn FnMut(f64, Option<f64>) -> ControlFlow<()> + 'a;

impl<'a> Pool<'a> {
    /// Pool of `candidates`; of the first of them when `tell` breaks, but never of so few that there is no choice.
    pub fn new(workshop: &'a Workshop, candidates: &'a [Candidate], tell: &mut Tell) -> Pool<'a> {
        let scene = &workshop.scene;
        let mut lower: Vec<Vec<bool>> = Vec::with_capacity(candidates.len());
        let enough = ENOUGH * 10 / workshop.grid.teeth.len().max(10);
        for first in (0..candidates.len()).step_by(ROWS) {
            let done = (first as f64 / candidates.len() as f64).powi(2);
            if tell(done, None).is_break() && first >= enough {
                break;
            }
            let rows = first..(first + ROWS).min(candidates.len());
            lower.par_extend(rows.into_par_iter().map(|i| {
                (0..i)
                    .map(|j| scene.compatible(&candidates[i].swept, &candidates[j].swept))
                    .collect::<Vec<bool>>()
            }));
        }
        let n = lower.len();
        let candidates = &candidates[..n];
        let compatible = (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| i != j && lower[i.max(j)][i.min(j)])
                    .collect()
            })
            .collect();
        let count = candidates.first().map_or(0, |c| c.wrenches.len());
        Pool {
            workshop,
            candidates,
            compatible,
            phases: spread(count),
        }
    }

    fn q(&self, bands: &[usize], floor: f64) -> f64 {
        let wrenches: Vec<&[Wrench]> = bands
            .iter()
            .map(|&i| self.candidates[i].wrenches.as_slice())
            .collect();
        min_q(&wrenches, &self.phases, self.workshop.class.dof(), floor)
    }

    /// K random compatible bands, beginning with `seeds` as far as they are compatible. Each further
    /// band is the one of a few random ones that leaves most choice to those after it.
    fn random(&self, rng: &mut impl Rng, k: usize, seeds: &[usize]) -> Option<Vec<usize>> {
        for _ in 0..TRIES {
            let mut bands: Vec<usize> = Vec::with_capacity(k);
            let mut free: Vec<usize> = (0..self.candidates.len()).collect();
            for &s in seeds {
                if bands.len() < k && free.binary_search(&s).is_ok() {
                    bands.push(s);
                    free.retain(|&i| self.compatible[s][i]);
                }
            }
            while bands.len() < k && !free.is_empty() {
                let left = |i: usize| free.iter().filter(|&&f| self.compatible[i][f]).count();
                let best = (0..DRAWS)
                    .map(|_| free[rng.random_range(0..free.len())])
                    .max_by_key(|&i| left(i));
                if let Some(best) = best {
                    bands.push(best);
                    free.retain(|&i| self.compatible[best][i]);
                }
            }
            if bands.len() == k {
                return Some(bands);
            }
        }
        None
    }

    /// Swaps single bands for better ones until none is.
    fn climb(&self, rng: &mut impl Rng, mut bands: Vec<usize>) -> Choice {
        let mut q = self.q(&bands, f64::NEG_INFINITY);
        let n = self.candidates.len();
        let mut idle = 0;
        let mut slot = rng.random_range(0..bands.len());
        while idle < bands.len() {
            slot = (slot + 1) % bands.len();
            let mut best = None;
            let mut trial = bands.clone();
            for i in 0..n {
                trial[slot] = i;
                let better = self.q(&trial, q);
                if better > q
                    && bands
                        .iter()
                        .enumerate()
                        .all(|(s, &b)| s == slot || self.compatible[b][i])
                {
                    q = better;
                    best = Some(i);
                }
            }
            match best {
                Some(i) => {
                    bands[slot] = i;
                    idle = 0;
                }
                None => idle += 1,
            }
        }
        bands.sort_unstable();
        Choice { bands, q }
    }

    /// Whether no choice of as many bands holds better than `best`, or the one that does.
    pub(super) fn prove(&self, best: Choice) -> Proved {
        let table = Table {
            wrenches: self.candidates.iter().map(|c| &c.wrenches[..]).collect(),
            compatible: &self.compatible,
            phases: &self.phases,
            dof: self.workshop.class.dof(),
        };
        prove(&table, best)
    }

    /// Best choices of `k` bands, best first, no two alike; `starts` local searches and as many
    /// crossovers, or fewer when `tell` breaks. Empty when no `k` compatible bands were found.
    pub fn best(&self, seed: u64, k: usize, starts: usize, tell: &mut Tell) -> Vec<Choice> {
        if self.candidates.len() < k {
            return Vec::new();
        }
        let run = |task: usize, parents: Option<(&Choice, &Choice)>| -> Option<Choice> {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream((1 << 40) + ((k as u64) << 32) + task as u64);
            let seeds = parents.map_or(Vec::new(), |(a, b)| {
                let cut = rng.random_range(1..k);
                a.bands[..cut]
                    .iter()
                    .chain(&b.bands[cut..])
                    .copied()
                    .collect()
            });
            let start = self.random(&mut rng, k, &seeds)?;
            Some(self.climb(&mut rng, start))
        };
        let mut choices: Vec<Choice> = Vec::new();
        for first in (0..starts).step_by(BATCH) {
            let tasks = first..(first + BATCH).min(starts);
            choices.par_extend(tasks.into_par_iter().filter_map(|i| run(i, None)));
            rank(&mut choices);
            let done = 0.5 * first as f64 / starts as f64;
            if tell(done, choices.first().map(|c| c.q)).is_break() {
                return choices;
            }
        }
        for generation in 0..GENERATIONS {
            let elite: Vec<Choice> = choices.iter().take(12).cloned().collect();
            let done = 0.5 + 0.5 * generation as f64 / GENERATIONS as f64;
            if elite.len() < 2 || k < 2 || tell(done, Some(elite[0].q)).is_break() {
                break;
            }
            choices.par_extend((0..starts / GENERATIONS).into_par_iter().filter_map(|i| {
                let a = &elite[i % elite.len()];
                let b = &elite[(i / elite.len() + i + 1) % elite.len()];
                run(starts + generation * starts + i, Some((a, b)))
            }));
            rank(&mut choices);
        }
        choices
    }
}

/// Rows of the table of compatible pairs, and local searches, between two looks at the observer.
const ROWS: usize = 64;
const BATCH: usize = 8;

/// So many candidates of ten teeth make a pool to choose from, even in a hurry; fewer of more teeth.
const ENOUGH: usize = 256;

/// Generations of crossovers.
const GENERATIONS: usize = 4;

/// Tries to find K compatible bands for one start, and random bands looked at for each place.
const TRIES: usize = 20;
const DRAWS: usize = 6;

fn rank(choices: &mut Vec<Choice>) {
    choices.sort_by(|a, b| b.q.total_cmp(&a.q).then_with(|| a.bands.cmp(&b.bands)));
    choices.dedup();
}

/// All of 0..count, far ones first, so that a bad set is found out early.
fn spread(count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|i| (i * 7919) % count.max(1));
    order
}
