//! What the mechanism carries: contact forces, driver torque, payload, efficiency, contact stress,
//! root stress, deflection, play and sensitivity to assembly errors.
//!
//! Quasi-static, first order in gaps and errors. The pin or ball of the joint takes what lies
//! outside span(U) and is taken as free of friction.

mod columns;
pub mod contacts;
pub mod efficiency;
pub mod forces;
pub mod hertz;
mod material;
mod payload;
pub mod play;
pub mod sensitivity;
mod settings;
pub mod tolerances;
pub mod wrench;

use std::f64::consts::TAU;

use nalgebra::DVector;
use serde::Serialize;

pub use material::Material;
pub use payload::{PayloadLimit, ToothName};
pub use settings::{ExtraLoad, Load};

use crate::design::Design;
use crate::motion::{Class, Motion};
use crate::strength::Teeth;
use crate::{Error, Result};
use contacts::Configuration;
use wrench::Wrench;

/// Load on one contact.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContactLoad {
    /// Tooth j, from 0.
    pub tooth: usize,
    /// Contact point, Σ, mm.
    pub p: [f64; 3],
    /// Contact normal into the follower, Σ.
    pub n: [f64; 3],
    /// Contact force, N.
    pub force: f64,
    /// Largest Hertz pressure, MPa; 0 without force, `None` where the flanks do not form a point contact.
    pub pressure: Option<f64>,
    /// Stress at the root of the driver's and of the follower's tooth, MPa, as [`crate::strength`] has it:
    /// counted as along the layers of a print. `None` where teeth are not looked into.
    pub root_stress: Option<[f64; 2]>,
}

/// Everything at one driver angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadSample {
    /// Driver angle, rad.
    pub phi: f64,
    /// One entry per sub-gear pair.
    pub contacts: Vec<ContactLoad>,
    /// Driver torque without friction, N·mm; negative where the load drives.
    pub torque: f64,
    /// The same from virtual work, N·mm.
    pub torque_virtual_work: f64,
    /// Driver torque with friction, N·mm; `None` where friction jams the mechanism.
    pub torque_with_friction: Option<f64>,
    /// Relative error of the force equilibrium.
    pub equilibrium_error: f64,
    /// Largest payload within the force limit, the allowed pressure and the strength of the teeth, kg; infinite where weight
    /// does not load the contacts, `None` when even the extra load alone exceeds a limit.
    pub payload: Option<f64>,
    /// Which limit that is; `None` where the payload is unlimited. Contacts that are no point
    /// contacts have the force limit only.
    pub payload_limit: Option<PayloadLimit>,
    /// Tooth at which it is reached.
    pub payload_tooth: Option<ToothName>,
    /// Free turn of the follower in the gap, rad.
    pub play_turn: f64,
    /// Free displacement of the load point in the gap, mm.
    pub play_point: f64,
    /// Displacement of the load point where the load leaves it, mm.
    pub sag: f64,
    /// Displacement of the load point along gravity under its weight, mm, by virtual work: contacts flatten
    /// (Hertz) and teeth bend with their ribs ([`crate::strength`]), one behind the other. `None` without weight,
    /// with extra loads, or where flanks form no point contact. Hubs, shaft and frame are taken as rigid.
    pub deflection: Option<f64>,
}

/// Loads over the driver's range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadReport {
    /// Samples in order of φ.
    pub samples: Vec<LoadSample>,
    /// Largest contact force, N.
    pub force_max: f64,
    /// Largest driver torque without friction, N·mm (absolute).
    pub torque_max: f64,
    /// Largest driver torque with friction, N·mm (absolute); `None` if it jams anywhere.
    pub torque_with_friction_max: Option<f64>,
    /// Work done against the load, over the part of the range where the driver works against it,
    /// divided by the driver's work there with friction. `None` if it jams there or never works.
    pub efficiency: Option<f64>,
    /// Largest payload within both limits, kg; 0 when the extra load alone exceeds one.
    pub payload_max: f64,
    /// Which limit that is; `None` where the payload is unlimited.
    pub payload_limit: Option<PayloadLimit>,
    /// Tooth at which it is reached.
    pub payload_tooth: Option<ToothName>,
    /// Largest stress at the root of a tooth, MPa; `None` where teeth are not looked into.
    pub root_stress_max_mpa: Option<f64>,
    /// What the weaker of both materials bears there, MPa.
    pub root_stress_allowed_mpa: f64,
    /// Least stiffness of a tooth along the contact normal, anywhere on it, N/mm; `None` as above.
    pub tooth_stiffness_min_n_per_mm: Option<f64>,
    /// Which tooth that is.
    pub softest_tooth: Option<ToothName>,
    /// Largest [`LoadSample::deflection`], mm; `None` where one of them is.
    pub deflection_max_mm: Option<f64>,
    /// Largest Hertz pressure, MPa; `None` where some loaded contact is no point contact.
    pub pressure_max: Option<f64>,
    /// What the weaker of both materials bears without yielding, MPa.
    pub pressure_allowed: f64,
    /// Largest play of the follower, rad.
    pub play_turn_max: f64,
    /// Largest play of the load point, mm.
    pub play_point_max: f64,
    /// Largest relative equilibrium error.
    pub equilibrium_error_max: f64,
    /// Largest difference between both torques, relative to the largest torque.
    pub virtual_work_error_max: f64,
}

