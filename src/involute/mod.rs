//! A standard pair of spur gears for comparison: involute teeth of 20°, standard modules, profile shift, at the
//! centre distance and the ratio of a mechanism that turns at a constant rate.

pub mod body;
pub mod profile;
pub mod strength;

use std::f64::consts::PI;

use crate::{Error, Problem, Result};

/// Pressure angle of the rack, rad.
pub const PRESSURE_ANGLE: f64 = 20.0 * PI / 180.0;
/// Height of the rack's teeth below its middle, in modules (ISO 53, profile A).
pub const DEDENDUM: f64 = 1.25;
/// Radius of the rack's tips, in modules.
pub const TIP_ROUNDING: f64 = 0.38;
/// Gap between the tip of a tooth and the root of the other gear, in modules.
const TIP_GAP: f64 = 0.25;

/// Modules of ISO 54, first series, and those below it, mm.
const MODULES: [f64; 18] = [
    12.0, 10.0, 8.0, 6.0, 5.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.25, 1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2,
];

/// Least contact ratio, least thickness of tips in modules, and most profile shift of a gear.
const LEAST_RATIO: f64 = 1.2;
const LEAST_TIP: f64 = 0.25;
const MOST_SHIFT: f64 = 0.8;

/// One gear of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheel {
    /// Number of teeth.
    pub teeth: usize,
    /// Profile shift, in modules.
    pub shift: f64,
    /// Radius of its tips, mm.
    pub tip_radius: f64,
}

/// Two gears on parallel axes that turn against each other at a constant ratio; driver first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Module, mm.
    pub module: f64,
    /// Driver and follower.
    pub wheels: [Wheel; 2],
    /// Centre distance, mm.
    pub center_distance: f64,
    /// Width along the axes, mm.
    pub face_width: f64,
    /// Gap between the flanks that do not touch, along the normal, mm.
    pub backlash: f64,
}

/// tan α − α.
pub fn involute(angle: f64) -> f64 {
    angle.tan() - angle
}

impl Pair {
    /// Gears of so many teeth and profile shifts; their tips keep the usual gap from the other's root.
    pub fn new(
        (module, center_distance): (f64, f64),
        wheels: [(usize, f64); 2],
        (face_width, backlash): (f64, f64),
    ) -> Pair {
        let root = |(teeth, shift): (usize, f64)| module * (teeth as f64 / 2.0 + shift - DEDENDUM);
        let wheel = |own: (usize, f64), other| Wheel {
            teeth: own.0,
            shift: own.1,
            tip_radius: (center_distance - root(other) - TIP_GAP * module)
                .min(module * (own.0 as f64 / 2.0 + own.1 + 1.0)),
        };
        let [one, two] = wheels;
        Pair {
            module,
            wheels: [wheel(one, two), wheel(two, one)],
            center_distance,
            face_width,
            backlash,
        }
    }

    /// The standard pair at a centre distance (mm) whose driver has `copies` times the follower's teeth: of
    /// the largest module, which is strongest at the root, that meshes well. Teeth are as many as the
    /// distance has room for, profile shift fills what is left of it.
    ///
    /// # Errors
    /// [`Error::Input`] when no standard module does.
    pub fn standard(center_distance: f64, copies: usize, width: (f64, f64)) -> Result<Pair> {
        let found = MODULES.into_iter().find_map(|module| {
            let sum = 2.0 * center_distance / module;
            let follower = (sum / (1 + copies) as f64).floor() as usize;
            let teeth = [copies * follower, follower];
            let shift = shift_sum(module, center_distance, teeth)? / 2.0;
            let pair = Pair::new((module, center_distance), teeth.map(|z| (z, shift)), width);
            pair.meshes_well().then_some(pair)
        });
        found.ok_or_else(|| {
            let what = format!("no standard module fits a centre distance of {center_distance} mm");
            let place = "gear.center_distance_mm";
            Error::input("involute pair", vec![Problem::new(place, what, "")])
        })
    }

    fn meshes_well(&self) -> bool {
        self.contact_ratio() >= LEAST_RATIO
            && (0..2).all(|i| {
                let wheel = &self.wheels[i];
                wheel.shift.abs() <= MOST_SHIFT
                    && wheel.shift >= least_shift(wheel.teeth)
                    && self.tip_thickness(i) >= LEAST_TIP * self.module
            })
    }

    /// Pressure angle at which the pair runs, rad.
    pub fn working_angle(&self) -> f64 {
        let sum = self.base_radius(0) + self.base_radius(1);
        (sum / self.center_distance).acos()
    }

    /// Radius of the circle that the involutes of gear `i` come from, mm.
    pub fn base_radius(&self, i: usize) -> f64 {
        self.reference_radius(i) * PRESSURE_ANGLE.cos()
    }

    /// Radius on which the rack rolls off gear `i`, mm.
    pub fn reference_radius(&self, i: usize) -> f64 {
        self.module * self.wheels[i].teeth as f64 / 2.0
    }

    /// Radius on which gear `i` rolls off the other, mm.
    pub fn pitch_radius(&self, i: usize) -> f64 {
        let teeth = self.wheels.map(|w| w.teeth as f64);
        self.center_distance * teeth[i] / (teeth[0] + teeth[1])
    }

    /// Distance of neighbouring flanks along the line of action, mm.
    pub fn base_pitch(&self) -> f64 {
        PI * self.module * PRESSURE_ANGLE.cos()
    }

    /// How far contact goes from the pitch point to the tip of gear `i`, mm along the line of action.
    pub fn recess(&self, i: usize) -> f64 {
        let (tip, base) = (self.wheels[i].tip_radius, self.base_radius(i));
        (tip * tip - base * base).max(0.0).sqrt()
            - self.pitch_radius(i) * self.working_angle().sin()
    }

    /// How many tooth pairs touch on average.
    pub fn contact_ratio(&self) -> f64 {
        (self.recess(0) + self.recess(1)) / self.base_pitch()
    }

    /// Thickness of a tooth of gear `i` at its tip, along the arc, mm.
    pub fn tip_thickness(&self, i: usize) -> f64 {
        let wheel = &self.wheels[i];
        let angle = (self.base_radius(i) / wheel.tip_radius).acos();
        let half = (PI / 2.0 + 2.0 * wheel.shift * PRESSURE_ANGLE.tan()) / wheel.teeth as f64;
        2.0 * wheel.tip_radius * (half + involute(PRESSURE_ANGLE) - involute(angle))
    }

    /// Largest distance across the gears, mm.
    pub fn length(&self) -> f64 {
        self.center_distance + self.wheels[0].tip_radius + self.wheels[1].tip_radius
    }
}

/// Profile shift of both gears together at which their flanks touch on both sides, in modules; `None`
/// where the distance is too short.
pub fn shift_sum(module: f64, center_distance: f64, teeth: [usize; 2]) -> Option<f64> {
    let sum = (teeth[0] + teeth[1]) as f64;
    let cos = 0.5 * module * sum * PRESSURE_ANGLE.cos() / center_distance;
    if !(cos <= PRESSURE_ANGLE.cos() + 1e-12) || sum == 0.0 {
        return None;
    }
    let angle = cos.acos();
    Some((involute(angle) - involute(PRESSURE_ANGLE)) * sum / (2.0 * PRESSURE_ANGLE.tan()))
}

/// Profile shift from which on a gear's teeth are not undercut, in modules.
pub fn least_shift(teeth: usize) -> f64 {
    1.0 - 0.5 * teeth as f64 * PRESSURE_ANGLE.sin().powi(2)
}
