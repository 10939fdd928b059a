//! The figures of a design as a table: value, unit and what it means.

use serde::Serialize;

use super::curves::q_unit;
use super::report::ReportInput;
use super::tables;
use crate::bound;
use crate::design::Design;
use crate::load::sensitivity::Sensitivity;
use crate::load::tolerances::{Percentiles, Spread};
use crate::load::{Load, LoadReport, PayloadLimit};
use crate::motion::Class;

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Heading it stands under.
    pub group: &'static str,
    /// Name.
    pub name: String,
    /// Value, rounded for reading.
    pub value: String,
    /// Unit; empty for counts and ratios.
    pub unit: String,
    /// What it says, in plain words.
    pub meaning: &'static str,
}

/// `x` with `digits` significant digits and no exponent for usual sizes.
pub fn rounded(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return if x == f64::INFINITY {
            "unlimited"
        } else {
            "–"
        }
        .into();
    }
    if x == 0.0 {
        return "0".into();
    }
    let magnitude = x.abs().log10().floor() as i32;
    if !(-5..7).contains(&magnitude) {
        return format!("{x:.*e}", digits - 1);
    }
    let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
    format!("{x:.decimals$}")
}

/// Mean, smallest and share of Q over the samples of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosureFigures {
    /// min Q.
    pub q_min: f64,
    /// Mean Q.
    pub q_mean: f64,
    /// min Q*.
    pub q_star_min: f64,
    /// min η.
    pub eta_min: f64,
    /// Share of samples with Q above the threshold (E_validTime).
    pub valid_time: f64,
}

impl ClosureFigures {
    /// Figures of `design`; `None` without samples.
    pub fn of(design: &Design) -> Option<ClosureFigures> {
        let samples = &design.closure;
        let count = samples.len() as f64;
        let threshold = design.settings.gear.closure_threshold;
        let smallest = |get: &dyn Fn(&crate::design::ClosureSample) -> f64| {
            samples.iter().map(get).reduce(f64::min)
        };
        Some(ClosureFigures {
            q_min: smallest(&|c| c.q)?,
            q_star_min: smallest(&|c| c.q_star)?,
            eta_min: smallest(&|c| c.eta)?,
            q_mean: samples.iter().map(|c| c.q).sum::<f64>() / count,
            valid_time: samples.iter().filter(|c| c.q > threshold).count() as f64 / count,
        })
    }
}

/// All figures that `input` has data for.
pub fn all(input: &ReportInput) -> Vec<Figure> {
    let mut figures = Vec::new();
    gear(input.design, &mut figures);
    if let Some(c) = ClosureFigures::of(input.design) {
        let mut add = table(&mut figures, "Grip");
        let unit = q_unit(input.design.class);
        add(
            "Smallest grip, min Q",
            rounded(c.q_min, 4),
            unit,
            "Above zero: the follower is held at every moment.",
        );
        add("Mean grip", rounded(c.q_mean, 4), unit, "");
        add(
            "Smallest grip without units, min Q*",
            rounded(c.q_star_min, 4),
            "",
            "Comparable between sizes and classes.",
        );
        if let Some(bound) = bound::of(input.design, input.motion) {
            add(
                "… at most possible",
                rounded(bound.q, 4),
                unit,
                "For this motion, centre distance and height, whatever the teeth.",
            );
            add("… at most possible, Q*", rounded(bound.q_star, 4), "", "");
        }
        add(
            "Smallest quality, min η",
            rounded(c.eta_min, 3),
            "",
            "1 would be the best possible for these distances.",
        );
        add(
            "Time with a firm grip",
            rounded(100.0 * c.valid_time, 4),
            "%",
            "Has to be 100 %.",
        );
    }
    let settings = &input.design.settings.load;
    figures.extend(input.load.into_iter().flat_map(|l| load(settings, l)));
    let errors = input.sensitivity.into_iter();
    figures.extend(errors.flat_map(|s| assembly_errors(settings, s, input.design.class)));
    sizes(input, &mut figures);
    figures
}

