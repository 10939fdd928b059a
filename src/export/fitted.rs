//! A fitted motion: its motion file with the table beside it, and what fitting changed in words.

use super::File;
use super::figures::{Figure, rounded};
use crate::escape;
use crate::motion::fit::{Deviation, Fit, Report};
use crate::{Error, Result};

/// Name of the fitted motion, of its files without ending, and of the file with the poses.
#[derive(Debug, Clone, Copy)]
pub struct Names<'a> {
    /// Of the motion and, with `.toml` and `.csv`, its files.
    pub stem: &'a str,
    /// Of the file that the poses came from.
    pub poses: &'a str,
}

/// The motion file and the table that it refers to.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails.
pub fn files(fit: &Fit, names: Names) -> Result<[File; 2]> {
    let table = format!("{}.csv", names.stem);
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let report = &fit.report;
    let text = format!(
        "# Fitted to the poses of {poses} by mpcgear motion fit --tolerance {tolerance}:\n\
         # {harmonics} harmonics, {apart} off at most, {left} of {rows} poses left out.\n\
         # Settings follow below [motion]; `mpcgear new` writes a file with all of them.\n\
         name = {name}\n\
         class = \"{class}\"\n\
         \n\
         [motion]\n\
         kind = \"table\"\n\
         file = {file}\n",
        poses = escape::comment(names.poses),
        tolerance = report.tolerance,
        harmonics = report.harmonics,
        apart = pair(report.largest),
        left = report.outliers.len(),
        rows = report.rows,
        name = quoted(names.stem),
        class = report.class,
        file = quoted(&table),
    );
    Ok([
        File::new(format!("{}.toml", names.stem), text),
        File::new(table, csv(fit)?),
    ])
}

fn csv(fit: &Fit) -> Result<Vec<u8>> {
    let failed = |e: String| Error::Internal(format!("fitted table: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = writer.write_record(crate::motion::TABLE_COLUMNS);
    header.map_err(|e| failed(e.to_string()))?;
    for row in &fit.table.rows {
        writer.serialize(row).map_err(|e| failed(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| failed(e.to_string()))
}

/// What was changed.
pub fn figures(report: &Report) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = |name: &str, value: String, unit: &str, meaning: &'static str| {
        figures.push(Figure {
            group: "Fit",
            name: name.into(),
            value,
            unit: unit.into(),
            meaning,
        });
    };
    add("Class", report.class.to_string(), "", "");
    add("Poses", report.rows.to_string(), "", "");
    add(
        "Harmonics",
        report.harmonics.to_string(),
        "",
        "Highest multiple of φ in the motion.",
    );
    let number = |x: f64| rounded(x, 3);
    add("Largest deviation", number(report.largest.mm), "mm", "");
    add("", number(report.largest.deg), "°", "");
    add("… of line", report.largest_line.to_string(), "", "");
    add("RMS deviation", number(report.rms.mm), "mm", "");
    add("", number(report.rms.deg), "°", "");
    if let Some(gap) = report.closing_gap {
        add("Gap that is closed", number(gap.mm), "mm", "");
        add("", number(gap.deg), "°", "Of the last pose to the first.");
    }
    if report.drift_removed {
        let meaning = "An even drift along the poses was taken off.";
        add("Drift", "removed".into(), "", meaning);
    }
    let meaning = "Poses that were left out.";
    add("Outliers", report.outliers.len().to_string(), "", meaning);
    for outlier in &report.outliers {
        let value = format!("φ = {:.1}°", outlier.phi_deg);
        let name = format!("… line {}", outlier.line);
        add(&name, value, "", "");
        add("… off by", number(outlier.deviation.mm), "mm", "");
        add("", number(outlier.deviation.deg), "°", "");
    }
    let before = report.sharpness_before.map_or("–".into(), |s| {
        format!("{:.1} at {:.0}°", s.most_mm_rad2, s.phi_deg)
    });
    let after = &report.sharpness_after;
    add(
        "Sharpness before",
        before,
        "mm/rad²",
        "Of a curve through all poses.",
    );
    add(
        "Sharpness after",
        format!("{:.1} at {:.0}°", after.most_mm_rad2, after.phi_deg),
        "mm/rad²",
        after.verdict(),
    );
    figures
}

fn pair(deviation: Deviation) -> String {
    format!(
        "{} mm and {}°",
        rounded(deviation.mm, 3),
        rounded(deviation.deg, 3)
    )
}
