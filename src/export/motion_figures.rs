//! What a motion is like: its figures in words, and its course as a table.

use super::figures::{Figure, rounded};
use crate::motion::survey::{Sample, Survey};
use crate::table::Table;

type Column = (&'static str, fn(&Sample) -> f64);

/// Columns of the course; the point is that where the load acts.
const COURSE: [Column; 10] = [
    ("phi_deg", |s| s.phi_deg),
    ("x_mm", |s| s.point_mm[0]),
    ("y_mm", |s| s.point_mm[1]),
    ("z_mm", |s| s.point_mm[2]),
    ("tilt_deg", |s| s.tilt_deg),
    ("turn_deg", |s| s.turn_deg),
    ("slide_mm", |s| s.slide_mm),
    ("turn_speed", |s| s.turn_speed),
    ("slide_speed_mm_rad", |s| s.slide_speed_mm_rad),
    ("sharpness_mm_rad2", |s| s.sharpness_mm_rad2),
];

/// The samples of a survey, a row each.
pub fn course(survey: &Survey) -> Table {
    // Below the sixth decimal there is round-off only.
    let cell = |x: f64| format!("{:.6}", if x.abs() < 5e-7 { 0.0 } else { x });
    let row = |s: &Sample| COURSE.iter().map(|(_, value)| cell(value(s))).collect();
    Table {
        columns: COURSE.iter().map(|(name, _)| (*name).into()).collect(),
        names: 0,
        rows: survey.samples.iter().map(row).collect(),
    }
}

/// The figures of a survey.
pub fn figures(survey: &Survey) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = |name: &str, value: String, unit: &str, meaning: &'static str| {
        figures.push(Figure {
            group: "Motion",
            name: name.into(),
            value,
            unit: unit.into(),
            meaning,
        });
    };
    let number = |x: f64| {
        if x.abs() < 1e-9 {
            "0".into()
        } else {
            rounded(x, 4)
        }
    };
    let sharp = &survey.sharpness;
    add("Class of the file", survey.class.to_string(), "", "");
    let meaning = if survey.least_class == survey.class {
        "The motion needs the class it has."
    } else {
        "A simpler joint does for this motion; it needs fewer bands."
    };
    add("Least class", survey.least_class.to_string(), "", meaning);
    add(
        "Net turn",
        number(survey.net_turns),
        "turns",
        "Of the follower, per turn of the driver.",
    );
    add(
        "Largest tilt",
        number(survey.tilt_max_deg),
        "°",
        "Of the follower's axis against z.",
    );
    add(
        "Largest lead or lag",
        number(survey.lead_max_deg),
        "°",
        "Of its own turn against a uniform gear, which turns by −φ.",
    );
    let [low, high] = survey.slide_mm.map(number);
    add(
        "Slide",
        format!("{low} to {high}"),
        "mm",
        "Of the joint's centre along z.",
    );
    add(
        "Largest turning speed",
        number(survey.turn_speed_max),
        "",
        "In turning speeds of the driver.",
    );
    add(
        "Largest slide speed",
        number(survey.slide_speed_max_mm_rad),
        "mm/rad",
        "Per radian of the driver.",
    );
    add(
        "Path of the load point",
        number(survey.path_mm),
        "mm",
        "Its length, per turn of the driver.",
    );
    add(
        "Sharpness",
        format!("{:.1}", sharp.most_mm_rad2),
        "mm/rad²",
        "How fast the motion changes at most, at the pitch radius.",
    );
    add("… sharpest at φ", format!("{:.0}", sharp.phi_deg), "°", "");
    add(
        "… compared",
        sharp.verdict().into(),
        "",
        "A guide from designed examples; designing tells.",
    );
    add(
        "… usually works up to",
        number(sharp.usual_mm_rad2),
        "mm/rad²",
        "",
    );
    add(
        "… rarely works above",
        number(sharp.rare_mm_rad2),
        "mm/rad²",
        "",
    );
    figures
}
