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
/// they carry, before the others; those that carry less than the settings demand are left out as long as there
/// are others. Where weight does not load the contacts they stay as they are.
pub(crate) fn by_payload(
    file: &MotionFile,
    motion: &Motion,
    choices: Vec<(Bands, f64)>,
) -> Vec<Choice> {
    let best = choices.first().map_or(0.0, |c| c.1);
    let alike = choices.iter().filter(|c| c.1 > 0.0 && c.1 >= ALIKE * best);
    let alike = alike.count();
    let demand = 1e-3 * file.settings.load.payload_at_least_g;
    let compared = match demand > 0.0 {
        true => choices.len(),
        false if alike > 1 => alike,
        false => 0,
    };
    let mut ranked: Vec<(f64, Choice)> = choices
        .into_iter()
        .enumerate()
        .map(|(i, (bands, hold))| {
            let made =
                (i < compared).then(|| synthesis::design(file, motion, &bands, Flanks::Flat).ok());
            let flat = made.flatten();
            let payload = flat.as_ref().map_or(0.0, |design| payload(design, motion));
            (payload, Choice { bands, hold, flat })
        })
        .collect();
    ranked[..alike].sort_by(|a, b| b.0.total_cmp(&a.0));
    if demand > 0.0 {
        // What carries too little is not proved, unless nothing carries enough.
        ranked.sort_by_key(|(payload, _)| *payload < demand);
        let enough = ranked.iter().filter(|c| c.0 >= demand).count();
        ranked.truncate(enough.max(1));
    }
    // The others are made again in the rare case that they are needed.
    ranked
        .iter_mut()
        .skip(1)
        .for_each(|(_, choice)| choice.flat = None);
    ranked.into_iter().map(|(_, choice)| choice).collect()
}

/// Largest payload under the load of the design's settings, kg, as far as contacts limit it; 0 where it carries
/// none. Elements of the teeth would cost half a second per choice.
fn payload(design: &Design, motion: &Motion) -> f64 {
    let sampling = Sampling {
        count: ANGLES,
        ..Sampling::of(motion)
    };
    let report = load::analyse_rigid(design, motion, &design.settings.load, sampling);
    report.map_or(0.0, |report| report.payload_max)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::path::Path;

    use super::*;
    use crate::search;

    /// A uniform motion under a weight, with the choices of a small search, best hold first.
    fn searched(class: &str, seed: u64, gravity: &str) -> (MotionFile, Motion, Vec<(Bands, f64)>) {
        let text = format!(
            "class = \"{class}\"\n[motion]\nkind = \"formula\"\nown_turn = \"-phi\"\n\
             [search]\nseed = {seed}\neffort = 0.1\n[load]\ngravity = {gravity}\n"
        );
        let parsed = MotionFile::parse(&text, Path::new("my.toml"), Path::new("."));
        let (file, motion) = parsed.expect("a motion");
        let found = search::run(&motion, &file.settings, &mut |_| ControlFlow::Continue(()));
        let choices = found.expect("bands").choices.into_iter();
        let choices = choices.map(|(b, q)| (Bands::Exact(b), q)).collect();
        (file, motion, choices)
    }

    #[test]
    fn the_first_carries_most_of_those_that_hold_alike() {
        let (file, motion, found) = searched("3R", 2, "[1.0, 0.0, -1.0]");
        let holds: Vec<f64> = found.iter().map(|c| c.1).collect();
        let alike = holds.iter().filter(|&&q| q >= ALIKE * holds[0]).count();
        assert!(alike > 1, "{holds:?}");
        let choices = by_payload(&file, &motion, found);
        let carried = |choice: &Choice| {
            let design = synthesis::design(&file, &motion, &choice.bands, Flanks::Flat);
            payload(&design.expect("a design"), &motion)
        };
        let payloads: Vec<f64> = choices[..alike].iter().map(carried).collect();
        assert!(
            payloads[0] > 0.0 && payloads.is_sorted_by(|a, b| a >= b),
            "{payloads:?}"
        );
        assert!(choices[..alike].iter().all(|c| c.hold >= ALIKE * holds[0]));
        assert!(
            choices[0].hold < holds[0],
            "a seed where the best hold carries less"
        );
        let rest: Vec<f64> = choices[alike..].iter().map(|c| c.hold).collect();
        assert_eq!(rest, holds[alike..]);
        let kept: Vec<bool> = choices.iter().map(|c| c.flat.is_some()).collect();
        assert!(kept[0] && !kept[1..].contains(&true), "{kept:?}");
    }

    #[test]
    fn where_weight_does_not_load_the_contacts_the_hold_decides() {
        let (file, motion, found) = searched("1R", 1, "[0.0, 0.0, -1.0]");
        let holds: Vec<f64> = found.iter().map(|c| c.1).collect();
        let choices = by_payload(&file, &motion, found);
        let order: Vec<f64> = choices.iter().map(|c| c.hold).collect();
        assert_eq!(order, holds);
    }
}
