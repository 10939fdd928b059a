//! Solves a band of the published formulation.

use super::slsqp::{Evaluation, Limits, Program, Report, Start, StopReason, minimise};
use crate::contact::Grid;
use crate::contact::paper_band::{BandModel, BandStart, PaperBand};
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
    /// stopped; the band says how well it conjugates. Neither is an error here: the caller compares
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
                let mut band = BandModel::new(&grid, settings, start, 1).band(&x);
                for tooth in &mut band.teeth {
                    tooth.trace = tooth.trace.iter().step_by(2).copied().collect();
                }
                band
            })),
        }
    }
}

/// Contact stations a tooth.
const STATIONS: usize = 33;
