//! The tooth's cross section as a polygon.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::design::Section;

/// Shorter necks are left out, mm: the bead's own arcs then reach down to the root. Lofts in CAD
/// programs mistake corners that lie so close together for each other.
const SHORTEST_NECK: f64 = 0.1;

/// The tip of a flat flank is at least so wide, mm, for the same reason.
const NARROWEST: f64 = 0.1;

/// Cross section as a closed counter-clockwise polygon in (n, b), mm: the contact point is the
/// origin, n points into the material, b away from the hub. The flank facing the contact starts
/// half the clearance behind it, with a corner exactly there.
///
/// The outline is a bead (flank arcs on both sides, cut off at the tip) on a neck as thick as the
/// rib that reaches down to the root. Flat flanks end in rounded edges, at the root no more than the
/// bead stands out over the rib.
/// `segments` is the number of corners of a full circle as thick as the tooth.
pub fn polygon(section: &Section, segments: u32) -> Vec<[f64; 2]> {
    let side = Side::new(section);
    // Chords leave arcs of every radius by the same distance.
    let fineness = f64::from(segments) / TAU / side.middle.sqrt();
    // The contact side, from the root up to the tip.
    let mut half = side.up(side.below(section), fineness);
    if side.neck(section).is_some() {
        half.push([side.flank + side.rib, section.root]);
    }
    half.iter_mut().for_each(|c| c[1] = -c[1]);
    half.reverse();
    half.pop();
    half.extend(side.up(side.above(section), fineness));

    // The mirrored half upwards, then this half downwards: counter-clockwise.
    let middle = side.flank + side.middle;
    let mirrored = half.iter().map(|&[n, b]| [2.0 * middle - n, b]);
    let mut outline: Vec<[f64; 2]> = mirrored.chain(half.iter().rev().copied()).collect();
    outline.dedup_by(|p, q| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9);
    outline
}

/// Angle to either side of the contact that belongs to the flank where it is flat, rad: the contact
/// stays on it when a gear tilts by half of that, in whatever direction.
pub const FLANK: f64 = 0.15;

/// No edge of a flat flank is sharper, mm.
const SHARPEST: f64 = 0.2;

/// Corners of an edge for each that a flank as round would have: nothing touches there.
const EDGE_FINENESS: f64 = 0.6;

/// Radius of the edge between a flat flank and the end of the section `height` above (or below) the
/// contact, mm: the flank takes [`FLANK`], the edge the rest, so that it grows to the round bead as the
/// flank does. 0 on a round bead.
pub fn edge(section: &Section, height: f64) -> f64 {
    let (radius, half) = (section.flank_radius, 0.5 * (section.thickness - NARROWEST));
    if !section.is_flat() || radius <= height {
        return 0.0;
    }
    let rest = (height - FLANK * radius) / (1.0 - FLANK);
    // What the flanks of a tooth leave between its edges.
    let widest = (half * (2.0 * radius - half) - height * height) / (2.0 * (radius - height));
    rest.max(SHARPEST).min(widest).clamp(0.0, height)
}

/// Least height of the flank above or below the contact, mm: beyond it are the edges or the neck.
pub fn flank_height(section: &Section) -> f64 {
    let side = Side::new(section);
    let height = |end: [f64; 2]| side.radius * side.turn(end).sin();
    height(side.below(section)).min(height(side.above(section)))
}

/// One side of a section.
struct Side {
    /// n of the flank at the contact's height.
    flank: f64,
    radius: f64,
    /// The section's middle behind the flank.
    middle: f64,
    /// The rib's side behind the flank.
    rib: f64,
}

impl Side {
    fn new(section: &Section) -> Side {
        Side {
            flank: 0.5 * section.clearance,
            radius: section.flank_radius,
            middle: 0.5 * section.thickness,
            rib: 0.5 * (section.thickness - section.rib.min(section.thickness)),
        }
    }

    /// Depth below the contact at which the flank meets the neck, where there is one.
    fn neck(&self, section: &Section) -> Option<f64> {
        let cosine = ((self.radius - self.rib).max(0.0) / self.radius).min(1.0);
        let depth = self.radius * cosine.acos().sin();
        (section.root > depth + SHORTEST_NECK).then_some(depth)
    }

    /// How far the bead reaches below the contact, and the radius of its edge there.
    fn below(&self, section: &Section) -> [f64; 2] {
        match self.neck(section) {
            Some(depth) => [depth, 0.0],
            None => [section.root, edge(section, section.root).min(self.rib)],
        }
    }

    /// The same above the contact.
    fn above(&self, section: &Section) -> [f64; 2] {
        [section.tip, edge(section, section.tip)]
    }

    /// Angle of the flank up to the edge of radius `edge` that ends at `height`.
    fn turn(&self, [height, edge]: [f64; 2]) -> f64 {
        // No farther than to where both flanks of the tooth meet.
        let meet = (1.0 - self.middle / self.radius).max(0.0).acos();
        match edge > 0.0 {
            true => ((height - edge) / (self.radius - edge))
                .clamp(0.0, 1.0)
                .asin(),
            false => (height / self.radius).min(1.0).asin().min(meet),
        }
    }

    /// Corners from the contact's height up to an end.
    fn up(&self, end: [f64; 2], fineness: f64) -> Vec<[f64; 2]> {
        let (radius, [_, edge], turn) = (self.radius, end, self.turn(end));
        let centre = [self.flank + radius, 0.0];
        let mut corners = arc((radius, fineness), centre, [0.0, turn]);
        if edge > 0.0 {
            let away = radius - edge;
            let centre = [centre[0] - away * turn.cos(), away * turn.sin()];
            corners.pop();
            corners.extend(arc(
                (edge, EDGE_FINENESS * fineness),
                centre,
                [turn, FRAC_PI_2],
            ));
        }
        corners
    }
}

/// Corners of an arc, both ends included; angles from −n towards +b.
fn arc((radius, fineness): (f64, f64), [n, b]: [f64; 2], [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let steps = (fineness * radius.sqrt() * (to - from) - 1e-3)
        .ceil()
        .max(1.0);
    (0..=steps as u32)
        .map(|i| from + (to - from) * f64::from(i) / steps)
        .map(|angle| [n - radius * angle.cos(), b + radius * angle.sin()])
        .collect()
}