fn sizes(input: &ReportInput, figures: &mut Vec<Figure>) {
    let mut add = table(figures, "Size");
    for part in input.bodies {
        let (low, high) = part.mesh.bounds();
        let size = high - low;
        add(
            &part.name,
            format!("{:.0} × {:.0} × {:.0}", size.x, size.y, size.z),
            "mm",
            "",
        );
        add(
            &format!("{}: volume", part.name),
            rounded(part.mesh.volume() / 1000.0, 3),
            "cm³",
            "",
        );
    }
}

fn table<'a>(
    figures: &'a mut Vec<Figure>,
    group: &'static str,
) -> impl FnMut(&str, String, &str, &'static str) + use<'a> {
    move |name, value, unit, meaning| {
        figures.push(Figure {
            group,
            name: name.into(),
            value,
            unit: unit.into(),
            meaning,
        });
    }
}

fn gear(design: &Design, figures: &mut Vec<Figure>) {
    let gear = &design.settings.gear;
    let mut add = table(figures, "Gear");
    add(
        "Class",
        design.class.to_string(),
        "",
        "R counts turning, T counts sliding directions of the joint.",
    );
    add(
        "Sub-gear pairs, K",
        design.sub_gear_pairs.len().to_string(),
        "",
        "Contacts that hold the follower at the same time.",
    );
    add("Teeth per sub-gear, J", tables::teeth(design), "", "");
    add(
        "Contact ratio",
        rounded(gear.contact_ratio, 3),
        "",
        "Teeth of one pair that touch at once, on average.",
    );
    add(
        "Centre distance, L",
        rounded(gear.center_distance_mm, 4),
        "mm",
        "From the joint to the motor shaft.",
    );
    let pairs = design.sub_gear_pairs.iter();
    let radii = pairs.map(|pair| rounded(design.section_of(pair).flank_radius, 3));
    add(
        "Flank radius",
        radii.collect::<Vec<_>>().join(", "),
        "mm",
        "Of each sub-gear pair: the larger, the more it carries.",
    );
    add(
        "Gap between flanks",
        rounded(design.section.clearance, 3),
        "mm",
        "Left free for printing.",
    );
}

/// Figures of what the mechanism carries.
pub fn load(settings: &Load, load: &LoadReport) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = table(&mut figures, "Load");
    let optional = |x: Option<f64>, digits: usize| x.map_or("–".into(), |x| rounded(x, digits));
    add(
        "Payload",
        rounded(settings.mass_g, 4),
        "g",
        "At the load point of the motion file.",
    );
    add("Largest contact force", rounded(load.force_max, 3), "N", "");
    add(
        "Largest motor torque",
        rounded(load.torque_max, 3),
        "N·mm",
        "Without friction.",
    );
    add(
        "… with friction",
        load.torque_with_friction_max
            .map_or("jams".into(), |x| rounded(x, 3)),
        "N·mm",
        "With the friction coefficient of the motion file.",
    );
    add(
        "Efficiency",
        optional(load.efficiency.map(|e| 100.0 * e), 3),
        "%",
        "Useful work over motor work, while the motor lifts.",
    );
    add(
        "Largest payload",
        rounded(load.payload_max * 1000.0, 3),
        "g",
        match load.payload_limit {
            Some(PayloadLimit::Force) => "Then the first contact reaches the force limit.",
            Some(PayloadLimit::Pressure) => {
                "Then the first contact is short of the pressure that its material bears by the safety."
            }
            Some(PayloadLimit::Patch) => {
                "Then the first contact patch is short of the edge of its flank by the safety."
            }
            Some(PayloadLimit::RootStress) => {
                "Then the first tooth is short of yielding at its root by the safety."
            }
            None => "The weight does not load the contacts.",
        },
    );
    if let Some(tooth) = load.payload_tooth {
        add("… limited at", tooth.to_string(), "", "");
    }
    add(
        "Largest root stress",
        optional(load.root_stress_max_mpa, 3),
        "MPa",
        match load.root_stress_max_mpa {
            Some(stress) if stress > load.root_stress_allowed_mpa => {
                "By finite elements, across layers counted as along them: too much."
            }
            _ => "By finite elements, across layers counted as along them.",
        },
    );
    add(
        "… allowed",
        rounded(load.root_stress_allowed_mpa, 3),
        "MPa",
        "For the material chosen, along its layers.",
    );
    add(
        "Least stiffness of a tooth",
        optional(load.tooth_stiffness_min_n_per_mm, 3),
        "N/mm",
        "Along the contact normal, with its rib.",
    );
    if let Some(tooth) = load.softest_tooth {
        add("… of", tooth.to_string(), "", "");
    }
    add(
        "Load point gives by up to",
        optional(load.deflection_max_mm, 3),
        "mm",
        "Contacts flatten, teeth bend; hubs and frame are rigid.",
    );
    add(
        "Largest contact pressure",
        optional(load.pressure_max, 3),
        "MPa",
        match load.pressure_max {
            Some(pressure) if pressure > load.pressure_allowed => {
                "Hertz pressure of the rounded flanks: too much, they would yield."
            }
            _ => "Hertz pressure of the rounded flanks.",
        },
    );
    add(
        "… allowed",
        rounded(load.pressure_allowed, 3),
        "MPa",
        "For the material chosen, without yielding.",
    );
    add(
        "Largest play of the load point",
        rounded(load.play_point_max, 3),
        "mm",
        "With the motor held.",
    );
    add(
        "… where the load leaves it",
        rounded(load.samples.iter().map(|s| s.sag).fold(0.0, f64::max), 3),
        "mm",
        "Largest distance from the pose without gap.",
    );
    add(
        "Largest play as an angle",
        rounded(load.play_turn_max.to_degrees(), 3),
        "°",
        "",
    );
    drop(add);
    figures
}

