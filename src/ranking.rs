//! Which of the choices that hold about as well is made first: the one that carries most.

use crate::design::Design;
use crate::load::{self, Sampling};
use crate::motion::{Motion, MotionFile};
use crate::synthesis::{self, Bands, Flanks};

/// A choice of bands.
pub(crate) struct Choice {
    /// The bands.
    pub bands: Bands,
    /// Their hold.
    pub hold: f64,
    /// Their design with flat flanks, where it was made to be compared.
    pub flat: Option<Design>,
}

/// Share of the best hold that is enough for a choice that carries more: hold is play, which grows by the
/// same share, while payloads of choices that hold alike differ by factors.
const ALIKE: f64 = 0.93;

/// Driver angles at which the payload is taken; it changes by a few percent from one to the next.
const ANGLES: usize = 90;

/// Puts those of the `choices` (best hold first) that hold about as well as the first in the order of what
/// they carry, before the others. Where weight does not load the contacts they stay as they are.
pub(crate) fn by_payload(
    file: &MotionFile,
    motion: &Motion,
    choices: Vec<(Bands, f64)>,
) -> Vec<Choice> {
    let best = choices.first().map_or(0.0, |c| c.1);
    let alike = choices.iter().filter(|c| c.1 > 0.0 && c.1 >= ALIKE * best);
    let alike = alike.count();
    let mut ranked: Vec<(f64, Choice)> = choices
        .into_iter()
        .enumerate()
        .map(|(i, (bands, hold))| {
            let made = (alike > 1 && i < alike)
                .then(|| synthesis::design(file, motion, &bands, Flanks::Flat).ok());
            let flat = made.flatten();
            let payload = flat.as_ref().map_or(0.0, |design| payload(design, motion));
            (payload, Choice { bands, hold, flat })
        })
        .collect();
    ranked[..alike].sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().map(|(_, choice)| choice).collect()
}

/// Largest payload under the load of the design's settings, kg; 0 where it carries none.
fn payload(design: &Design, motion: &Motion) -> f64 {
    let sampling = Sampling {
        count: ANGLES,
        ..Sampling::default()
    };
    let report = load::analyse(design, motion, &design.settings.load, sampling);
    report.map_or(0.0, |report| report.payload_max)
}
