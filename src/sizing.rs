//! The smallest gear that carries a payload: center distances are tried, each by its whole search, and the
//! smallest that seems to do is proved on its meshes.

use std::ops::ControlFlow;

use serde::Serialize;

use crate::load::{self, PayloadLimit, Sampling};
use crate::motion::{Motion, MotionFile};
use crate::pipeline::{self, Choices, Event};
use crate::ranking;
use crate::search::{Observer, StopReason};
use crate::synthesis::{self, Flanks};
use crate::{Error, Result};

/// What is asked of the gear beside what its motion file says.
#[derive(Debug, Clone, Copy)]
pub struct Demand {
    /// Payload at the load point, g.
    pub payload_g: f64,
    /// Largest elastic displacement of the load point under that payload, mm.
    pub deflection_mm: Option<f64>,
}

/// A size that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tried {
    /// L, mm.
    pub center_distance_mm: f64,
    /// Hold of the bands: min Q, in classes that slide min Q*; `None` where none were found.
    pub hold: Option<f64>,
    /// What they carry, g; `None` where there are none or weight does not load the contacts.
    pub payload_g: Option<f64>,
    /// What limits that.
    pub payload_limit: Option<PayloadLimit>,
    /// Largest elastic displacement of the load point under the payload asked for, mm; `None` where it is not known.
    pub deflection_mm: Option<f64>,
    /// Whether that is enough.
    pub is_enough: bool,
    /// What the proof on the meshes said; `None` where it was not asked.
    pub problems: Option<Vec<String>>,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sizing {
    /// Every size that was tried, in that order.
    pub tried: Vec<Tried>,
    /// L of the smallest gear that was proved, mm; `None` where none was.
    pub center_distance_mm: Option<f64>,
    /// Whether it was stopped before the end.
    pub stopped: bool,
}

/// Sizes are multiples of this, mm.
const STEP_MM: f64 = 0.5;
/// From one size to the next while it is not known between which two the answer lies.
const FACTOR: f64 = 1.15;
/// Largest and smallest size that is tried, in lengths of the motion file's L.
const RANGE: [f64; 2] = [0.5, 3.0];
/// The answer is known to this share of itself.
const PRECISION: f64 = 0.03;
/// Sizes that are proved at most: where a proof fails the next is larger by [`PRECISION`].
const PROOFS: usize = 4;

/// Looks for the smallest center distance at which the gear of `file` carries what is asked, everything else as
/// in `file`. Which sizes do is taken to grow with the size; luck of the search makes that untrue by a few
/// percent.
///
/// # Errors
/// Defects of ours. Sizes without a gear are an answer, and so is what was tried when `tell` breaks.
pub fn smallest(
    file: &MotionFile,
    motion: &Motion,
    demand: Demand,
    tell: &mut Observer,
) -> Result<Sizing> {
    let mut sizes = Sizes {
        file,
        motion,
        demand,
        tried: Vec::new(),
        kept: None,
    };
    let found = sizes.smallest(tell);
    let stopped = matches!(found, Err(Error::Interrupted));
    let center_distance_mm = if stopped { None } else { found? };
    Ok(Sizing {
        tried: sizes.tried,
        center_distance_mm,
        stopped,
    })
}

/// What is asked, and what is known about sizes so far.
struct Sizes<'a> {
    file: &'a MotionFile,
    motion: &'a Motion,
    demand: Demand,
    tried: Vec<Tried>,
    /// What was found at the size that was last seen to be enough, for its proof.
    kept: Option<(f64, Choices)>,
}

