//! Proves that no choice of K bands of a pool closes the follower better than the best one found, by
//! branch and bound.
//!
//! Q of a set exceeds q ≥ 0 at φ only if in every direction d some band pushes more than q: d·n̄ > q. A
//! question (φ, d) is answered by the bands that do. A set that holds better than q answers every
//! question, so the search takes the open question with the fewest answers left among the bands that
//! are compatible with those chosen, and tries each of them. A full set that answers all questions
//! and still holds no better asks a new one: the facet of its hull that is nearest, at the φ where it
//! is. No questions are needed to begin with; each that comes cuts off all sets that fail alike.

use super::select::{Choice, min_q};
use crate::closure::{Wrench, facets};

/// A set of bands, one bit each.
#[derive(Clone)]
struct Bands(Vec<u64>);

impl Bands {
    fn of(count: usize, holds: impl Fn(usize) -> bool) -> Bands {
        let mut bits = vec![0; count.div_ceil(64)];
        for i in (0..count).filter(|&i| holds(i)) {
            bits[i / 64] |= 1 << (i % 64);
        }
        Bands(bits)
    }

    fn has(&self, i: usize) -> bool {
        self.0[i / 64] >> (i % 64) & 1 == 1
    }

    fn remove(&mut self, i: usize) {
        self.0[i / 64] &= !(1 << (i % 64));
    }

    /// Only those that are in `other` as well.
    fn keep(&mut self, other: &Bands) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a &= b;
        }
    }

    fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }

    fn common(&self, other: &Bands) -> u32 {
        let pairs = self.0.iter().zip(&other.0);
        pairs.map(|(a, b)| (a & b).count_ones()).sum()
    }

    fn iter(&self) -> impl Iterator<Item = usize> {
        let words = self.0.iter().enumerate();
        words.flat_map(|(w, &bits)| {
            (0..64)
                .filter(move |b| bits >> b & 1 == 1)
                .map(move |b| 64 * w + b)
        })
    }
}

/// The bands to choose from.
pub(super) struct Table<'a> {
    /// n̄ of each at all phases.
    pub wrenches: Vec<&'a [Wrench]>,
    /// Which go together.
    pub compatible: &'a [Vec<bool>],
    /// Phases in the order in which they are looked at.
    pub phases: &'a [usize],
    /// N.
    pub dof: usize,
}

/// What the search for a better choice came to.
pub(super) struct Proved {
    /// The best choice: the one given, or a better one.
    pub best: Choice,
    /// Whether the table has none that closes, and does so better; false where the budget did not suffice.
    pub is_proved: bool,
}

/// Most bands of a choice that is tried to be proved best.
pub(super) const MOST: usize = 5;

/// Questions looked at before a proof is given up: about a second.
const BUDGET: usize = 200_000_000;

/// Looks in the `table` for a choice that holds better than `best`, of as many bands.
pub(super) fn prove(table: &Table, best: Choice) -> Proved {
    let count = table.wrenches.len();
    let mut search = Search {
        table,
        compatible: (0..count)
            .map(|i| Bands::of(count, |j| table.compatible[i][j]))
            .collect(),
        questions: Vec::new(),
        best,
        left: BUDGET,
    };
    let is_proved = search.descend(&mut Vec::new(), Bands::of(count, |_| true));
    Proved {
        best: search.best,
        is_proved,
    }
}

struct Search<'a> {
    table: &'a Table<'a>,
    compatible: Vec<Bands>,
    /// The bands that answer each question, at the q of the best when it was asked: at least those that
    /// answer now.
    questions: Vec<Bands>,
    best: Choice,
    left: usize,
}

