//! The serialised result that everything is exported from: teeth, layout, poses, settings.

mod check;
mod check_recipe;
pub mod file;
mod lines;

pub use check_recipe::is_name;
pub use file::Stored;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::motion::{Class, MotionFile, MotionState};
use crate::settings::{FlankRadius, Settings};
use crate::solid::recipe::Recipe;

/// Version of the `design.json` format that is written; 1 is read as well.
pub const FORMAT: u32 = 2;

/// A complete design; `design.json` is this, in mm and rad, frames of the README's "Frames".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Design {
    /// [`FORMAT`] of the writer.
    pub format: u32,
    /// `mpcgear` version that wrote it.
    pub generator: String,
    /// Name from the motion file.
    pub name: String,
    /// Class of the joint.
    pub class: Class,
    /// Everything the user set, defaults filled in.
    pub settings: Settings,
    /// The motion itself, self-contained (tables inlined), so that any φ can be evaluated again.
    pub motion: crate::motion::MotionSource,
    /// The K sub-gear pairs.
    pub sub_gear_pairs: Vec<SubGearPair>,
    /// Cross sections of the teeth.
    pub section: Section,
    /// Hubs, joints, support: parametric solids of every body. Empty in a draft without teeth.
    pub recipe: Recipe,
    /// Q over the period.
    pub closure: Vec<ClosureSample>,
    /// Why the design is not a working gear; empty when it is.
    pub problems: Vec<String>,
}

impl Design {
    /// Cross section of the teeth of `pair`.
    pub fn section_of(&self, pair: &SubGearPair) -> Section {
        Section {
            flank_radius: pair.flank_radius.unwrap_or(self.section.flank_radius),
            ..self.section
        }
    }

    /// Tooth pairs of a band.
    pub fn tooth_pairs(&self) -> usize {
        let teeth = self.settings.gear.tooth_pairs();
        self.motion.cycle().pairs(teeth)
    }

    /// The stations of every tooth.
    fn stations_mut(&mut self) -> impl Iterator<Item = &mut [Station]> {
        let teeth = self.sub_gear_pairs.iter_mut().flat_map(|p| &mut p.teeth);
        teeth.map(|tooth| &mut tooth.stations[..])
    }

    /// A design without teeth: what the motion file says of it.
    pub fn draft(file: &MotionFile) -> Design {
        let settings = file.settings.clone();
        Design {
            format: FORMAT,
            generator: env!("CARGO_PKG_VERSION").into(),
            name: file.name.clone(),
            class: file.class,
            motion: file.source.clone(),
            sub_gear_pairs: Vec::new(),
            section: Section::of(&settings),
            settings,
            recipe: Recipe::default(),
            closure: Vec::new(),
            problems: Vec::new(),
        }
    }
}

/// One band: J tooth pairs that realise contact k over the whole period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SubGearPair {
    /// Design variables of the band (normal-first parameterisation), empty for `paper`.
    pub parameters: Vec<f64>,
    /// Radius of the flanks, mm, where it is not that of the design's section.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flank_radius: Option<f64>,
    /// The J tooth pairs, in order of contact.
    pub teeth: Vec<ToothPair>,
}

/// One tooth pair: a tooth on the driver and its mate on the follower.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ToothPair {
    /// Start of the contact interval, rad (may be < 0; periodic).
    pub phi_start: f64,
    /// End of the contact interval, rad.
    pub phi_end: f64,
    /// Control points of a clamped uniform cubic B-spline fitted to the locus p(φ), mm.
    pub control_points: Vec<[f64; 3]>,
    /// Largest distance between that spline and the locus, mm.
    pub fit_error: f64,
    /// By how much the ribs of driver and follower are thicker where they end in their hub than at the bead,
    /// mm: on the side that tangent × radial points to, and on the other.
    #[serde(default, skip_serializing_if = "is_straight")]
    pub flare: [[f64; 2]; 2],
    /// Contact stations from `phi_start` to `phi_end`, equally spaced.
    pub stations: Vec<Station>,
}

/// One contact station of a tooth pair. The file keeps what stands in Σ; what stands in the gears'
/// frames follows from it and the motion ([`Station::new`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Station {
    /// Driver angle, rad.
    pub phi: f64,
    /// Contact point in Σ, mm.
    pub p: [f64; 3],
    /// Contact normal in Σ, unit, into the follower.
    pub n: [f64; 3],
    /// dp/dφ, mm/rad.
    #[serde(default = "unknown")]
    pub v: [f64; 3],
    /// Contact point in the driver frame, mm.
    #[serde(default, skip_serializing)]
    pub p1: [f64; 3],
    /// −(M¹)⁻¹ n: into the driver's material.
    #[serde(default, skip_serializing)]
    pub n1: [f64; 3],
    /// Unit tangent of the driver's curve, driver frame.
    #[serde(default, skip_serializing)]
    pub t1: [f64; 3],
    /// Contact point in the follower frame, mm.
    #[serde(default, skip_serializing)]
    pub p2: [f64; 3],
    /// (M²)⁻¹ n: into the follower's material.
    #[serde(default, skip_serializing)]
    pub n2: [f64; 3],
    /// Unit tangent of the follower's curve, follower frame.
    #[serde(default, skip_serializing)]
    pub t2: [f64; 3],
}

