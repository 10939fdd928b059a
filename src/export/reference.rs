//! A mechanism beside the standard pair of spur gears for the same ratio and centre distance.

use nalgebra::Vector3;
use serde::Serialize;

use super::figures::rounded;
use super::{File, stl};
use crate::design::Design;
use crate::involute::strength::{self, Stress};
use crate::involute::{Pair, body};
use crate::load::{ExtraLoad, Load, Sampling, analyse};
use crate::motion::survey::survey;
use crate::motion::{Class, Motion};
use crate::table::{Format, Table};
use crate::{Error, Problem, Result};

/// Torque on the follower under which both are compared, N·mm.
pub const TORQUE: f64 = 100.0;

/// A ratio is constant where the follower leads or lags by at most this, deg.
const EVEN_DEG: f64 = 0.5;

/// A mechanism's figures under the same torque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Own {
    /// Largest contact force, N.
    pub force: f64,
    /// Largest pressure, MPa; `None` where flanks form no point contact.
    pub pressure: Option<f64>,
    /// Largest stress at the root, MPa.
    pub root: Option<f64>,
    /// Work that goes on, as a share of what comes in.
    pub efficiency: Option<f64>,
    /// How many tooth pairs of a band touch on average.
    pub contact_ratio: f64,
    /// Largest distance across the gears, mm.
    pub length: f64,
    /// From the lowest to the highest contact, mm.
    pub height: f64,
}

/// Both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// The standard pair.
    pub pair: Pair,
    /// Its stress.
    pub stress: Stress,
    /// The mechanism's.
    pub own: Own,
}

/// The standard pair with the centre distance and ratio of a design, as wide as its teeth are high, with its
/// clearance as backlash.
///
/// # Errors
/// [`Error::Input`] for designs that are no 1R gear at a constant ratio, or whose size no module fits.
pub fn of(design: &Design, motion: &Motion) -> Result<Reference> {
    let gear = &design.settings.gear;
    let length = gear.center_distance_mm;
    let lead = survey(motion, length, Vector3::zeros()).lead_max_deg;
    let turns_on = motion.cycle().wraps();
    if design.class != Class::R1 || !turns_on || lead > EVEN_DEG {
        let what = format!(
            "`{}` is a {} gear whose follower leads or lags by up to {lead:.1}°; spur gears turn at a constant ratio (1R, 0°)",
            design.name, design.class
        );
        let hint = "compare a design of examples/uniform_1r.toml, for example";
        let problem = Problem::new("--with involute", what, hint);
        return Err(Error::input("command line", vec![problem]));
    }
    let own = own(design, motion)?;
    let width = (own.height, design.section.clearance);
    let pair = Pair::standard(length, gear.drive().copies(), width)?;
    let load = &design.settings.load;
    let materials = [load.driver_material, load.follower_material];
    Ok(Reference {
        pair,
        stress: strength::stress(&pair, TORQUE, materials, load.friction),
        own,
    })
}

fn own(design: &Design, motion: &Motion) -> Result<Own> {
    let torque = ExtraLoad {
        torque_nmm: [0.0, 0.0, TORQUE],
        ..ExtraLoad::default()
    };
    let load = Load {
        mass_g: 0.0,
        extra: vec![torque],
        ..design.settings.load.clone()
    };
    let report = analyse(design, motion, &load, Sampling::of(motion))?;
    let contacts = || report.samples.iter().flat_map(|s| &s.contacts);
    let pressure = contacts()
        .map(|c| c.pressure)
        .try_fold(0.0, |most: f64, p| Some(most.max(p?)));
    let stations = || {
        let teeth = design.sub_gear_pairs.iter().flat_map(|pair| &pair.teeth);
        teeth.flat_map(|tooth| &tooth.stations)
    };
    let bounds = |value: fn(&[f64; 3]) -> f64| {
        stations().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
            (low.min(value(&s.p)), high.max(value(&s.p)))
        })
    };
    let (low, high) = bounds(|p| p[2]);
    let length = design.settings.gear.center_distance_mm;
    let (_, follower) = bounds(|p| p[0].hypot(p[1]));
    let driver = stations().map(|s| (s.p[0] + length).hypot(s.p[1]));
    Ok(Own {
        force: report.force_max,
        pressure,
        root: report.root_stress_max_mpa,
        efficiency: report.efficiency,
        contact_ratio: design.settings.gear.contact_ratio,
        length: length + follower + driver.fold(0.0, f64::max),
        height: high - low,
    })
}

/// Both side by side.
pub fn table(name: &str, reference: &Reference) -> Table {
    let Reference { pair, stress, own } = reference;
    let number = |x: f64| rounded(x, 3);
    let maybe = |x: Option<f64>| x.map_or("–".into(), number);
    let [driver, follower] = pair.wheels;
    let row = |name: &str, own: String, standard: String| vec![name.into(), own, standard];
    Table {
        columns: vec!["figure".into(), name.into(), "involute".into()],
        names: 1,
        rows: vec![
            row(
                "centre distance, mm",
                number(pair.center_distance),
                number(pair.center_distance),
            ),
            row("module, mm", "–".into(), number(pair.module)),
            row("teeth of the driver", "–".into(), driver.teeth.to_string()),
            row(
                "teeth of the follower",
                "–".into(),
                follower.teeth.to_string(),
            ),
            row("profile shift", "–".into(), number(driver.shift)),
            row(
                "height or face width, mm",
                number(own.height),
                number(pair.face_width),
            ),
            row(
                "length across both, mm",
                number(own.length),
                number(pair.length()),
            ),
            row(
                "contact ratio",
                number(own.contact_ratio),
                number(pair.contact_ratio()),
            ),
            row("contact force, N", number(own.force), number(stress.force)),
            row(
                "contact pressure, MPa",
                maybe(own.pressure),
                number(stress.pressure),
            ),
            row("root stress, MPa", maybe(own.root), number(stress.root)),
            row(
                "efficiency",
                maybe(own.efficiency),
                number(stress.efficiency),
            ),
        ],
    }
}

/// The table, and both gears of the standard pair in place: the follower's axis is z.
///
/// # Errors
/// [`Error::Internal`] when an encoder fails.
pub fn files(pair: &Pair, table: &Table) -> Result<[File; 3]> {
    let mesh = |i: usize| stl::binary(&body::mesh(pair, i));
    Ok([
        File::new("involute.csv", table.render(Format::Csv)?),
        File::new("driver.stl", mesh(0)?),
        File::new("follower.stl", mesh(1)?),
    ])
}