impl Sizes<'_> {
    /// L of the smallest gear that was proved, mm.
    ///
    /// # Errors
    /// As [`smallest`]; [`Error::Interrupted`] when `tell` breaks.
    fn smallest(&mut self, tell: &mut Observer) -> Result<Option<f64>> {
        let given = self.file.settings.gear.center_distance_mm;
        let [least, most] = RANGE.map(|share| share * given);
        // Bracket, then halve.
        let (mut small, mut large) = (None, None);
        let mut size = rounded(given);
        while small.is_none() || large.is_none() {
            if self.is_enough(size, tell)? {
                large = Some(size);
                size = rounded(size / FACTOR);
            } else {
                small = Some(size);
                size = rounded(size * FACTOR);
            }
            if !(least..=most).contains(&size) {
                break;
            }
        }
        if let (Some(mut low), Some(mut high)) = (small, large) {
            while high - low > (PRECISION * high).max(STEP_MM) {
                let middle = rounded(0.5 * (low + high));
                match self.is_enough(middle, tell)? {
                    true => high = middle,
                    false => low = middle,
                }
            }
            large = Some(high);
        }
        // Proof, at the next larger size where it fails.
        let mut size = large;
        for _ in 0..PROOFS {
            let Some(now) = size.filter(|&size| size <= most) else {
                break;
            };
            if self.is_enough(now, tell)? {
                let problems = self.proof(now, tell)?;
                let works = problems.is_empty();
                let mut entries = self.tried.iter_mut();
                if let Some(entry) = entries.find(|t| t.center_distance_mm == now) {
                    entry.problems = Some(problems);
                }
                if works {
                    return Ok(Some(now));
                }
            }
            size = Some(rounded(now * (1.0 + PRECISION) + STEP_MM));
        }
        Ok(None)
    }

    /// Whether a gear of `size` carries what is asked, as far as its bands tell.
    fn is_enough(&mut self, size: f64, tell: &mut Observer) -> Result<bool> {
        let before = self.tried.iter().find(|t| t.center_distance_mm == size);
        if let Some(before) = before {
            return Ok(before.is_enough);
        }
        let (now, choices) = self.at(size, tell)?;
        let is_enough = now.is_enough;
        self.tried.push(now);
        if is_enough {
            self.kept = choices.map(|choices| (size, choices));
        }
        Ok(is_enough)
    }

    /// The motion file at another size, with the payload as its load and demand.
    fn sized(&self, size: f64) -> MotionFile {
        let mut file = self.file.clone();
        file.settings.gear.center_distance_mm = size;
        file.settings.load.mass_g = self.demand.payload_g;
        file.settings.load.payload_at_least_g = self.demand.payload_g;
        file
    }

    /// What the bands of one size hold and carry, with the bands.
    fn at(&self, size: f64, tell: &mut Observer) -> Result<(Tried, Option<Choices>)> {
        let mut file = self.sized(size);
        let mut tried = Tried {
            center_distance_mm: size,
            hold: None,
            payload_g: None,
            payload_limit: None,
            deflection_mm: None,
            is_enough: false,
            problems: None,
        };
        if !file.settings.problems(file.class).is_empty() {
            return Ok((tried, None));
        }
        let found = match pipeline::choices(&file, self.motion, tell) {
            Ok(found) if found.stop == StopReason::Stopped => return Err(Error::Interrupted),
            Ok(found) => found,
            Err(Error::Infeasible { .. }) => return Ok((tried, None)),
            Err(error) => return Err(error),
        };
        file.settings.gear.contact_ratio = found.contact_ratio;
        let choices = ranking::by_payload(&file, self.motion, found.bands.clone());
        let Some(first) = choices.into_iter().next().filter(|c| c.hold > 0.0) else {
            return Ok((tried, None));
        };
        tried.hold = Some(first.hold);
        let design = match first.flat {
            Some(design) => Ok(design),
            None => synthesis::design(&file, self.motion, &first.bands, Flanks::Flat),
        };
        let load = &file.settings.load;
        let report =
            design.and_then(|d| load::analyse(&d, self.motion, load, Sampling::of(self.motion)));
        let report = match report {
            Ok(report) => report,
            Err(Error::Infeasible { .. }) => return Ok((tried, None)),
            Err(error) => return Err(error),
        };
        let payload_g = 1e3 * report.payload_max;
        tried.payload_g = Some(payload_g).filter(|g| g.is_finite());
        tried.payload_limit = report.payload_limit;
        tried.deflection_mm = report.deflection_max_mm;
        let most = self.demand.deflection_mm;
        let stiff = most.is_none_or(|most| tried.deflection_mm.is_some_and(|d| d <= most));
        tried.is_enough = payload_g >= self.demand.payload_g && stiff;
        Ok((tried, Some(found)))
    }

    /// What the proof on the meshes of that size says against it.
    fn proof(&mut self, size: f64, tell: &mut Observer) -> Result<Vec<String>> {
        let file = self.sized(size);
        let observer = &mut |event: Event| match event {
            Event::Progress(progress) => tell(progress),
            Event::Best(_) => ControlFlow::Continue(()),
        };
        let outcome = match self.kept.take_if(|(of, _)| *of == size) {
            Some((_, found)) => pipeline::finish((&file, self.motion), found, observer),
            None => pipeline::run(&file, self.motion, observer),
        };
        match outcome {
            Ok(outcome) if outcome.stop == StopReason::Stopped => Err(Error::Interrupted),
            Ok(outcome) => Ok(outcome.design.problems),
            Err(error @ Error::Infeasible { .. }) => Ok(vec![error.to_string()]),
            Err(error) => Err(error),
        }
    }
}

/// The nearest multiple of [`STEP_MM`].
fn rounded(size: f64) -> f64 {
    (size / STEP_MM).round() * STEP_MM
}
