//! `summary.json` and `poses.csv`.

use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

use crate::design::Design;
use crate::motion::{Class, Drive, Motion};
use crate::remedy::Remedy;
use crate::{Error, Result};

/// The figures of a design, as in `summary.json`; a figure that was not measured is `null`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name from the motion file.
    pub name: String,
    /// Class of the joint.
    pub class: Class,
    /// K, number of sub-gear pairs.
    pub k: usize,
    /// J, teeth per band.
    pub j: usize,
    /// Teeth of a band on the driver.
    #[serde(default)]
    pub driver_teeth: usize,
    /// c, contact ratio: that asked for, or the least where that holds better.
    #[serde(default)]
    pub contact_ratio: f64,
    /// Whether everything was proved to work.
    pub feasible: bool,
    /// Whether this is only a first look (`--draft`): neither polished nor proved.
    #[serde(default)]
    pub draft: bool,
    /// Smallest Q over the period (Eq. 12).
    pub q_min: Option<f64>,
    /// Mean Q.
    pub q_mean: Option<f64>,
    /// Smallest Q with moments divided by L/2.
    pub q_star_min: Option<f64>,
    /// What min Q is at least, between the sampled phases as well.
    #[serde(default)]
    pub q_certified: Option<f64>,
    /// What min Q* is at least, between the sampled phases as well.
    #[serde(default)]
    pub q_star_certified: Option<f64>,
    /// What min Q is at most for this motion, size and reach, whatever the teeth.
    #[serde(default)]
    pub q_bound: Option<f64>,
    /// What min Q* is at most.
    #[serde(default)]
    pub q_star_bound: Option<f64>,
    /// Smallest quality η.
    pub eta_min: Option<f64>,
    /// Share of the period with Q above the threshold (Eq. 11).
    pub valid_time: Option<f64>,
    /// Largest |n·v_rel| or |n·T²|, mm/rad.
    pub conjugation_residual_max: Option<f64>,
    /// Largest volume that two bodies share at any phase, mm³.
    pub overlap_max_mm3: Option<f64>,
    /// Directions and phases in which the follower could get away.
    pub escapes: Option<usize>,
    /// Thinnest wall, mm.
    pub wall_min_mm: Option<f64>,
    /// Time that the design took, s.
    pub wall_seconds: f64,
    /// What of it each stage took, in the order in which they began; empty where nobody looked.
    #[serde(default)]
    pub stages: Vec<Stage>,
    /// Seed of the search.
    pub seed: u64,
    /// `mpcgear` version.
    pub version: String,
    /// Whether no choice of the bands that were looked at holds better before the polish; `null` where it
    /// was not tried.
    #[serde(default)]
    pub choice_proved: Option<bool>,
    /// Why it is not a working gear; empty when it is.
    pub problems: Vec<String>,
    /// Where it does not work: changes that a draft was found with.
    #[serde(default)]
    pub remedies: Vec<Remedy>,
    /// What else there is to know.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// Whether Ctrl-C or the time limit ended the work early: the best so far, not all that was planned.
    #[serde(default)]
    pub stopped: bool,
}

/// File of the [`Summary`] in the output folder.
pub const SUMMARY: &str = "summary.json";

/// Time of one stage of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// What was done.
    pub name: String,
    /// Wall time, s.
    pub wall_s: f64,
    /// Processor time of all threads, s; `None` where the system does not tell.
    pub cpu_s: Option<f64>,
}

