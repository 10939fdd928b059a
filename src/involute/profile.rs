//! The outline of a gear as its rack generates it: involute flanks, and fillets that the rack's rounded tips
//! leave.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Rotation2, Vector2};

use super::{DEDENDUM, PRESSURE_ANGLE, Pair, TIP_ROUNDING};

/// Points of an involute flank, and of a fillet.
const FLANK: usize = 24;
const FILLET: usize = 10;

/// One side of the gap between two teeth of gear `i`, from its root to the tip; the middle of the gap is
/// on the y axis, the gear's axis at the origin, mm.
pub fn flank(pair: &Pair, i: usize) -> Vec<Vector2<f64>> {
    let m = pair.module;
    let radius = pair.reference_radius(i);
    let shift = pair.wheels[i].shift * m;
    let (sin, cos) = PRESSURE_ANGLE.sin_cos();
    // Half the gap between the flanks that do not touch is each gear's share.
    let thinner = pair.backlash / 4.0 / cos;
    let rounding = TIP_ROUNDING * m;
    let depth = DEDENDUM * m - shift - rounding;
    // Middle of the rack's rounded tip beside the middle of its tooth.
    let aside =
        PI * m / 4.0 + thinner - DEDENDUM * m * PRESSURE_ANGLE.tan() - rounding * (1.0 - sin) / cos;
    let pitch_point = Vector2::new(0.0, radius);
    // The gear turns by `roll` while the rack moves by radius · roll.
    let on_gear = |p: Vector2<f64>, roll: f64| Rotation2::new(roll) * p;
    let fillet = (0..FILLET).map(|k| {
        let lean = (FRAC_PI_2 - PRESSURE_ANGLE) * k as f64 / FILLET as f64;
        let along = depth * lean.tan();
        let towards = Vector2::new(lean.sin(), -lean.cos());
        let point = pitch_point + towards * (depth / lean.cos() + rounding);
        on_gear(point, (along - aside) / radius)
    });
    let half = PI * m / 4.0 + thinner - shift * PRESSURE_ANGLE.tan();
    let action = Vector2::new(cos, -sin);
    let first = depth / sin + rounding;
    let base = pair.base_radius(i);
    let tip = pair.wheels[i].tip_radius;
    // Along the line of action, from the pitch point outwards.
    let last = radius * sin - (tip * tip - base * base).sqrt();
    let involute = (0..=FLANK).map(|k| {
        let t = first + (last - first) * k as f64 / FLANK as f64;
        on_gear(pitch_point + action * t, (t / cos - half) / radius)
    });
    fillet.chain(involute).collect()
}

/// The outline of gear `i`, against the clock from the middle of a gap that is on the x axis, mm; the last
/// point is not the first again.
pub fn outline(pair: &Pair, i: usize) -> Vec<Vector2<f64>> {
    let side = flank(pair, i);
    // The middle of a gap goes to the x axis.
    let turned = Rotation2::new(-FRAC_PI_2);
    let right: Vec<Vector2<f64>> = side.iter().map(|p| turned * p).collect();
    let teeth = pair.wheels[i].teeth;
    let pitch = TAU / teeth as f64;
    let mut points = Vec::new();
    for tooth in 0..teeth {
        let turn = Rotation2::new(pitch * tooth as f64);
        // Below the x axis from tip to root, then above it from root to tip.
        points.extend(right.iter().rev().map(|p| turn * p));
        points.extend(right.iter().map(|p| turn * Vector2::new(p.x, -p.y)));
    }
    points
}
