//! From chosen bands to the serialised [`Design`]: finely traced teeth, splines, Q over the period.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::closure::{Wrench, measure, wrench};
use crate::contact::{Contact, Grid, Node, PaperBand, Trace, spline, trace};
use crate::design::{self, ClosureSample, Design, Station, SubGearPair, ToothPair};
use crate::flank;
use crate::flare;
use crate::motion::{Motion, MotionFile};
use crate::settings::{FlankRadius, Settings};
use crate::solid::layout;
use crate::sub_gear::BandLaw;
use crate::{Error, Result};

/// Integration steps a tooth: stations are this plus one. The curve is then known well enough that
/// its derivative can be taken from the stations to 1e-6 mm/rad.
pub const STEPS: usize = 200;

/// Control points of the exported locus splines.
const CONTROL_POINTS: usize = 8;

/// Chosen bands of either parameterisation.
#[derive(Debug, Clone)]
pub enum Bands {
    /// Normal first.
    Exact(Vec<BandLaw>),
    /// Published splines.
    Paper(Vec<PaperBand>),
}

/// Traces of all teeth of `bands`, with the design variables to be stored.
fn trace_all(grid: &Grid, bands: &Bands) -> Result<Vec<(Vec<f64>, Vec<Trace>)>> {
    let exact = |band: &BandLaw| {
        let teeth = (0..grid.teeth.len())
            .map(|j| {
                trace(grid, j, &band.at(grid, j))
                    .ok_or_else(|| Error::Internal(format!("tooth {} degenerates", j + 1)))
            })
            .collect::<Result<_>>()?;
        Ok((band.to_parameters(), teeth))
    };
    match bands {
        Bands::Exact(bands) => bands.par_iter().map(exact).collect(),
        Bands::Paper(bands) => Ok(bands.iter().map(|b| (Vec::new(), b.traces(grid))).collect()),
    }
}

/// How flat flanks are whose radius is to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flanks {
    /// As flat as contact allows.
    Flat,
    /// Those of a round bead.
    Round,
}

/// The design of `bands`, with its recipe.
///
/// # Errors
/// [`Error::Internal`] when a band cannot be traced (the search only hands over bands that can);
/// [`Error::Infeasible`] when the motion leaves no room for the joint.
pub fn design(file: &MotionFile, motion: &Motion, bands: &Bands, flanks: Flanks) -> Result<Design> {
    let settings = &file.settings;
    let grid = Grid::new(motion, &settings.gear, STEPS);
    let (parameters, traces): (Vec<_>, Vec<_>) = trace_all(&grid, bands)?.into_iter().unzip();
    let sub_gear_pairs = parameters
        .into_iter()
        .zip(&traces)
        .map(|(parameters, teeth)| SubGearPair {
            flank_radius: None,
            parameters,
            teeth: teeth
                .iter()
                .enumerate()
                .map(|(j, t)| tooth_pair(&grid, j, t))
                .collect(),
        })
        .collect();
    let mut design = Design {
        sub_gear_pairs,
        closure: closure(motion, settings, &grid, &traces),
        ..Design::draft(file)
    };
    if let (FlankRadius::Auto(_), Flanks::Flat) = (settings.gear.flank_radius_mm, flanks) {
        for (k, teeth) in traces.iter().enumerate() {
            let band = flank::Band {
                contacts: teeth.concat(),
                teeth: &design.sub_gear_pairs[k].teeth,
            };
            design.sub_gear_pairs[k].flank_radius =
                band.flattest(&design.section, settings, motion);
        }
    }
    flare::grow(&mut design, motion);
    design.recipe = layout::recipe(&design, motion)?;
    Ok(design)
}