/// Figures of what assembly errors do.
pub fn assembly_errors(settings: &Load, s: &Sensitivity, class: Class) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = table(&mut figures, "Assembly errors");
    add(
        "Errors allowed",
        format!(
            "{} mm, {}°, {} %",
            settings.center_distance_error_mm,
            settings.axis_tilt_error_deg,
            settings.scale_error_percent
        ),
        "",
        "Centre distance, axis tilt, scale.",
    );
    let unit = q_unit(class);
    add(
        "Smallest grip then",
        rounded(s.by_sampling.q_min, 4),
        unit,
        "Worst of many errors within these.",
    );
    add(
        "… by derivatives",
        rounded(s.by_derivative.q_min, 4),
        unit,
        "All errors at their worst sign at once.",
    );
    add(
        "Load point moves by up to",
        rounded(s.by_sampling.point, 3),
        "mm",
        "",
    );
    add(
        "Follower turns by up to",
        rounded(s.by_sampling.turn.to_degrees(), 3),
        "°",
        "",
    );
    add(
        "Gap lost at a contact",
        rounded(s.by_sampling.interference, 3),
        "mm",
        "More than the gap between flanks would jam.",
    );
    drop(add);
    figures
}

/// How gears come out that are made within the tolerances.
pub fn tolerances(spread: &Spread) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = table(&mut figures, "Tolerances");
    let percent = |share: f64| rounded(100.0 * share, 3);
    let range = |p: Option<Percentiles>| {
        p.map_or("–".into(), |p| {
            [p.p5, p.p50, p.p95].map(|x| rounded(x, 3)).join(" / ")
        })
    };
    const RANGE: &str = "5th percentile, median, 95th.";
    add(
        "Gears drawn",
        spread.draws.to_string(),
        "",
        "With errors at random within the tolerances.",
    );
    add("Works", percent(spread.works), "%", "Of them.");
    add(
        "Jams",
        percent(spread.jams),
        "%",
        "No gap left at a contact.",
    );
    add(
        "Not held",
        percent(spread.loose),
        "%",
        "The follower is not form closed somewhere.",
    );
    add(
        "Too much play",
        percent(spread.too_much_play),
        "%",
        "Beyond fit.max_play_mm or fit.max_play_deg.",
    );
    add("Play of the load point", range(spread.play_mm), "mm", RANGE);
    add("Play as an angle", range(spread.play_deg), "°", RANGE);
    add("Smallest grip", range(spread.q_min), "", RANGE);
    drop(add);
    figures
}