/// How the driver's range is sampled.
#[derive(Debug, Clone, Copy)]
pub struct Sampling {
    /// First driver angle, rad.
    pub start: f64,
    /// Last driver angle, rad, excluded when the range is a whole turn.
    pub end: f64,
    /// Number of samples.
    pub count: usize,
}

impl Default for Sampling {
    fn default() -> Self {
        Sampling {
            start: 0.0,
            end: TAU,
            count: 360,
        }
    }
}

impl Sampling {
    /// The phases that `motion` runs through.
    pub fn of(motion: &Motion) -> Sampling {
        let cycle = motion.cycle();
        Sampling {
            start: cycle.start(),
            end: cycle.end(),
            ..Sampling::default()
        }
    }

    /// Whether the range is one turn of the driver, so that its end is its start.
    pub fn is_whole_turn(&self) -> bool {
        (self.end - self.start - TAU).abs() < 1e-9
    }

    /// The driver angles, rad.
    pub fn angles(&self) -> impl Iterator<Item = f64> + use<> {
        let steps = if self.is_whole_turn() {
            self.count
        } else {
            self.count.max(2) - 1
        } as f64;
        let (start, span) = (self.start, self.end - self.start);
        (0..self.count).map(move |i| start + span * i as f64 / steps)
    }
}

/// Row scales of span(U): 1 for forces, L/2 for moments.
pub fn lengths(class: Class, center_distance: f64) -> DVector<f64> {
    let mut lengths = DVector::from_element(class.dof(), 0.5 * center_distance);
    if class.slides() {
        lengths[0] = 1.0;
    }
    lengths
}

/// Carries `load` with `design`, whose motion is `motion`, at every angle of `sampling`. Teeth that cannot be cut
/// into elements leave stress, stiffness and deflection unknown.
///
/// # Errors
/// [`Error::Infeasible`] where the contacts cannot hold the load (no form closure) or a tooth is
/// missing; [`Error::Input`] when `load` has impossible values.
pub fn analyse(
    design: &Design,
    motion: &Motion,
    load: &Load,
    sampling: Sampling,
) -> Result<LoadReport> {
    let teeth = Teeth::of(design, [load.driver_material, load.follower_material]);
    let mut report = carried((design, motion), load, sampling, teeth.as_ref())?;
    match teeth.and_then(|teeth| teeth.softest()) {
        Some((stiffness, gear, [pair, tooth])) => {
            report.tooth_stiffness_min_n_per_mm = Some(stiffness);
            report.softest_tooth = Some(ToothName {
                gear: Some(gear),
                pair,
                tooth,
            });
        }
        None => {
            report.samples.iter_mut().for_each(|s| s.deflection = None);
            report.deflection_max_mm = None;
        }
    }
    Ok(report)
}

/// The same with teeth that neither give nor break: a tenth of the work.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_rigid(
    design: &Design,
    motion: &Motion,
    load: &Load,
    sampling: Sampling,
) -> Result<LoadReport> {
    carried((design, motion), load, sampling, None)
}

