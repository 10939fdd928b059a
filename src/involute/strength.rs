//! What a pair bears: Hertz at the pitch point, bending at the root, losses.

use std::f64::consts::PI;

use super::{DEDENDUM, PRESSURE_ANGLE, Pair, TIP_ROUNDING, involute};
use crate::load::{Material, hertz};

/// Stress and loss under a torque of the follower.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Stress {
    /// Contact force along the line of action, N.
    pub force: f64,
    /// Largest pressure of two cylinders at the pitch point, MPa.
    pub pressure: f64,
    /// Largest nominal stress at the root, MPa.
    pub root: f64,
    /// Work that goes on, as a share of what comes in.
    pub efficiency: f64,
}

/// Stress under a torque of the follower (N·mm) that one pair of teeth carries, friction on its flanks.
pub fn stress(pair: &Pair, torque: f64, materials: [Material; 2], friction: f64) -> Stress {
    let force = torque / pair.base_radius(1);
    let [one, two] = materials;
    let modulus = hertz::effective_modulus(one, two);
    let sin = pair.working_angle().sin();
    let curvature: f64 = (0..2).map(|i| 1.0 / (pair.pitch_radius(i) * sin)).sum();
    let width = pair.face_width;
    let pressure = (force / width * modulus * curvature / PI).sqrt();
    let tangential = force * PRESSURE_ANGLE.cos();
    let root = (0..2)
        .map(|i| tangential / (width * pair.module) * form_factor(pair, i))
        .fold(0.0, f64::max);
    Stress {
        force,
        pressure,
        root,
        efficiency: 1.0 - friction * loss_factor(pair),
    }
}

/// Y_F of gear `i` for a force at its tip, on the section at the 30° tangents of the root fillets (ISO 6336-3,
/// method C of DIN 3990-3; without the notch factor Y_S).
pub fn form_factor(pair: &Pair, i: usize) -> f64 {
    let wheel = &pair.wheels[i];
    let (z, x) = (wheel.teeth as f64, wheel.shift);
    let (sin, cos) = PRESSURE_ANGLE.sin_cos();
    let aside = PI / 4.0 - DEDENDUM * PRESSURE_ANGLE.tan() - (1.0 - sin) * TIP_ROUNDING / cos;
    let depth = TIP_ROUNDING - DEDENDUM + x;
    let start = 2.0 / z * (PI / 2.0 - aside) - PI / 3.0;
    let mut angle = PI / 6.0;
    for _ in 0..50 {
        angle = 2.0 * depth / z * angle.tan() - start;
    }
    let below = depth / angle.cos() - TIP_ROUNDING;
    let thickness = z * (PI / 3.0 - angle).sin() + 3f64.sqrt() * below;
    let tip = 2.0 * wheel.tip_radius / pair.module;
    let at_tip = (2.0 * pair.base_radius(i) / pair.module / tip).acos();
    let half = (PI / 2.0 + 2.0 * x * PRESSURE_ANGLE.tan()) / z + involute(PRESSURE_ANGLE)
        - involute(at_tip);
    let lean = at_tip - half;
    let arm =
        0.5 * ((half.cos() - half.sin() * lean.tan()) * tip - z * (PI / 3.0 - angle).cos() - below);
    6.0 * arm * lean.cos() / (thickness * thickness * cos)
}

/// Share of the power that is lost per friction coefficient, on average (Niemann and Winter, Maschinenelemente 2:
/// H_v).
pub fn loss_factor(pair: &Pair) -> f64 {
    let [one, two] = pair.wheels.map(|w| w.teeth as f64);
    let [first, second] = [0, 1].map(|i| pair.recess(i) / pair.base_pitch());
    PI * (1.0 / one + 1.0 / two) * (1.0 - first - second + first * first + second * second)
}
