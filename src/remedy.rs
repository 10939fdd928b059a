//! What would make a motion feasible that is not: other teeth, a larger gear, a smaller motion, each tried
//! by a quick draft (neither polished nor proved), never guessed.

use serde::{Deserialize, Serialize};

use crate::motion::Motion;
use crate::search::{self, Found, Observer, Progress};
use crate::settings::{Auto, Settings, ToothCount};

/// A change that a draft was found with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Remedy {
    /// Setting to change (`gear.teeth`), or `amplitude` for the share of the motion.
    pub change: String,
    /// Its value.
    pub value: f64,
    /// Min Q* of the draft, before polish.
    pub q_star: f64,
}

impl std::fmt::Display for Remedy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (value, q_star) = (self.value, self.q_star);
        match self.change.as_str() {
            "gear.teeth" => write!(f, "feasible at J = {value}")?,
            "gear.driver_teeth" => write!(f, "feasible with {value} teeth on both gears")?,
            "gear.center_distance_mm" => write!(f, "feasible at L = {value:.0} mm")?,
            "gear.tooth_thickness_mm" => write!(f, "feasible with teeth of {value} mm")?,
            _ => write!(f, "feasible at {:.0} % of the amplitude", 100.0 * value)?,
        }
        write!(f, " (a draft of Q* {q_star:.2})")
    }
}

/// Work of a draft, relative to what the search of the motion itself was given.
const EFFORT: f64 = 0.25;
/// Largest amplitude that works is found to this share.
const STEP: f64 = 1.0 / 16.0;

/// Tries changes until `tell` breaks; those that a draft was found with. First one change of the teeth
/// and one of the size, then the largest amplitude.
pub fn find(motion: &Motion, settings: &Settings, tell: &mut Observer) -> Vec<Remedy> {
    let mut base = settings.clone();
    base.search.effort *= EFFORT;
    let mut work = Work { tell, over: false };
    let mut remedies = Vec::new();
    let class = motion.class();
    let gear = &settings.gear;
    let numbers = [0.8, 0.7, 0.6, 1.2].map(|f| {
        let teeth = (gear.tooth_pairs() as f64 * f).round();
        let mut other = base.clone();
        other.gear.teeth = teeth as usize;
        other.gear.driver_teeth = ToothCount::Auto(Auto::Auto);
        other.gear.follower_teeth = ToothCount::Auto(Auto::Auto);
        ("gear.teeth", teeth, other)
    });
    // Where the driver has more teeth than the follower, as many first of all.
    let equal = || {
        let teeth = gear.tooth_pairs();
        let mut other = base.clone();
        other.gear.driver_teeth = ToothCount::Fixed(teeth);
        ("gear.driver_teeth", teeth as f64, other)
    };
    let teeth = match gear.drive().copies() {
        1 => numbers.to_vec(),
        _ => vec![equal()],
    };
    // Teeth of unequal gears stand as far apart as those of equal ones where the follower is as large.
    let wanted = gear.center_distance_mm / gear.drive().follower_share(1.0);
    let sizes = [1.2, 1.4, 1.6, 2.0].map(|f| {
        let distance = (wanted * f).round();
        let mut other = base.clone();
        other.gear.center_distance_mm = distance;
        ("gear.center_distance_mm", distance, other)
    });
    for group in [&teeth[..], &sizes[..]] {
        let found = group.iter().find_map(|(change, value, other)| {
            if !other.problems(class).is_empty() {
                return None;
            }
            let q_star = work.draft(motion, other)?;
            Some(Remedy {
                change: (*change).into(),
                value: *value,
                q_star,
            })
        });
        remedies.extend(found);
    }
    remedies.extend(work.amplitude(motion, &base));
    remedies
}

struct Work<'a, 'b> {
    tell: &'a mut Observer<'b>,
    over: bool,
}

impl Work<'_, '_> {
    /// Q* of a draft; `None` when there is none, or no time.
    fn draft(&mut self, motion: &Motion, settings: &Settings) -> Option<f64> {
        if self.over {
            return None;
        }
        let over = &mut self.over;
        let tell = &mut *self.tell;
        let found = search::draft(motion, settings, &mut |progress: &Progress| {
            let answer = tell(&Progress {
                stage: search::REMEDIES,
                ..progress.clone()
            });
            *over |= answer.is_break();
            answer
        });
        let hold = found.ok().map(|found: Found| found.hold());
        let unit = match motion.class().slides() {
            true => 1.0,
            false => 0.5 * settings.gear.center_distance_mm,
        };
        hold.map(|hold| hold / unit)
    }

    /// The largest share of the motion, in steps of [`STEP`], that a draft is found for, by bisection.
    fn amplitude(&mut self, motion: &Motion, settings: &Settings) -> Option<Remedy> {
        let (mut low, mut high) = (0.0, 1.0);
        let mut best = None;
        while high - low > STEP {
            let share = 0.5 * (low + high);
            let found = self.draft(&motion.scaled(share), settings);
            if self.over {
                break;
            }
            match found {
                Some(q_star) => {
                    best = Some((share, q_star));
                    low = share;
                }
                None => high = share,
            }
        }
        best.map(|(value, q_star)| Remedy {
            change: "amplitude".into(),
            value,
            q_star,
        })
    }
}
