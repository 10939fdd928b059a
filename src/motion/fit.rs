//! A band-limited periodic motion near measured or hand-made poses: the fewest harmonics that come within a
//! tolerance of all of them but a few outliers.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, Vector2};
use serde::Serialize;

use super::fourier::{Drift, Samples, Series};
use super::hub::net_turn_error;
use super::measured::{COMPONENTS, Frame, Measured};
use super::rows::RowShape;
use super::survey::{Sharpness, sharpest, sharpest_of};
use super::{Class, Cycle, Motion, MotionSource, Table};
use crate::{Error, Problem, Result};

/// Most harmonics of a fitted motion.
const MOST_HARMONICS: usize = 60;

/// Outliers are farther off than so many times the median deviation, …
const OUTLYING: f64 = 6.0;
/// … they are at most this share of the poses, …
const OUTLIER_SHARE: f64 = 0.05;
/// … and at most so many follow each other: more are a part of the motion.
const OUTLIER_RUN: usize = 2;

/// A gap of so many times the root mean square deviation is a drift.
const OPEN: f64 = 4.0;

/// Rounds of fitting and of leaving outliers out, at most.
const ROUNDS: usize = 12;

/// Rows of the fitted table per period.
const TABLE_ROWS: u32 = 360;

/// A tolerance that would do is looked for in so many steps, each so much larger: a little more than the
/// nearest motion needs takes far fewer harmonics.
const SUGGESTIONS: usize = 24;
const WIDER: f64 = 1.25;

/// How far a fitted motion may be from the poses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    /// Of the position, mm.
    pub mm: f64,
    /// Of the rotation, deg.
    pub deg: f64,
}

impl std::fmt::Display for Tolerance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}mm,{}deg", self.mm, self.deg)
    }
}

/// How far a pose or several are off.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Deviation {
    /// Position, mm.
    pub mm: f64,
    /// Rotation, deg.
    pub deg: f64,
}

impl Deviation {
    /// In tolerances; the larger of both counts.
    fn share(self, tolerance: Tolerance) -> f64 {
        (self.mm / tolerance.mm).max(self.deg / tolerance.deg)
    }

    fn largest(list: impl Iterator<Item = Deviation>) -> Deviation {
        list.fold(Deviation::default(), |most, d| Deviation {
            mm: most.mm.max(d.mm),
            deg: most.deg.max(d.deg),
        })
    }

    fn rms(list: impl Iterator<Item = Deviation> + Clone) -> Deviation {
        let count = list.clone().count().max(1) as f64;
        let mean = |get: fn(Deviation) -> f64| {
            let squares = list.clone().map(|d| get(d) * get(d));
            (squares.sum::<f64>() / count).sqrt()
        };
        Deviation {
            mm: mean(|d| d.mm),
            deg: mean(|d| d.deg),
        }
    }
}

/// A pose that is no part of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Outlier {
    /// Line of the file.
    pub line: u64,
    /// Its phase, deg.
    pub phi_deg: f64,
    /// How far the fitted motion is from it.
    #[serde(flatten)]
    pub deviation: Deviation,
}

/// What fitting changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Class of the fitted motion: the simplest that comes within the tolerance, if none was asked for.
    pub class: Class,
    /// Poses read.
    pub rows: usize,
    /// Highest harmonic of φ in the fitted motion.
    pub harmonics: usize,
    /// The tolerance asked for.
    pub tolerance: Tolerance,
    /// Largest deviation of the poses that are no outliers.
    pub largest: Deviation,
    /// Line of the pose with the largest deviation, in tolerances.
    pub largest_line: u64,
    /// Root mean square of these deviations.
    pub rms: Deviation,
    /// Poses that were left out.
    pub outliers: Vec<Outlier>,
    /// How far the last pose was from the first, where it repeats it; it is closed now.
    pub closing_gap: Option<Deviation>,
    /// Whether an even drift along the poses was taken off.
    pub drift_removed: bool,
    /// How fast the motion through the poses as they are changes, where there is one.
    pub sharpness_before: Option<Sharpness>,
    /// The same of the fitted motion.
    pub sharpness_after: Sharpness,
}

/// A fitted motion.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The motion as a table.
    pub table: Table,
    /// The motion.
    pub motion: Motion,
    /// What was changed.
    pub report: Report,
}

