//! Figures of a design by which explorations compare: what it carries, how loose it is, how large and heavy.

use nalgebra::Vector3;
use std::collections::BTreeMap;

use crate::design::Design;
use crate::export::tables::Summary;
use crate::load::{self, LoadReport, Material, Sampling};
use crate::motion::Motion;
use crate::pipeline::Outcome;
use crate::solid::Solids;

/// One figure that studies may ask for.
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// Its name in study files and records.
    pub name: &'static str,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

/// All of them. `null` where a figure does not exist: no torque where friction jams, no bodies, no weight.
#[rustfmt::skip]
pub const MEASURES: [Measure; 23] = [
    measure("q_min", "", "least hold over the period"),
    measure("q_star_min", "", "the same with moments divided by L/2: compares between sizes and classes"),
    measure("eta_min", "", "least quality of the hold"),
    measure("bands", "", "sub-gear pairs K"),
    measure("payload_g", "g", "largest payload at the load point; 1,000,000 where weight does not load the contacts"),
    measure("force_n", "N", "largest contact force under the payload of the motion file"),
    measure("pressure_mpa", "MPa", "largest contact pressure under it"),
    measure("torque_nmm", "N·mm", "largest driver torque under it, with friction"),
    measure("efficiency", "", "work done against the load per work of the driver"),
    measure("play_mm", "mm", "largest play of the load point in the flank gaps"),
    measure("play_deg", "deg", "largest play of the follower as an angle"),
    measure("sag_mm", "mm", "largest displacement of the load point within the play, where the load leaves it"),
    measure("deflection_mm", "mm", "largest displacement of the load point as contacts flatten and teeth bend"),
    measure("root_stress_mpa", "MPa", "largest stress at the root of a tooth under the payload of the motion file"),
    measure("tooth_stiffness_n_per_mm", "N/mm", "least stiffness of a tooth along the contact normal"),
    measure("width_mm", "mm", "room along x over a whole turn"),
    measure("depth_mm", "mm", "room along y"),
    measure("height_mm", "mm", "room along z"),
    measure("box_cm3", "cm³", "the three multiplied"),
    measure("plastic_cm3", "cm³", "volume of all pieces to print"),
    measure("plastic_g", "g", "their mass when solid; frame and slider as the driver's material"),
    measure("print_h", "h", "estimate of the printing time"),
    measure("wall_min_mm", "mm", "thinnest wall found by the proof"),
];

const fn measure(name: &'static str, unit: &'static str, meaning: &'static str) -> Measure {
    Measure {
        name,
        unit,
        meaning,
    }
}

/// Payload that stands for one without limit, g.
pub const UNLIMITED_G: f64 = 1e6;

/// Plastic that an ordinary printer lays down, mm³/s, and what each layer costs beside it, s.
const FLOW: f64 = 8.0;
const LAYER_S: f64 = 4.0;
/// Layer height, mm.
const LAYER: f64 = 0.2;

/// Angles at which the room is taken.
const PHASES: usize = 24;

/// Figures by name.
pub type Figures = BTreeMap<&'static str, Option<f64>>;

/// The figures of what was made, with those of its summary.
pub fn figures(outcome: &Outcome, motion: &Motion, summary: &Summary) -> Figures {
    let Outcome {
        design,
        solids,
        check,
        ..
    } = outcome;
    let mut figures: Figures = MEASURES.iter().map(|m| (m.name, None)).collect();
    figures.extend([
        ("q_min", summary.q_min),
        ("q_star_min", summary.q_star_min),
        ("eta_min", summary.eta_min),
        ("bands", Some(summary.k as f64)),
        ("wall_min_mm", summary.wall_min_mm),
    ]);
    let load = &design.settings.load;
    let known = check.as_ref().and_then(|check| check.load.clone());
    let report = known.map_or_else(
        || load::analyse(design, motion, load, Sampling::of(motion)),
        Ok,
    );
    if let Ok(report) = report {
        figures.extend(loaded(&report));
    }
    if let Some(solids) = solids {
        figures.extend(room(design, motion, solids));
        figures.extend(print(
            solids,
            [load.driver_material, load.follower_material],
        ));
    }
    // What is no number is no figure.
    for figure in figures.values_mut() {
        *figure = figure.filter(|value| value.is_finite());
    }
    figures
}

fn loaded(report: &LoadReport) -> Figures {
    let grams = 1000.0 * report.payload_max;
    let sag = report.samples.iter().map(|s| s.sag).fold(0.0, f64::max);
    Figures::from([
        ("payload_g", Some(grams.min(UNLIMITED_G))),
        ("force_n", Some(report.force_max)),
        ("pressure_mpa", report.pressure_max),
        ("torque_nmm", report.torque_with_friction_max),
        ("efficiency", report.efficiency),
        ("play_mm", Some(report.play_point_max)),
        ("play_deg", Some(report.play_turn_max.to_degrees())),
        ("sag_mm", Some(sag)),
        ("deflection_mm", report.deflection_max_mm),
        ("root_stress_mpa", report.root_stress_max_mpa),
        (
            "tooth_stiffness_n_per_mm",
            report.tooth_stiffness_min_n_per_mm,
        ),
    ])
}

/// The box around all bodies at all angles.
fn room(design: &Design, motion: &Motion, solids: &Solids) -> Figures {
    let drive = design.settings.gear.drive();
    let (mut low, mut high) = (
        Vector3::repeat(f64::INFINITY),
        Vector3::repeat(f64::NEG_INFINITY),
    );
    for body in &solids.bodies {
        let phases = PHASES * drive.copies();
        for i in 0..phases {
            let phi = motion.cycle().part(i, PHASES);
            let (a, b) = body
                .mesh
                .moved(&body.carrier.pose(motion, drive, phi))
                .bounds();
            (low, high) = (low.inf(&a), high.sup(&b));
        }
    }
    let size = high - low;
    Figures::from([
        ("width_mm", Some(size.x)),
        ("depth_mm", Some(size.y)),
        ("height_mm", Some(size.z)),
        ("box_cm3", Some(1e-3 * size.x * size.y * size.z)),
    ])
}

/// What printing takes: volume by the flow of the nozzle, one change of layer for all pieces on one bed.
fn print(solids: &Solids, [driver, follower]: [Material; 2]) -> Figures {
    let (mut volume, mut mass, mut height) = (0.0, 0.0, 0.0);
    for piece in &solids.pieces {
        let material = if piece.body == "follower" {
            follower
        } else {
            driver
        };
        let all = piece.mesh.volume() * f64::from(piece.count);
        volume += all;
        // kg/m³ are µg/mm³.
        mass += 1e-6 * all * material.density();
        let (low, high) = piece.mesh.bounds();
        height = f64::max(height, high.z - low.z);
    }
    let seconds = volume / FLOW + (height / LAYER).ceil() * LAYER_S;
    Figures::from([
        ("plastic_cm3", Some(1e-3 * volume)),
        ("plastic_g", Some(mass)),
        ("print_h", Some(seconds / 3600.0)),
    ])
}