/// Which gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Gear {
    /// Turned by the motor about x = −L.
    Driver,
    /// Performs the motion.
    Follower,
}

/// A contact in Σ, before it is known where it lies on the gears.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Driver angle, rad.
    pub phi: f64,
    /// Contact point, mm.
    pub p: Vector3<f64>,
    /// Unit normal into the follower.
    pub n: Vector3<f64>,
    /// dp/dφ, mm/rad.
    pub v: Vector3<f64>,
}

/// Decimals of p, n and v, so that a design is the same before it is written and after it is read:
/// a thousandth of what the conjugation residual of 1e-10 mm/rad can see.
const DECIMALS: [i32; 3] = [13, 13, 9];

impl Station {
    /// The station of a contact, when `driver` and `follower` are the gears' states at its φ:
    /// pα = (Mα)⁻¹ p, n¹ = −(M¹)⁻¹ n, n² = (M²)⁻¹ n, tα along (Mα)⁻¹ (v − vα(p)).
    pub fn new(contact: Contact, driver: &MotionState, follower: &MotionState) -> Station {
        let Contact { phi, p, n, v } = contact;
        let [p, n, v]: [Vector3<f64>; 3] = std::array::from_fn(|i| {
            let scale = 10f64.powi(DECIMALS[i]);
            [p, n, v][i].map(|x| (x * scale).round() / scale + 0.0)
        });
        let in_body = |state: &MotionState, into: f64| -> [[f64; 3]; 3] {
            let rt = state.pose.rotation.transpose();
            let t = (rt * (v - state.velocity(p))).normalize();
            [state.pose.inverse_apply(p), rt * n * into, t].map(Into::into)
        };
        let ([p1, n1, t1], [p2, n2, t2]) = (in_body(driver, -1.0), in_body(follower, 1.0));
        Station {
            phi,
            p: p.into(),
            n: n.into(),
            v: v.into(),
            p1,
            n1,
            t1,
            p2,
            n2,
            t2,
        }
    }

    /// The contact in Σ.
    pub fn contact(&self) -> Contact {
        Contact {
            phi: self.phi,
            p: self.p.into(),
            n: self.n.into(),
            v: self.v.into(),
        }
    }

    /// Contact point, normal into the material and unit tangent in the frame of `gear`.
    pub fn frame(&self, gear: Gear) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
        match gear {
            Gear::Driver => (self.p1.into(), self.n1.into(), self.t1.into()),
            Gear::Follower => (self.p2.into(), self.n2.into(), self.t2.into()),
        }
    }
}

/// Cross section of the teeth, in the frame (n into the material, b outwards from the hub), mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Extent along n.
    pub thickness: f64,
    /// Radius of the convex flanks.
    pub flank_radius: f64,
    /// Extent along +b beyond the contact point.
    pub tip: f64,
    /// Extent along −b behind the contact point.
    pub root: f64,
    /// Flank-to-flank gap; each gear's section starts half of it behind its contact point.
    pub clearance: f64,
    /// Thickness of the rib between root and hub.
    pub rib: f64,
}

impl Section {
    /// The section that `settings` ask for; a radius that is to be found is at first that of a round bead.
    pub fn of(settings: &Settings) -> Section {
        let bead = settings.gear.bead_radius();
        Section {
            thickness: settings.gear.tooth_thickness_mm,
            flank_radius: match settings.gear.flank_radius_mm {
                FlankRadius::Fixed(radius) => radius,
                FlankRadius::Auto(_) => bead,
            },
            tip: settings.gear.tip_mm,
            root: settings.gear.root_mm,
            clearance: settings.fit.clearance_mm,
            rib: settings.spokes.thickness_mm,
        }
    }

    /// Whether the flanks are flatter than those of a round bead; they then end in rounded edges.
    pub fn is_flat(&self) -> bool {
        self.flank_radius > 0.5 * self.thickness
    }

    /// Radius of the round bead that fits into the section, mm.
    pub fn bead_radius(&self) -> f64 {
        self.flank_radius.min(0.5 * self.thickness)
    }
}

/// Q at one driver angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ClosureSample {
    /// Driver angle, rad.
    pub phi: f64,
    /// Q(φ) of Eq. 4 (mixed units in classes with translation); −∞ without closure, `null` in JSON.
    #[serde(deserialize_with = "number_or_none")]
    pub q: f64,
    /// Q with moments divided by L/2.
    #[serde(deserialize_with = "number_or_none")]
    pub q_star: f64,
    /// N·Q*/mean|n̄*|, quality in (−∞, 1].
    #[serde(deserialize_with = "number_or_none")]
    pub eta: f64,
}

/// Whether ribs are as thick everywhere.
fn is_straight(flare: &[[f64; 2]; 2]) -> bool {
    flare.iter().flatten().all(|&f| f == 0.0)
}

/// A vector that the file does not give, as those of format 1.
fn unknown() -> [f64; 3] {
    [f64::NAN; 3]
}

/// JSON has no −∞: it stands there as `null`.
fn number_or_none<'d, D: serde::Deserializer<'d>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NEG_INFINITY))
}