fn carried(
    (design, motion): (&Design, &Motion),
    load: &Load,
    sampling: Sampling,
    teeth: Option<&Teeth>,
) -> Result<LoadReport> {
    let problems = load.problems();
    if !problems.is_empty() {
        return Err(Error::Input {
            file: "load".into(),
            problems: problems.into(),
        });
    }
    let samples = sampling
        .angles()
        .map(|phi| {
            let at = Configuration::at(design, motion, phi)?;
            sample(design, load, &at, teeth)
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(summarise(load, samples))
}

fn sample(
    design: &Design,
    load: &Load,
    at: &Configuration,
    teeth: Option<&Teeth>,
) -> Result<LoadSample> {
    let open = || {
        Error::Infeasible {
        reason: "the contacts cannot hold the load".into(),
        place: format!("φ = {:.2}°", at.phi.to_degrees()),
        hint: "the follower is not form closed here; design it again with more sub-gear pairs or effort".into(),
    }
    };
    let gear = &design.settings.gear;
    let lengths = lengths(at.class, gear.center_distance_mm);
    let (unit, extra) = (Wrench::unit_weight(load, at), Wrench::extra(load, at));
    let mass = load.mass_g * 1e-3;
    let (unit_projected, extra_projected) = (unit.project(at), extra.project(at));
    let total = &unit_projected * mass + &extra_projected;

    let columns = play::columns(at);
    let balance = forces::smallest_largest(&columns, &total, &lengths).ok_or_else(open)?;
    let normals: Vec<_> = at.contacts.iter().map(|c| c.n).collect();
    let play = play::play(at, design.section.clearance, unit.point, &total).ok_or_else(open)?;
    let modulus = hertz::effective_modulus(load.driver_material, load.follower_material);
    // Work done on the contacts that bear something, as they flatten and their teeth bend.
    let mut work = Some(0.0);
    let mut contacts = Vec::with_capacity(at.contacts.len());
    for (c, &force) in at.contacts.iter().zip(&balance.forces) {
        let mut pressure = Some(0.0);
        if force > 0.0 {
            let patch = hertz::patch(hertz::relative_curvatures(c), force, modulus);
            pressure = patch.map(|p| p.pressure);
            work = work.zip(patch).map(|(sum, p)| sum + force * p.approach);
        }
        let responses = teeth.map(|teeth| {
            let both = teeth.tooth(c.pair, c.tooth).each_ref();
            both.map(|tooth| tooth.at(c.share))
        });
        let bent = responses.map_or(0.0, |both| both.iter().map(|r| force * r.compliance).sum());
        work = work.map(|sum| sum + force * bent);
        contacts.push(ContactLoad {
            root_stress: responses.map(|both| both.map(|r| force * r.stress)),
            tooth: c.tooth,
            p: c.p.into(),
            n: c.n.into(),
            force,
            pressure,
        });
    }
    let weight = mass * wrench::GRAVITY;
    let payload = payload::largest(
        (load, at, teeth),
        (&columns, &lengths),
        (&unit_projected, &extra_projected),
    );
    Ok(LoadSample {
        phi: at.phi,
        contacts,
        torque: efficiency::driver_torque(at, &balance.forces, &normals),
        torque_virtual_work: -(unit.power(at) * mass + extra.power(at)),
        torque_with_friction: efficiency::sliding_balance(at, &total, (load.friction, &lengths))
            .map(|(_, t)| t),
        equilibrium_error: balance.residual,
        payload: payload.kg,
        payload_limit: payload.limit,
        payload_tooth: payload.tooth,
        play_turn: play.turn,
        play_point: play.point,
        sag: play.sag,
        deflection: work
            .filter(|_| weight > 0.0 && load.extra.is_empty())
            .map(|work| work / weight),
    })
}

fn summarise(load: &Load, samples: Vec<LoadSample>) -> LoadReport {
    let largest = |get: &dyn Fn(&LoadSample) -> f64| samples.iter().map(get).fold(0.0, f64::max);
    let all = |get: &dyn Fn(&LoadSample) -> Option<f64>| {
        samples
            .iter()
            .map(get)
            .try_fold(0.0, |m: f64, x| Some(m.max(x?)))
    };
    let torque_max = largest(&|s| s.torque.abs());
    let working = || samples.iter().filter(|s| s.torque > 1e-9 * torque_max);
    let kilograms = |s: &LoadSample| s.payload.unwrap_or(0.0);
    let least = samples
        .iter()
        .min_by(|a, b| kilograms(a).total_cmp(&kilograms(b)));
    let useful: f64 = working().map(|s| s.torque).sum();
    let spent = working().try_fold(0.0, |sum, s| Some(sum + s.torque_with_friction?));
    LoadReport {
        force_max: largest(&|s| s.contacts.iter().map(|c| c.force).fold(0.0, f64::max)),
        torque_max,
        torque_with_friction_max: all(&|s| s.torque_with_friction.map(f64::abs)),
        efficiency: spent
            .filter(|spent| useful > 0.0 && *spent > 0.0)
            .map(|spent| useful / spent),
        payload_max: least.map_or(f64::INFINITY, |s| s.payload.unwrap_or(0.0)),
        payload_limit: least.and_then(|s| s.payload_limit),
        payload_tooth: least.and_then(|s| s.payload_tooth),
        root_stress_max_mpa: all(&|s| {
            s.contacts.iter().try_fold(0.0, |m: f64, c| {
                Some(c.root_stress?.into_iter().fold(m, f64::max))
            })
        }),
        root_stress_allowed_mpa: [load.driver_material, load.follower_material]
            .map(Material::yield_strength)
            .into_iter()
            .fold(f64::INFINITY, f64::min),
        tooth_stiffness_min_n_per_mm: None,
        softest_tooth: None,
        deflection_max_mm: all(&|s| s.deflection),
        pressure_max: all(&|s| {
            s.contacts
                .iter()
                .try_fold(0.0, |m: f64, c| Some(m.max(c.pressure?)))
        }),
        pressure_allowed: load.pressure_allowed(),
        play_turn_max: largest(&|s| s.play_turn),
        play_point_max: largest(&|s| s.play_point),
        equilibrium_error_max: largest(&|s| s.equilibrium_error),
        virtual_work_error_max: largest(&|s| (s.torque - s.torque_virtual_work).abs())
            / torque_max.max(1e-9),
        samples,
    }
}