/// Fits a motion of `class`, or of the simplest class that does, to poses. Sharpness is told for gears
/// `center_distance` mm apart.
///
/// # Errors
/// [`Error::Input`] when the tolerance cannot be met, with the one that can; [`Error::Infeasible`] when the
/// motion is not one of a gear.
pub fn fit(
    measured: &Measured,
    (class, tolerance): (Option<Class>, Tolerance),
    center_distance: f64,
) -> Result<Fit> {
    let classes = class.map_or(Class::ALL.to_vec(), |class| vec![class]);
    let candidates = candidates(measured, &classes)?;
    match first_within(&candidates, tolerance) {
        Ok(found) => finished(measured, (found, tolerance), center_distance),
        Err(nearest) => Err(refusal(measured, (&candidates, tolerance), &nearest)),
    }
}

/// The poses as a motion of a class.
struct Candidate<'m> {
    class: Class,
    frame: Frame,
    samples: Samples,
    measured: &'m Measured,
}

fn candidates<'m>(measured: &'m Measured, classes: &[Class]) -> Result<Vec<Candidate<'m>>> {
    let rows = &measured.rows;
    let phases: Vec<f64> = rows.iter().map(|row| row.phi).collect();
    let candidate = |class: &Class| {
        let frame = Frame::new(*class, rows)?;
        let values = frame.components(rows);
        Ok(Candidate {
            class: *class,
            samples: Samples::new(&phases, values, most_harmonics(measured)),
            frame,
            measured,
        })
    };
    classes.iter().map(candidate).collect()
}

fn most_harmonics(measured: &Measured) -> usize {
    measured.most_harmonics().min(MOST_HARMONICS)
}

/// A series beside the poses.
struct Trial<'c> {
    candidate: &'c Candidate<'c>,
    series: Series,
    harmonics: usize,
    drift: Drift,
    deviations: Vec<Deviation>,
    kept: Vec<bool>,
}

impl Trial<'_> {
    fn kept_deviations(&self) -> impl Iterator<Item = Deviation> + Clone {
        let both = self.deviations.iter().zip(&self.kept);
        both.filter(|(_, kept)| **kept).map(|(d, _)| *d)
    }

    fn share(&self, tolerance: Tolerance) -> f64 {
        Deviation::largest(self.kept_deviations()).share(tolerance)
    }

    /// Index of the kept pose that is farthest off.
    fn worst(&self, tolerance: Tolerance) -> Option<usize> {
        let share = |i: &usize| self.deviations[*i].share(tolerance);
        let kept = (0..self.kept.len()).filter(|i| self.kept[*i]);
        kept.max_by(|a, b| share(a).total_cmp(&share(b)))
    }

    /// Whether the gap at the end of the period is more than noise.
    fn has_open_gap(&self) -> bool {
        let rms = Deviation::rms(self.kept_deviations());
        let gap = self.candidate.measured.closing_gap();
        gap.is_some_and(|gap| gap.mm > OPEN * rms.mm || gap.deg > OPEN * rms.deg)
    }

    /// Whether what was left out can be called outliers.
    fn outliers_are_few(&self) -> bool {
        let count = self.kept.iter().filter(|kept| !**kept).count();
        let longest = self.kept.split(|kept| *kept).map(<[bool]>::len).max();
        count as f64 <= OUTLIER_SHARE * self.kept.len() as f64
            && longest.unwrap_or(0) <= OUTLIER_RUN
    }
}

/// The first trial within the tolerance, simple classes and few harmonics first; else the nearest one.
fn first_within<'c>(
    candidates: &'c [Candidate<'c>],
    tolerance: Tolerance,
) -> std::result::Result<Trial<'c>, Option<Trial<'c>>> {
    let mut nearest: Option<Trial> = None;
    for candidate in candidates {
        for harmonics in 0..=most_harmonics(candidate.measured) {
            let of = |drift| candidate.trial((harmonics, drift), tolerance);
            let [without, beside] = [Drift::Without, Drift::Beside].map(of);
            let drifts = without.as_ref().is_some_and(Trial::has_open_gap);
            let trials = match drifts {
                true => [beside, without],
                false => [without, beside],
            };
            for trial in trials.into_iter().flatten() {
                if !trial.outliers_are_few() {
                    continue;
                }
                let share = trial.share(tolerance);
                if share <= 1.0 {
                    return Ok(trial);
                }
                if nearest.as_ref().is_none_or(|n| share < n.share(tolerance)) {
                    nearest = Some(trial);
                }
            }
        }
    }
    Err(nearest)
}

