//! The tooth's cross section as a polygon.

use crate::design::Section;

/// Shorter necks are left out, mm: the bead's own arcs then reach down to the root. Lofts in CAD
/// programs mistake corners that lie so close together for each other.
const SHORTEST_NECK: f64 = 0.1;

/// Cross section as a closed counter-clockwise polygon in (n, b), mm: the contact point is the
/// origin, n points into the material, b away from the hub. The flank facing the contact starts
/// half the clearance behind it, with a corner exactly there.
///
/// The outline is a bead (flank arcs on both sides, cut off at the tip) on a neck as thick as the
/// rib that reaches down to the root. `segments` is the number of corners of a full flank circle.
pub fn polygon(section: &Section, segments: u32) -> Vec<[f64; 2]> {
    let radius = section.flank_circle();
    let flank = 0.5 * section.clearance;
    let arc_centre = flank + radius;
    let middle = flank + 0.5 * section.thickness;
    let neck = middle - 0.5 * section.rib.min(section.thickness);

    // Half of the outline on the contact side, from the root up to the tip.
    let neck_reach = ((arc_centre - neck).max(0.0) / radius).min(1.0);
    let neck_angle = neck_reach.acos();
    let has_neck = section.root > radius * neck_angle.sin() + SHORTEST_NECK;
    let low = if has_neck {
        neck_angle
    } else {
        (section.root / radius).min(1.0).asin()
    };
    let high = (section.tip / radius).min(1.0).asin();
    let steps =
        |angle: f64| ((f64::from(segments) * angle / std::f64::consts::TAU).round() as u32).max(1);
    let (below, above) = (steps(low), steps(high));
    let arc = |angle: f64| [arc_centre - radius * angle.cos(), radius * angle.sin()];
    let mut half = Vec::new();
    if has_neck {
        half.push([neck, -section.root]);
    }
    half.extend((0..below).map(|i| arc(-low * f64::from(below - i) / f64::from(below))));
    half.extend((0..=above).map(|i| arc(high * f64::from(i) / f64::from(above))));

    // The mirrored half upwards, then this half downwards: counter-clockwise.
    let mirrored = half.iter().map(|&[n, b]| [2.0 * middle - n, b]);
    let mut outline: Vec<[f64; 2]> = mirrored.chain(half.iter().rev().copied()).collect();
    outline.dedup_by(|p, q| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9);
    outline
}
