//! Contacts known in closed form, for the uniform motion R = Rz(−φ).
#![allow(dead_code)] // every test file uses its own part of this

use std::f64::consts::TAU;

use mpcgear::closure;
use mpcgear::design::{
    ClosureSample, Contact, Design, FORMAT, Section, Station, SubGearPair, ToothPair,
};
use mpcgear::load::contacts::Configuration;
use mpcgear::motion::{Class, Drive, Motion, MotionSource};
use mpcgear::settings::Settings;
use nalgebra::Vector3;

pub const J: usize = 10;
pub const C: f64 = 1.44;
pub const L: f64 = 25.0;
/// Radius of both pitch cylinders, mm.
pub const PITCH: f64 = 0.5 * L;

/// Contact point and normal in Σ at φ, and the φ in the middle of the tooth.
pub type Law<'a> = &'a dyn Fn(f64, f64) -> (Vector3<f64>, Vector3<f64>);

/// J tooth pairs that follow `law`.
pub fn band(motion: &Motion, law: Law) -> SubGearPair {
    let step = TAU / J as f64;
    let teeth = (0..J)
        .map(|j| {
            let (start, end) = (
                (j as f64 - 0.5 * (C - 1.0)) * step,
                (j as f64 + 1.0 + 0.5 * (C - 1.0)) * step,
            );
            let middle = 0.5 * (start + end);
            let count = 25;
            let stations = (0..count)
                .map(|i| {
                    let phi = start + (end - start) * i as f64 / (count - 1) as f64;
                    let (p, n) = law(phi, middle);
                    let h = 1e-5;
                    let speed = (law(phi + h, middle).0 - law(phi - h, middle).0) / (2.0 * h);
                    let (one, two) = (Drive::new(L, 1).state(phi), motion.state(phi));
                    let contact = Contact {
                        phi,
                        p,
                        n,
                        v: speed,
                    };
                    Station::new(contact, &one, &two)
                })
                .collect();
            ToothPair {
                phi_start: start,
                phi_end: end,
                control_points: Vec::new(),
                fit_error: 0.0,
                flare: Default::default(),
                stations,
            }
        })
        .collect();
    SubGearPair {
        flank_radius: None,
        parameters: Vec::new(),
        teeth,
    }
}

/// Helical teeth that roll on the pitch line: pressure angle `alpha`, axial `travel` over the tooth
/// (its sign is the hand), material side ±1, centred at height `z0`.
#[derive(Debug, Clone, Copy)]
pub struct Helical {
    pub alpha: f64,
    pub side: f64,
    pub z0: f64,
    pub travel: f64,
}

impl Helical {
    /// Axial speed of the contact point, mm/rad.
    pub fn axial_speed(&self) -> f64 {
        self.travel / (C * TAU / J as f64)
    }

    pub fn normal(&self) -> Vector3<f64> {
        let dz = self.axial_speed();
        let across = Vector3::new(0.0, dz, PITCH).normalize() * self.side;
        Vector3::x() * self.alpha.sin() + across * self.alpha.cos()
    }

    pub fn band(&self, motion: &Motion) -> SubGearPair {
        band(motion, &|phi, middle| {
            let z = self.z0 + self.axial_speed() * (phi - middle);
            (Vector3::new(-PITCH, 0.0, z), self.normal())
        })
    }
}

/// Involute spur teeth with pressure angle `alpha` at height `z`; `side` ±1 turns the flank over.
pub fn involute(motion: &Motion, alpha: f64, (side, z): (f64, f64)) -> SubGearPair {
    band(motion, &|phi, middle| {
        let n = Vector3::new(alpha.sin(), side * alpha.cos(), 0.0);
        let pitch_point = Vector3::new(-PITCH, 0.0, z);
        (
            pitch_point + n * (side * PITCH * alpha.cos() * (phi - middle)),
            n,
        )
    })
}

pub fn motion(class: Class) -> Motion {
    Motion::new(class, &MotionSource::Uniform {}).expect("uniform motion")
}

pub fn design(class: Class, bands: Vec<SubGearPair>) -> Design {
    let mut design = Design {
        format: FORMAT,
        generator: "test".into(),
        name: format!("uniform {class}"),
        class,
        settings: Settings::default(),
        motion: MotionSource::Uniform {},
        sub_gear_pairs: bands,
        section: Section {
            thickness: 1.8,
            flank_radius: 0.9,
            tip: 0.9,
            root: 1.2,
            clearance: 0.1,
            rib: 1.4,
        },
        recipe: Default::default(),
        closure: Vec::new(),
        problems: Vec::new(),
    };
    design.closure = closure_of(&design);
    design
}

/// Q of a design at every degree.
pub fn closure_of(design: &Design) -> Vec<ClosureSample> {
    (0..360)
        .map(|i| sample(design, f64::from(i).to_radians()))
        .collect()
}

fn sample(design: &Design, phi: f64) -> ClosureSample {
    let at = Configuration::at(design, &motion(design.class), phi).expect("contact");
    let wrenches = |length: f64| -> Vec<closure::Wrench> {
        at.contacts
            .iter()
            .map(|c| closure::wrench(at.class, c.p, c.n, at.centre, length))
            .collect()
    };
    let dof = at.class.dof();
    let (q, q_star) = (
        closure::measure(&wrenches(1.0), dof),
        closure::measure(&wrenches(PITCH), dof),
    );
    let star = wrenches(PITCH);
    let mean = star
        .iter()
        .map(|w| w.iter().map(|x| x * x).sum::<f64>().sqrt())
        .sum::<f64>()
        / star.len() as f64;
    ClosureSample {
        phi,
        q,
        q_star,
        eta: dof as f64 * q_star / mean,
    }
}

/// Two helical bands of opposite side.
pub fn revolute() -> Design {
    let m = motion(Class::R1);
    let at = |side: f64, z0: f64| Helical {
        alpha: 0.5,
        side,
        z0,
        travel: 12.0,
    };
    design(
        Class::R1,
        vec![at(1.0, 10.0).band(&m), at(-1.0, 26.0).band(&m)],
    )
}

/// Four helical bands, two above and two below O, whose torques point to alternate corners of a box.
pub fn spherical() -> Design {
    let m = motion(Class::R3);
    let at = |side: f64, z0: f64, travel: f64| Helical {
        alpha: 0.6,
        side,
        z0,
        travel,
    };
    let bands = [
        at(1.0, 14.0, 9.0),
        at(1.0, 25.0, -9.0),
        at(-1.0, -14.0, 9.0),
        at(-1.0, -25.0, -9.0),
    ];
    design(Class::R3, bands.iter().map(|b| b.band(&m)).collect())
}