impl Candidate<'_> {
    /// Least squares over all poses but those that turn out far off.
    fn trial(&self, (harmonics, drift): (usize, Drift), tolerance: Tolerance) -> Option<Trial<'_>> {
        let mut kept = vec![true; self.measured.count()];
        let mut round = 0;
        loop {
            let mut series = self.samples.fit(harmonics, drift, &kept)?;
            self.project(&mut series);
            let deviations = self.deviations(&self.samples.at_samples(&series));
            let shares: Vec<f64> = deviations.iter().map(|d| d.share(tolerance)).collect();
            let far = (OUTLYING * median(shares.clone())).max(1.0);
            let near: Vec<bool> = shares.iter().map(|share| *share <= far).collect();
            round += 1;
            if near == kept || round == ROUNDS {
                return Some(Trial {
                    candidate: self,
                    series,
                    harmonics,
                    drift,
                    deviations,
                    kept: near,
                });
            }
            kept = near;
        }
    }

    /// Takes away what the class cannot do.
    fn project(&self, series: &mut Series) {
        let tilts = [0, 1].iter().filter(|_| !self.class.is_spherical());
        let slide = [5].iter().filter(|_| !self.class.slides());
        for component in tilts.chain(&[3, 4]).chain(slide) {
            series.clear(*component);
        }
    }

    fn deviations(&self, values: &DMatrix<f64>) -> Vec<Deviation> {
        let rows = self.measured.rows.iter().zip(values.row_iter());
        rows.map(|(row, values)| {
            let values: [f64; COMPONENTS] = std::array::from_fn(|i| values[i]);
            let (rotation, position) = self.frame.pose(row.phi, &values);
            Deviation {
                mm: (position - row.position).norm(),
                deg: rotation.angle_to(&row.rotation).to_degrees(),
            }
        })
        .collect()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The motion of a trial and what it changed.
fn finished(
    measured: &Measured,
    (trial, tolerance): (Trial, Tolerance),
    center_distance: f64,
) -> Result<Fit> {
    let class = trial.candidate.class;
    let table = table(&trial);
    let motion = Motion::new(class, &MotionSource::Table(table.clone()))?;
    let kept = trial.kept_deviations();
    let outlier = |i: usize| Outlier {
        line: measured.lines[i],
        phi_deg: measured.rows[i].phi.to_degrees(),
        deviation: trial.deviations[i],
    };
    let mut outliers: Vec<Outlier> = (0..measured.count())
        .filter(|i| !trial.kept[*i])
        .map(outlier)
        .collect();
    outliers.sort_by_key(|outlier| outlier.line);
    let report = Report {
        class,
        rows: measured.count(),
        harmonics: trial.harmonics,
        tolerance,
        largest: Deviation::largest(kept.clone()),
        largest_line: trial.worst(tolerance).map_or(0, |i| measured.lines[i]),
        rms: Deviation::rms(kept),
        outliers,
        closing_gap: measured.closing_gap(),
        drift_removed: trial.drift == Drift::Beside,
        sharpness_before: sharpness_as_given(measured, center_distance),
        sharpness_after: sharpest(&motion, center_distance),
    };
    Ok(Fit {
        table,
        motion,
        report,
    })
}

/// The fitted motion at evenly spread phases; the last row repeats the first, a turn later.
fn table(trial: &Trial) -> Table {
    let mut last = nalgebra::Vector4::w();
    let rows = (0..=TABLE_ROWS).map(|i| {
        let phi = TAU * f64::from(i % TABLE_ROWS) / f64::from(TABLE_ROWS);
        let values = trial.series.at(phi);
        let (rotation, p) = trial.candidate.frame.pose(phi, values.as_slice());
        // The same rotation on the side of the row before.
        let mut q = rotation.coords;
        if q.dot(&last) < 0.0 {
            q = -q;
        }
        last = q;
        let phi_deg = 360.0 * f64::from(i) / f64::from(TABLE_ROWS);
        [phi_deg, p.x, p.y, p.z, q.w, q.x, q.y, q.z].map(rounded)
    });
    Table {
        rows: rows.collect(),
    }
}

/// Nine decimals, no negative zero.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9 + 0.0
}

