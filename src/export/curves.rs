//! The curves over φ that reports and pictures show.

use serde::Serialize;

use super::report::ReportInput;
use crate::motion::Class;

/// Colours of the sub-gear pairs, repeated beyond eight.
pub const PAIR_COLORS: [&str; 8] = [
    "#d1495b", "#1b7f79", "#6a4c93", "#b7791f", "#2b6cb0", "#718355", "#c05299", "#4a5568",
];
const MAIN: &str = "#2b6cb0";
const SECOND: &str = "#d1495b";

/// One diagram over the driver angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plot {
    /// Identifier, also the file name of its picture.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What it means, for readers new to it.
    pub hint: &'static str,
    /// Unit of the values.
    pub unit: &'static str,
    /// Driver angles, deg.
    pub phi_deg: Vec<f64>,
    /// Curves.
    pub series: Vec<Series>,
    /// Whether the value 0 has a meaning and has to be in view.
    pub from_zero: bool,
}

/// One curve of a diagram.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// CSS colour.
    pub color: &'static str,
    /// One value per angle; `None` where there is none.
    pub values: Vec<Option<f64>>,
}

impl Plot {
    /// Ends a curve over a whole turn where it began.
    fn close(&mut self) {
        if let Some(first) = self.phi_deg.first().copied() {
            self.phi_deg.push(first + 360.0);
            for series in &mut self.series {
                series.values.push(series.values[0]);
            }
        }
    }
}

impl Series {
    fn new(
        label: impl Into<String>,
        color: &'static str,
        values: impl Iterator<Item = f64>,
    ) -> Series {
        Series {
            label: label.into(),
            color,
            values: values.map(|v| v.is_finite().then_some(v)).collect(),
        }
    }
}

/// Unit of Q in a class.
pub fn q_unit(class: Class) -> &'static str {
    if class.slides() {
        "mm and 1 mixed"
    } else {
        "mm"
    }
}

/// All diagrams that `input` has data for.
pub fn plots(input: &ReportInput) -> Vec<Plot> {
    let mut plots = Vec::new();
    let closure = &input.design.closure;
    if !closure.is_empty() {
        let phi_deg: Vec<f64> = closure.iter().map(|c| c.phi.to_degrees()).collect();
        plots.push(Plot {
            id: "q",
            title: "Grip Q(φ)",
            hint: "How firmly the teeth hold the follower. As long as the curve stays above zero, \
                   the follower cannot move by itself in any direction.",
            unit: q_unit(input.design.class),
            phi_deg: phi_deg.clone(),
            series: vec![Series::new("Q", MAIN, closure.iter().map(|c| c.q))],
            from_zero: true,
        });
        plots.push(Plot {
            id: "eta",
            title: "Grip quality η(φ)",
            hint: "The grip compared with the best that contacts at these distances could ever reach; 1 is perfect.",
            unit: "",
            phi_deg,
            series: vec![Series::new("η", "#1b7f79", closure.iter().map(|c| c.eta))],
            from_zero: true,
        });
    }
    if let Some(load) = input.load {
        let samples = &load.samples;
        let phi_deg: Vec<f64> = samples.iter().map(|s| s.phi.to_degrees()).collect();
        let per_pair = |get: &dyn Fn(&crate::load::ContactLoad) -> f64| -> Vec<Series> {
            let count = samples.first().map_or(0, |s| s.contacts.len());
            (0..count)
                .map(|k| {
                    let values = samples.iter().map(|s| get(&s.contacts[k]));
                    Series::new(format!("pair {}", k + 1), PAIR_COLORS[k % 8], values)
                })
                .collect()
        };
        let mut add = |id, title, hint, unit, series: Vec<Series>| {
            plots.push(Plot {
                id,
                title,
                hint,
                unit,
                phi_deg: phi_deg.clone(),
                series,
                from_zero: true,
            });
        };
        add(
            "force",
            "Contact forces",
            "What each pair of touching teeth presses with, under the load given in the motion file.",
            "N",
            per_pair(&|c| c.force),
        );
        add(
            "torque",
            "Torque on the motor shaft",
            "What the motor has to give; negative where the load drives the motor.",
            "N·mm",
            vec![
                Series::new("without friction", MAIN, samples.iter().map(|s| s.torque)),
                Series::new(
                    "with friction",
                    SECOND,
                    samples
                        .iter()
                        .map(|s| s.torque_with_friction.unwrap_or(f64::NAN)),
                ),
            ],
        );
        add(
            "pressure",
            "Contact pressure",
            "Largest pressure where the rounded flanks of two teeth touch (Hertz).",
            "MPa",
            per_pair(&|c| c.pressure.unwrap_or(f64::NAN)),
        );
        add(
            "root",
            "Stress at the roots of the teeth",
            "Of the driver's or the follower's tooth, whichever is larger (finite elements).",
            "MPa",
            per_pair(&|c| c.root_stress.map_or(f64::NAN, |both| both[0].max(both[1]))),
        );
        add(
            "play",
            "Play at the load point",
            "How far the end-effector can be wiggled with the motor held, because the teeth are built with a small gap.",
            "mm",
            vec![
                Series::new("free play", MAIN, samples.iter().map(|s| s.play_point)),
                Series::new("sag under load", SECOND, samples.iter().map(|s| s.sag)),
            ],
        );
        add(
            "play_turn",
            "Play as an angle",
            "The largest angle that the follower can be turned by in that gap.",
            "°",
            vec![Series::new(
                "free turn",
                "#6a4c93",
                samples.iter().map(|s| s.play_turn.to_degrees()),
            )],
        );
    }
    if input.sampling.is_whole_turn() {
        plots.iter_mut().for_each(Plot::close);
    }
    plots
}