impl Search<'_> {
    /// Tries all sets that hold `chosen` and as many of the `free` as are lacking; false when it has to be
    /// given up.
    fn descend(&mut self, chosen: &mut Vec<usize>, mut free: Bands) -> bool {
        if chosen.len() == self.best.bands.len() {
            self.weigh(chosen);
            return true;
        }
        let lacking = self.best.bands.len() - chosen.len();
        let open = |answers: &&Bands| !chosen.iter().any(|&i| answers.has(i));
        let mut asked = 1;
        let branches = if lacking == 1 {
            // The last band has to answer everything that is open.
            let mut all = free.clone();
            for answers in self.questions.iter().filter(open) {
                all.keep(answers);
                asked += 1;
                if all.is_empty() {
                    break;
                }
            }
            all
        } else {
            // The open question with the fewest answers; without one every free band has to be tried.
            let mut hardest: Option<(u32, &Bands)> = None;
            for answers in self.questions.iter().filter(open) {
                let left = free.common(answers);
                asked += 1;
                if hardest.is_none_or(|(fewest, _)| left < fewest) {
                    hardest = Some((left, answers));
                }
                if left == 0 {
                    break;
                }
            }
            let mut branches = free.clone();
            if let Some((_, answers)) = hardest {
                branches.keep(answers);
            }
            branches
        };
        if self.left < asked {
            return false;
        }
        self.left -= asked;
        for i in branches.iter() {
            free.remove(i);
            chosen.push(i);
            let mut rest = free.clone();
            rest.keep(&self.compatible[i]);
            let done = self.descend(chosen, rest);
            chosen.pop();
            if !done {
                return false;
            }
        }
        true
    }

    /// Takes a full set for the best, or asks what it cannot answer.
    fn weigh(&mut self, chosen: &[usize]) {
        let Table { phases, dof, .. } = *self.table;
        let of = |i: usize| self.table.wrenches[i];
        let wrenches: Vec<&[Wrench]> = chosen.iter().map(|&i| of(i)).collect();
        let bar = self.best.q.max(0.0);
        let q = min_q(&wrenches, phases, dof, bar);
        if q > bar {
            let mut bands = chosen.to_vec();
            bands.sort_unstable();
            self.best = Choice { bands, q };
            return;
        }
        for &phase in phases {
            let here: Vec<Wrench> = wrenches.iter().map(|w| w[phase]).collect();
            let nearest = facets(&here, dof);
            let nearest = nearest
                .iter()
                .min_by(|a, b| a.distance.total_cmp(&b.distance));
            if let Some(facet) = nearest.filter(|f| f.distance <= bar) {
                let pushes = |i: usize| -> f64 {
                    let terms = of(i)[phase].into_iter().zip(facet.normal);
                    terms.map(|(a, b)| a * b).sum()
                };
                // What rounding leaves undecided counts as an answer.
                let enough = bar - 1e-9;
                let answers = Bands::of(self.table.wrenches.len(), |i| pushes(i) >= enough);
                self.questions.push(answers);
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::next_subset;
    use proptest::prelude::*;

    proptest! {
        /// From whatever choice it starts, it ends with the best of all.
        #[test]
        fn finds_what_trying_all_finds(
            dof in 1usize..=3,
            numbers in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 12 * 2),
            together in prop::collection::vec(prop::bool::weighted(0.8), 12 * 12),
        ) {
            let count = 12;
            let within = |w: &Wrench| std::array::from_fn(|i| if i < dof { w[i] } else { 0.0 });
            let wrenches: Vec<Vec<Wrench>> = numbers
                .chunks(2)
                .map(|phases| phases.iter().map(within).collect())
                .collect();
            let compatible: Vec<Vec<bool>> = (0..count)
                .map(|i| (0..count).map(|j| i != j && together[i.max(j) * count + i.min(j)]).collect())
                .collect();
            let table = Table {
                wrenches: wrenches.iter().map(Vec::as_slice).collect(),
                compatible: &compatible,
                phases: &[1, 0],
                dof,
            };
            let mut all: Vec<Choice> = Vec::new();
            let mut bands: Vec<usize> = (0..=dof).collect();
            loop {
                let go = bands.iter().all(|&i| bands.iter().all(|&j| i == j || compatible[i][j]));
                if go {
                    let set: Vec<&[Wrench]> = bands.iter().map(|&i| table.wrenches[i]).collect();
                    let q = min_q(&set, table.phases, dof, f64::NEG_INFINITY);
                    all.push(Choice { bands: bands.clone(), q });
                }
                if !next_subset(&mut bands, count) {
                    break;
                }
            }
            prop_assume!(!all.is_empty());
            let best = all.iter().map(|c| c.q).fold(f64::NEG_INFINITY, f64::max);
            let proof = prove(&table, all[all.len() / 2].clone());
            prop_assert!(proof.is_proved);
            // Those that do not close are all alike.
            prop_assert!((proof.best.q.max(0.0) - best.max(0.0)).abs() < 1e-12);
        }
    }
}