/// How sharp the motion through all poses is, outliers and gap included; `None` where poses are too far
/// apart to be joined.
fn sharpness_as_given(measured: &Measured, center_distance: f64) -> Option<Sharpness> {
    let first = measured.rows[0].phi;
    let within = |phi: f64| phi - first < TAU - 1e-6;
    let mut rows = measured.rows.clone();
    rows.retain(|row| within(row.phi));
    let shape = RowShape::new(&rows, super::expression::Expression::own_turn().ok()?).ok()?;
    let state = |phi: f64| shape.at(phi).state();
    Some(sharpest_of(Cycle::turning(), center_distance, state))
}

/// Why there is no such motion, and which tolerance would do.
fn refusal(
    measured: &Measured,
    (candidates, tolerance): (&[Candidate], Tolerance),
    nearest: &Option<Trial>,
) -> Error {
    let frame = &candidates[candidates.len() - 1].frame;
    let beside = frame.turns_beside(&measured.rows);
    if beside.abs() > 0.5 {
        return net_turn_error(beside - 1.0);
    }
    let place = "--tolerance".to_owned();
    let most = most_harmonics(measured);
    let Some(nearest) = nearest else {
        let what = format!(
            "is {tolerance}: with up to {most} harmonics more than a twentieth of the poses is far off"
        );
        let hint = "look for wrong rows; more rows allow for more harmonics";
        return Error::input("command line", vec![Problem::new(place, what, hint)]);
    };
    let off = Deviation::largest(nearest.kept_deviations());
    let at = nearest.worst(tolerance).map_or(String::new(), |i| {
        let row = &measured.rows[i];
        format!(", most at φ = {:.1}° ({})", row.phi.to_degrees(), row.place)
    });
    let what = format!(
        "is {tolerance}: the nearest motion of class {} with up to {most} harmonics leaves the poses by {:.3} mm and {:.3}°{at}",
        nearest.candidate.class, off.mm, off.deg
    );
    let hint = hint((candidates, tolerance), off, measured);
    Error::input("command line", vec![Problem::new(place, what, hint)])
}

fn hint(
    (candidates, tolerance): (&[Candidate], Tolerance),
    off: Deviation,
    measured: &Measured,
) -> String {
    let mut wide = Tolerance {
        mm: tolerance.mm.max(WIDER * off.mm),
        deg: tolerance.deg.max(WIDER * off.deg),
    };
    let mut hints = Vec::new();
    for _ in 0..SUGGESTIONS {
        let tried = Tolerance {
            mm: upwards(wide.mm),
            deg: upwards(wide.deg),
        };
        if let Ok(trial) = first_within(candidates, tried) {
            hints.push(format!(
                "--tolerance {tried} would do, with {} harmonics",
                trial.harmonics
            ));
            break;
        }
        wide = Tolerance {
            mm: tried.mm * WIDER,
            deg: tried.deg * WIDER,
        };
    }
    if let Some(gap) = measured.closing_gap()
        && gap.share(tolerance) > 2.0
    {
        hints.push(format!(
            "the last pose is {:.3} mm and {:.3}° away from the first, so half of that is left at least",
            gap.mm, gap.deg
        ));
    }
    let aside: Vector2<f64> = measured.rows.iter().map(|row| row.position.xy()).sum();
    let aside = aside.norm() / measured.count() as f64;
    if aside > tolerance.mm {
        hints.push(format!(
            "the poses are {aside:.2} mm aside of the z axis: put the origin of the follower's frame at the joint's centre"
        ));
    }
    hints.join("; ")
}

/// `x` with two digits, rounded up.
fn upwards(x: f64) -> f64 {
    let unit = 10f64.powf(x.log10().floor() - 1.0);
    let digits = (x / unit - 1e-9).ceil();
    // Dividing by a power of ten gives the number as it is written.
    match unit < 1.0 {
        true => digits / (1.0 / unit).round(),
        false => digits * unit,
    }
}
