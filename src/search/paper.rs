//! Solves a band of the published formulation.

use super::slsqp::{Evaluation, Limits, Program, Report, Start, StopReason, minimise};
use crate::contact::paper::ToothModel;
use crate::contact::paper_band::{BandModel, BandStart, PaperBand, PaperTooth};
use crate::contact::{Grid, Node, Trace};
use crate::motion::Motion;
use crate::settings::Settings;
use crate::{Error, Result};

impl Program for BandModel {
    fn variables(&self) -> usize {
        BandModel::variables(self)
    }

    fn constraints(&self) -> usize {
        BandModel::constraints(self)
    }

    fn evaluate(&self, x: &[f64], at: &mut Evaluation) {
        at.value = self.objective(x, &mut at.gradient);
        self.constrain(x, &mut at.constraints, &mut at.jacobian);
    }
}

impl PaperBand {
    /// Solves Eq. 10 for one band of `motion` from `start`.
    ///
    /// The report says whether the constraints hold (`worst_violation`, per L) and why the solver
    /// stopped; the band, finished tooth by tooth where that is possible, says how well it conjugates. Neither is an error here: the caller compares
    /// [`PaperBand::residual_max`] with its tolerance. Contacts are given at 33 stations a
    /// tooth; residuals are taken there and half-way between, where nothing was optimised.
    ///
    /// # Errors
    /// [`Error::Infeasible`] where the start has no finite energy (a tangent vanishes or is parallel
    /// to the reference direction); [`Error::Internal`] for settings no motion file can have and for
    /// a panic inside the objective.
    pub fn solve(
        motion: &Motion,
        settings: &Settings,
        start: &BandStart,
        limits: &Limits,
    ) -> Result<Report<PaperBand>> {
        let gear = &settings.gear;
        if gear.teeth < 3 || gear.locus_control_points < 2 || gear.normal_control_points < 1 {
            return Err(Error::Internal(format!(
                "band of {} teeth, {} locus and {} angle control points",
                gear.teeth, gear.locus_control_points, gear.normal_control_points
            )));
        }
        let grid = Grid::new(motion, gear, STATIONS - 1);
        let model = BandModel::new(&grid, settings, start, 2);
        let [x, lower, upper] = model.start(settings, start);
        let report = minimise(&model, &Start { x, lower, upper }, limits);
        match report.stop {
            StopReason::NotFinite => Err(Error::Infeasible {
                reason: "published formulation degenerates at its start".into(),
                place: format!(
                    "band at z = {:.2} to {:.2} mm",
                    start.z_start,
                    start.z_start + start.travel
                ),
                hint: "start from another segment, or use search.method = \"exact\"".into(),
            }),
            StopReason::Panicked => Err(Error::Internal("band energy panicked".into())),
            _ => Ok(report.map(|x| {
                let fine = BandModel::new(&grid, settings, start, 1);
                let mut band = fine.band(&fine.finish(&x, FINISH));
                for tooth in &mut band.teeth {
                    tooth.trace = tooth.trace.iter().step_by(2).copied().collect();
                }
                band
            })),
        }
    }

    /// Contacts of all teeth at the stations of `grid`, which has to be of the same motion and gear.
    pub fn traces(&self, grid: &Grid) -> Vec<Trace> {
        let trace = |(nodes, tooth): (&Vec<Node>, &PaperTooth)| {
            let control = (tooth.control_points.len(), tooth.angles.len());
            let stations = nodes.iter().step_by(2).copied();
            let points = tooth.control_points.iter().flat_map(|p| [p.x, p.y, p.z]);
            let x: Vec<f64> = points.chain(tooth.angles.iter().copied()).collect();
            ToothModel::new(stations, self.side, 1.0, control).contacts(&x)
        };
        grid.teeth.iter().zip(&self.teeth).map(trace).collect()
    }
}

/// Contact stations a tooth.
const STATIONS: usize = 33;

/// |n·T¹| aimed at where the splines can be conjugate, mm/rad.
const FINISH: f64 = 1e-9;
