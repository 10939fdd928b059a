//! Several designs on one page: their grip over φ in one diagram, their figures in one table.

use std::path::Path;

use minijinja::context;
use minijinja::value::Serde;

use super::curves::{PAIR_COLORS, Plot, Series};
use super::report::{render, script_json};
use crate::Result;
use crate::design::ClosureSample;
use crate::disk::write_whole;
use crate::stats::{Entry, table};

/// Angles of the common axis, deg.
const STEPS: usize = 360;

/// Writes the comparison of `entries` to `path`; the file appears whole or not at all.
///
/// # Errors
/// [`crate::Error::Io`] when the file cannot be written, [`crate::Error::Internal`] when the
/// template fails.
pub fn write(entries: &[Entry], path: &Path) -> Result<()> {
    write_whole(path, html(entries)?.as_bytes())
}

/// The comparison as text.
///
/// # Errors
/// [`crate::Error::Internal`] when the template fails.
pub fn html(entries: &[Entry]) -> Result<String> {
    let plots = plots(entries);
    let heads: Vec<_> = plots
        .iter()
        .map(|p| context! { id => p.id, title => p.title, hint => p.hint, unit => p.unit })
        .collect();
    let table = table(entries);
    render(
        "compare.html",
        context! {
            designs => names(entries),
            plots => heads,
            columns => table.columns,
            rows => minijinja::Value::from(Serde(table.rows)),
            data => script_json(&plots)?,
        },
    )
}

/// Names to tell the designs apart: of equal names, the folder is added.
fn names(entries: &[Entry]) -> Vec<String> {
    let name = |e: &Entry| e.design.name.clone();
    entries
        .iter()
        .map(|e| {
            let same = entries
                .iter()
                .filter(|other| name(other) == name(e))
                .count();
            if same > 1 {
                format!("{} ({})", name(e), e.path.display())
            } else {
                name(e)
            }
        })
        .collect()
}

/// Q, Q* and η of all designs over φ.
pub fn plots(entries: &[Entry]) -> Vec<Plot> {
    let names = names(entries);
    let plot = |id, (title, hint, unit), get: fn(&ClosureSample) -> f64| Plot {
        id,
        title,
        hint,
        unit,
        phi_deg: (0..=STEPS)
            .map(|i| i as f64 * 360.0 / STEPS as f64)
            .collect(),
        series: entries
            .iter()
            .zip(&names)
            .enumerate()
            .map(|(i, (entry, name))| Series {
                label: name.clone(),
                color: PAIR_COLORS[i % PAIR_COLORS.len()],
                values: (0..=STEPS)
                    .map(|step| {
                        at(
                            &entry.design.closure,
                            step as f64 * 360.0 / STEPS as f64,
                            get,
                        )
                    })
                    .collect(),
            })
            .collect(),
        from_zero: true,
    };
    vec![
        plot(
            "q",
            ("Grip Q(φ)", "As published, in the units of each class.", ""),
            |c| c.q,
        ),
        plot(
            "q_star",
            (
                "Grip without units, Q*(φ)",
                "Moments divided by half the centre distance.",
                "",
            ),
            |c| c.q_star,
        ),
        plot(
            "eta",
            (
                "Grip quality η(φ)",
                "Compared with the best possible for these distances.",
                "",
            ),
            |c| c.eta,
        ),
    ]
}

/// Value at `degrees`, linear between samples; `None` outside of a driver range below one turn.
fn at(samples: &[ClosureSample], degrees: f64, get: fn(&ClosureSample) -> f64) -> Option<f64> {
    let (first, last) = (samples.first()?, samples.last()?);
    let phi = degrees.to_radians();
    let after = samples.partition_point(|s| s.phi <= phi);
    let (a, b, from, to) = match after {
        // Between the last sample of a turn and the first of the next.
        0 => (last, first, last.phi - std::f64::consts::TAU, first.phi),
        n if n == samples.len() => (last, first, last.phi, first.phi + std::f64::consts::TAU),
        n => (
            &samples[n - 1],
            &samples[n],
            samples[n - 1].phi,
            samples[n].phi,
        ),
    };
    let widest = 3.0 * (last.phi - first.phi) / samples.len() as f64;
    if to - from > widest {
        return None;
    }
    let t = if to > from {
        (phi - from) / (to - from)
    } else {
        0.0
    };
    let value = get(a) * (1.0 - t) + get(b) * t;
    value.is_finite().then_some(value)
}