impl Summary {
    /// What the design itself says; the bounds, what the search proved, the four figures of the proof and the time stay open.
    pub fn of(design: &Design) -> Summary {
        let samples = &design.closure;
        let least = |values: fn(&crate::design::ClosureSample) -> f64| {
            samples.iter().map(values).fold(None, |least, value| {
                Some(f64::min(least.unwrap_or(f64::INFINITY), value))
            })
        };
        let count = samples.len() as f64;
        let valid = samples
            .iter()
            .filter(|s| s.q > design.settings.gear.closure_threshold)
            .count() as f64;
        Summary {
            name: design.name.clone(),
            class: design.class,
            k: design.sub_gear_pairs.len(),
            j: design.tooth_pairs(),
            driver_teeth: design.tooth_pairs() * design.settings.gear.drive().copies(),
            contact_ratio: design.settings.gear.contact_ratio,
            feasible: design.problems.is_empty(),
            draft: false,
            q_min: least(|s| s.q),
            q_mean: (count > 0.0).then(|| samples.iter().map(|s| s.q).sum::<f64>() / count),
            q_star_min: least(|s| s.q_star),
            q_certified: None,
            q_star_certified: None,
            q_bound: None,
            q_star_bound: None,
            eta_min: least(|s| s.eta),
            valid_time: (count > 0.0).then(|| valid / count),
            conjugation_residual_max: None,
            overlap_max_mm3: None,
            escapes: None,
            wall_min_mm: None,
            wall_seconds: 0.0,
            stages: Vec::new(),
            seed: design.settings.search.seed,
            version: env!("CARGO_PKG_VERSION").into(),
            choice_proved: None,
            problems: design.problems.clone(),
            remedies: Vec::new(),
            remarks: Vec::new(),
            stopped: false,
        }
    }
}

/// `summary.json`, one key per line.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails.
pub fn summary_json(summary: &Summary) -> Result<String> {
    let text = serde_json::to_string_pretty(summary);
    text.map(|t| t + "\n")
        .map_err(|e| Error::Internal(format!("summary.json: {e}")))
}

/// Teeth in a band, as cards and headings say it: of both gears, or driver : follower.
pub fn teeth(design: &Design) -> String {
    let gear = &design.settings.gear;
    match (gear.teeth_on_driver(), gear.tooth_pairs()) {
        (driver, follower) if driver == follower => design.tooth_pairs().to_string(),
        (driver, follower) => format!("{driver}:{follower}"),
    }
}

/// Pose of the follower at one phase.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PoseRow {
    /// Phase or driver angle, degrees.
    pub phi_deg: f64,
    /// Position of the body origin, mm.
    pub x: f64,
    /// As `x`.
    pub y: f64,
    /// As `x`.
    pub z: f64,
    /// Unit quaternion; its sign is continuous from row to row.
    pub qw: f64,
    /// As `qw`.
    pub qx: f64,
    /// As `qw`.
    pub qy: f64,
    /// As `qw`.
    pub qz: f64,
}

/// `steps + 1` poses over one period or range, both ends included.
pub fn poses(motion: &Motion, steps: u32) -> Vec<PoseRow> {
    rows(motion, (steps, 1))
}

/// Poses over one turn of the driver, both ends included, `steps` in each period; angles are the driver's.
pub fn poses_of_turn(motion: &Motion, drive: Drive, steps: u32) -> Vec<PoseRow> {
    rows(motion, (steps, drive.copies() as u32))
}

fn rows(motion: &Motion, (steps, periods): (u32, u32)) -> Vec<PoseRow> {
    let mut rows: Vec<PoseRow> = Vec::new();
    let mut last = UnitQuaternion::identity();
    let steps = steps * periods;
    for i in 0..=steps {
        let turn = f64::from(i) / f64::from(steps);
        let cycle = motion.cycle();
        let pose = motion
            .state(cycle.start() + turn * f64::from(periods) * cycle.length())
            .pose;
        let mut q = pose.quaternion();
        if q.coords.dot(&last.coords) < 0.0 {
            q = UnitQuaternion::new_unchecked(-q.into_inner());
        }
        last = q;
        let [x, y, z] = pose.translation.map(rounded).into();
        rows.push(PoseRow {
            phi_deg: match cycle.wraps() {
                true => 360.0 * turn,
                false => (cycle.start() + turn * cycle.length()).to_degrees(),
            },
            x,
            y,
            z,
            qw: rounded(q.w),
            qx: rounded(q.i),
            qy: rounded(q.j),
            qz: rounded(q.k),
        });
    }
    rows
}

/// Nine decimals, no negative zero.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9 + 0.0
}

/// `poses.csv`: the follower's pose at every whole degree, 361 rows below the header.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails.
pub fn poses_csv(motion: &Motion) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in poses(motion, 360) {
        writer
            .serialize(row)
            .map_err(|e| Error::Internal(format!("poses.csv: {e}")))?;
    }
    writer
        .into_inner()
        .map_err(|e| Error::Internal(format!("poses.csv: {e}")))
}
