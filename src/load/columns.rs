//! Load figures as a table over the driver angle.

use super::{ContactLoad, LoadReport, LoadSample};
use crate::table::Table;

impl LoadReport {
    /// One row per sample, or per `every` samples: angle, contact forces and pressures, root
    /// stresses, torques, largest payload, play, deflection. A dash stands where there is none (jammed, unlimited, no point contact).
    pub fn table(&self, every: usize) -> Table {
        let pairs = self.samples.first().map_or(0, |s| s.contacts.len());
        let numbered = |what: &str, unit: &str| -> Vec<String> {
            (1..=pairs).map(|k| format!("{what}{k} {unit}")).collect()
        };
        let fixed = |names: &[&str]| names.iter().map(|&n| n.to_owned()).collect::<Vec<_>>();
        let columns = [
            fixed(&["phi deg"]),
            numbered("tooth", "")
                .iter()
                .map(|n| n.trim().into())
                .collect(),
            numbered("force", "N"),
            numbered("pressure", "MPa"),
            numbered("root", "MPa"),
            fixed(&[
                "torque Nmm",
                "with friction Nmm",
                "payload g",
                "play deg",
                "play mm",
                "sag mm",
                "deflection mm",
            ]),
        ];
        Table {
            columns: columns.concat(),
            names: 0,
            rows: self.samples.iter().step_by(every.max(1)).map(row).collect(),
        }
    }
}

fn row(s: &LoadSample) -> Vec<String> {
    let number = |x: Option<f64>, decimals: usize| {
        let unit = 10_f64.powi(decimals as i32);
        // + 0.0 turns −0 into 0.
        let rounded = x.map(|x| (x * unit).round() / unit + 0.0);
        let finite = rounded.filter(|x| x.is_finite());
        finite.map_or("–".into(), |x| format!("{x:.decimals$}"))
    };
    let mut cells = vec![number(Some(s.phi.to_degrees()), 1)];
    cells.extend(s.contacts.iter().map(|c| (c.tooth + 1).to_string()));
    cells.extend(s.contacts.iter().map(|c| number(Some(c.force), 3)));
    cells.extend(s.contacts.iter().map(|c| number(c.pressure, 2)));
    let root = |c: &ContactLoad| c.root_stress.map(|both| f64::max(both[0], both[1]));
    cells.extend(s.contacts.iter().map(|c| number(root(c), 2)));
    cells.extend([
        number(Some(s.torque), 2),
        number(s.torque_with_friction, 2),
        number(s.payload.map(|kg| 1000.0 * kg), 0),
        number(Some(s.play_turn.to_degrees()), 3),
        number(Some(s.play_point), 3),
        number(Some(s.sag), 3),
        number(s.deflection, 3),
    ]);
    cells
}