fn tooth_pair(grid: &Grid, j: usize, contacts: &[Contact]) -> ToothPair {
    let stations = contacts
        .iter()
        .enumerate()
        .map(|(i, c)| {
            // Nodes stand at the ends and middles of the integration steps.
            let Node {
                driver, follower, ..
            } = &grid.teeth[j][2 * i];
            let contact = design::Contact {
                phi: c.phi,
                p: c.p,
                n: c.n,
                v: c.t1 + driver.velocity(c.p),
            };
            Station::new(contact, driver, follower)
        })
        .collect();
    let locus: Vec<Vector3<f64>> = contacts.iter().map(|c| c.p).collect();
    let (control_points, fit_error) = spline::fit(&locus, CONTROL_POINTS);
    ToothPair {
        phi_start: contacts[0].phi,
        phi_end: contacts[contacts.len() - 1].phi,
        control_points: control_points.into_iter().map(Into::into).collect(),
        fit_error,
        flare: Default::default(),
        stations,
    }
}

/// Q at the R samples of each of the J subintervals (Eq. 11), counting tooth j within subinterval j.
fn closure(
    motion: &Motion,
    settings: &Settings,
    grid: &Grid,
    traces: &[Vec<Trace>],
) -> Vec<ClosureSample> {
    let (teeth, samples) = (grid.teeth.len(), settings.gear.samples);
    let (class, dof) = (motion.class(), motion.class().dof());
    let pitch = grid.cycle.length() / teeth as f64;
    (0..teeth * samples)
        .map(|i| {
            let (j, r) = (i / samples, i % samples);
            let phi = grid.cycle.start() + (j as f64 + r as f64 / samples as f64) * pitch;
            let centre = motion.joint_centre(phi);
            let measured = |length: f64| -> (f64, f64) {
                let wrenches: Vec<Wrench> = traces
                    .iter()
                    .map(|band| {
                        let (p, n) = at(&band[j], grid, phi);
                        wrench(class, p, n, centre, length)
                    })
                    .collect();
                let mean = wrenches
                    .iter()
                    .map(|w| w.iter().map(|x| x * x).sum::<f64>().sqrt())
                    .sum::<f64>()
                    / wrenches.len() as f64;
                (measure(&wrenches, dof), mean)
            };
            let (q, _) = measured(1.0);
            let (q_star, mean) = measured(0.5 * grid.drive.center_distance());
            ClosureSample {
                phi,
                q,
                q_star,
                eta: dof as f64 * q_star / mean,
            }
        })
        .collect()
}

/// Contact point and normal at `phi`, between the two nearest contacts of the trace.
fn at(trace: &[Contact], grid: &Grid, phi: f64) -> (Vector3<f64>, Vector3<f64>) {
    let step = 2.0 * grid.half_interval / grid.steps as f64;
    let x = ((phi - trace[0].phi) / step).clamp(0.0, grid.steps as f64);
    let i = (x as usize).min(grid.steps - 1);
    let (a, b, f) = (&trace[i], &trace[i + 1], x - i as f64);
    (a.p.lerp(&b.p, f), a.n.lerp(&b.n, f).normalize())
}

/// Largest |n·v_rel(p)| and |n·T²| over all stations, mm/rad. T² is taken from the stations
/// themselves by central differences of sixth order, so that the figure does not rest on the
/// derivatives the construction used. NaN counts as infinite.
pub fn conjugation_residual(design: &Design, motion: &Motion) -> f64 {
    let drive = design.settings.gear.drive();
    let mut worst = 0.0_f64;
    let mut note = |x: f64| {
        worst = if x.is_finite() {
            worst.max(x.abs())
        } else {
            f64::INFINITY
        }
    };
    for tooth in design.sub_gear_pairs.iter().flat_map(|pair| &pair.teeth) {
        let s = &tooth.stations;
        for i in 0..s.len() {
            let (p, n) = (Vector3::from(s[i].p), Vector3::from(s[i].n));
            let follower = motion.state(s[i].phi);
            let driver = drive.state(s[i].phi);
            note(n.dot(&(follower.velocity(p) - driver.velocity(p))));
            if i >= 3 && i + 3 < s.len() {
                let at = |k: usize| Vector3::from(s[k].p);
                let h = s[i + 1].phi - s[i].phi;
                let rate = (45.0 * (at(i + 1) - at(i - 1)) - 9.0 * (at(i + 2) - at(i - 2))
                    + (at(i + 3) - at(i - 3)))
                    / (60.0 * h);
                note(n.dot(&(rate - follower.velocity(p))));
            }
        }
    }
    worst
}
