//! What is wrong with a design that was read, in bounded space.

use crate::Problem;

/// So many problems are told; the others are counted.
const TOLD: usize = 20;

/// Problems as they are found.
#[derive(Debug, Default)]
pub(super) struct Problems {
    told: Vec<Problem>,
    more: usize,
}

impl Problems {
    /// A problem at `place`; only those that will be told are written down.
    pub(super) fn add(&mut self, problem: impl FnOnce() -> Problem) {
        if self.told.len() < TOLD {
            self.told.push(problem());
        } else {
            self.more += 1;
        }
    }

    /// Problems that were found elsewhere.
    pub(super) fn extend(&mut self, problems: Vec<Problem>) {
        for problem in problems {
            self.add(|| problem);
        }
    }

    /// `value` within `[min, max]`; `place` is only asked when it is not. NaN is not.
    pub(super) fn range(
        &mut self,
        place: impl FnOnce() -> String,
        value: f64,
        [min, max]: [f64; 2],
    ) {
        if !(min..=max).contains(&value) {
            self.add(|| Problem::new(place(), format!("is {value}, allowed {min} to {max}"), ""));
        }
    }

    /// At most `most` entries; whether it is so.
    pub(super) fn count(
        &mut self,
        place: impl FnOnce() -> String,
        count: usize,
        most: usize,
    ) -> bool {
        if count > most {
            self.add(|| Problem::new(place(), format!("has {count} entries, allowed {most}"), ""));
        }
        count <= most
    }

    /// All that were found, the last of them saying how many are not told.
    pub(super) fn all(mut self) -> Vec<Problem> {
        if self.more > 0 {
            let what = format!("{} more problems", self.more);
            self.told.push(Problem::new("and", what, ""));
        }
        self.told
    }
}
