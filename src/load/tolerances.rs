//! How gears come out that are made with ordinary errors: many draws, each over a whole turn.
//!
//! Every error is drawn from a normal distribution with half its tolerance as deviation, cut off at the tolerance:
//! centre distance, tilt of the axis, scale of both gears ([`Load`]), and how far either flank lies off its place
//! ([`Fit::surface_error_mm`](crate::settings::Fit::surface_error_mm)). A gear works when no contact jams, the follower is held at every angle, and its
//! play is within what the settings allow.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

use super::contacts::Configuration;
use super::sensitivity::{Deviation, ERRORS, effect};
use super::{Load, Sampling, forces, play};
use crate::design::Design;
use crate::motion::Motion;
use crate::{Error, Result};

/// Angles of a turn at which each gear is looked at.
const ANGLES: usize = 36;

/// Which gears are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    /// How many.
    pub count: u32,
    /// Seed of them.
    pub seed: u64,
}

/// A figure of many gears: what 5, 50 and 95 of 100 stay below.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Percentiles {
    /// 5th.
    pub p5: f64,
    /// Median.
    pub p50: f64,
    /// 95th.
    pub p95: f64,
}

/// How the gears come out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// How many were drawn.
    pub draws: u32,
    /// Share that works.
    pub works: f64,
    /// Share in which a contact has no gap left.
    pub jams: f64,
    /// Share in which the follower is not held somewhere.
    pub loose: f64,
    /// Share with more play than allowed.
    pub too_much_play: f64,
    /// Largest play of the load point over a turn, of those that do not jam, mm; `None` where all do.
    pub play_mm: Option<Percentiles>,
    /// The same as an angle, deg.
    pub play_deg: Option<Percentiles>,
    /// Least hold over a turn, of all.
    pub q_min: Option<Percentiles>,
}

/// One gear.
#[derive(Debug, Clone, Copy)]
struct Gear {
    q: f64,
    /// Play of point (mm) and angle (rad); `None` where it jams.
    play: Option<[f64; 2]>,
}

/// Makes gears of `design` with the errors that `load` allows.
///
/// # Errors
/// [`Error::Infeasible`] where the follower is not form closed without any error.
pub fn spread(design: &Design, motion: &Motion, load: &Load, draws: Draws) -> Result<Spread> {
    let sampling = Sampling {
        count: ANGLES,
        ..Sampling::of(motion)
    };
    let angles = sampling.angles().map(|phi| {
        let at = Configuration::at(design, motion, phi)?;
        match forces::closed(&play::columns(&at)) {
            true => Ok(at),
            false => Err(Error::Infeasible {
                reason: "the follower is not form closed".into(),
                place: format!("φ = {:.2}°", phi.to_degrees()),
                hint: "errors are only tried on gears that work without".into(),
            }),
        }
    });
    let angles = angles.collect::<Result<Vec<_>>>()?;
    let gears: Vec<Gear> = (0..draws.count)
        .into_par_iter()
        .map(|i| {
            let mut rng = ChaCha8Rng::seed_from_u64(draws.seed);
            rng.set_stream(u64::from(i));
            let deviation = Deviation::scaled(
                load,
                std::array::from_fn::<_, ERRORS, _>(|_| error(&mut rng)),
            );
            let flanks = design.settings.fit.surface_error_mm * (error(&mut rng) + error(&mut rng));
            gear((design, load), &angles, (&deviation, flanks))
        })
        .collect();
    Ok(summary(design, &gears))
}

/// An error as a share of its tolerance.
fn error(rng: &mut ChaCha8Rng) -> f64 {
    loop {
        // Box and Muller.
        let (u, v): (f64, f64) = (
            rng.random_range(f64::EPSILON..1.0),
            rng.random_range(0.0..1.0),
        );
        let share = 0.5 * (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
        if share.abs() <= 1.0 {
            return share;
        }
    }
}

/// One gear over a turn; flanks that stand out by `flanks` in all take that from the gap.
fn gear(
    (design, load): (&Design, &Load),
    angles: &[Configuration],
    (deviation, flanks): (&Deviation, f64),
) -> Gear {
    let gap = design.section.clearance - flanks;
    let mut gear = Gear {
        q: f64::INFINITY,
        play: Some([0.0; 2]),
    };
    for at in angles {
        let point = at.follower.pose.apply(load.point_mm.into());
        let Some(effect) = effect(at, point, deviation) else {
            return Gear { q: 0.0, play: None };
        };
        gear.q = gear.q.min(effect.q);
        let gaps: Vec<f64> = effect.losses.iter().map(|loss| gap - loss).collect();
        let columns = play::columns(at);
        let still = nalgebra::DVector::zeros(at.class.dof());
        let play = match gaps.iter().all(|gap| *gap >= 0.0) {
            true => play::within(at, &columns, &gaps, (point, &still)),
            false => None,
        };
        gear.play = match (gear.play, play) {
            (Some([mm, turn]), Some(play)) => Some([mm.max(play.point), turn.max(play.turn)]),
            _ => None,
        };
    }
    gear
}

fn summary(design: &Design, gears: &[Gear]) -> Spread {
    let (fit, threshold) = (&design.settings.fit, design.settings.gear.closure_threshold);
    let share = |holds: &dyn Fn(&Gear) -> bool| {
        gears.iter().filter(|g| holds(g)).count() as f64 / gears.len().max(1) as f64
    };
    let far = |g: &Gear| {
        g.play
            .is_some_and(|[mm, turn]| mm > fit.max_play_mm || turn.to_degrees() > fit.max_play_deg)
    };
    let loose = |g: &Gear| !(g.q > threshold);
    let plays = |i: usize| {
        gears
            .iter()
            .filter_map(|g| Some(g.play?[i]))
            .collect::<Vec<_>>()
    };
    let degrees = plays(1).into_iter().map(f64::to_degrees).collect();
    Spread {
        draws: gears.len() as u32,
        works: share(&|g| g.play.is_some() && !loose(g) && !far(g)),
        jams: share(&|g| g.play.is_none()),
        loose: share(&loose),
        too_much_play: share(&far),
        play_mm: percentiles(plays(0)),
        play_deg: percentiles(degrees),
        q_min: percentiles(gears.iter().map(|g| g.q).collect()),
    }
}

fn percentiles(mut values: Vec<f64>) -> Option<Percentiles> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let place = share * values.len().saturating_sub(1) as f64;
        values.get(place.round() as usize).copied()
    };
    Some(Percentiles {
        p5: at(0.05)?,
        p50: at(0.5)?,
        p95: at(0.95)?,
    })
}
