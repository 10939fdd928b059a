//! The teeth's stations as OpenSCAD data, and the proof that they may share one polyhedron.

use nalgebra::Vector3;

use crate::Result;
use crate::design::{Design, Gear, Section};
use crate::solid::kernel::Solid;
use crate::solid::sweep::{self, Frame};
use crate::solid::{Mesh, layout, rib};

/// How much thicker the sections are for which disjointness is proved, mm: the Customizer's
/// clearance may move a tooth by half of its range without touching a neighbour.
pub const SPARE: f64 = 0.25;

/// Teeth of one gear.
#[derive(Debug, Clone, PartialEq)]
pub struct Teeth {
    /// One line of OpenSCAD per tooth: `[[point, n, b], …]`.
    pub stations: Vec<String>,
    /// Point on the gear's axis.
    pub axis: Vector3<f64>,
    /// Middle height of every sub-gear pair, mm.
    pub bands: Vec<f64>,
    /// Where ribs end, distance from the axis, mm.
    pub foot: f64,
    /// Whether all beads are disjoint, so that they may be shells of one polyhedron.
    pub beads_apart: bool,
    /// The same for the ribs.
    pub ribs_apart: bool,
}

/// Stations and proofs of the teeth of `gear`.
///
/// # Errors
/// As [`sweep::tooth`] and [`rib::rib`].
pub fn teeth(design: &Design, gear: Gear) -> Result<Teeth> {
    let axis = sweep::axis_point(gear, design.settings.gear.center_distance_mm);
    let foot = layout::rib_foot(design, gear);
    let pairs = design.sub_gear_pairs.iter().map(|pair| {
        let teeth = pair.teeth.iter();
        teeth
            .map(|tooth| forwards(sweep::frames(tooth, gear, axis)))
            .collect()
    });
    let pairs: Vec<Vec<Vec<Frame>>> = pairs.collect();
    let bands = pairs.iter().map(|teeth| middle_height(teeth)).collect();
    let frames: Vec<Vec<Frame>> = pairs.into_iter().flatten().collect();
    let section = &design.section;
    let thicker = Section {
        thickness: section.thickness + SPARE,
        flank_radius: section.flank_radius + 0.5 * SPARE,
        clearance: 0.0,
        // The wall may be as thick as the bead at the hub.
        rib: section.thickness + SPARE,
        ..*section
    };
    let place = format!("{gear:?} tooth").to_lowercase();
    let beads: Result<Vec<Mesh>> = frames
        .iter()
        .map(|f| sweep::tooth(f, &thicker, &place))
        .collect();
    let ribs: Result<Vec<Mesh>> = frames
        .iter()
        .map(|f| rib::rib(f, &thicker, (axis, foot), &place))
        .collect();
    Ok(Teeth {
        stations: frames.iter().map(|f| line(f)).collect(),
        axis,
        bands,
        foot,
        beads_apart: disjoint(&beads?)?,
        ribs_apart: disjoint(&ribs?)?,
    })
}

/// The frames in the order in which n × b points forward, as the OpenSCAD functions want them.
fn forwards(mut frames: Vec<Frame>) -> Vec<Frame> {
    let along: f64 = frames.iter().map(|f| f.n.cross(&f.b).dot(&f.t)).sum();
    if along < 0.0 {
        frames.reverse();
        frames.iter_mut().for_each(|f| f.t = -f.t);
    }
    frames
}

/// Halfway between the lowest and the highest contact of some teeth.
fn middle_height(teeth: &[Vec<Frame>]) -> f64 {
    let heights = || teeth.iter().flatten().map(|f| f.p.z);
    let (low, high) = (
        heights().fold(f64::INFINITY, f64::min),
        heights().fold(f64::NEG_INFINITY, f64::max),
    );
    0.5 * (low + high)
}

/// Whether no two of the meshes touch: their union then has as many components as there are
/// meshes, and the sum of their volumes.
fn disjoint(meshes: &[Mesh]) -> Result<bool> {
    let solids: Result<Vec<Solid>> = meshes.iter().map(|m| Solid::new(m, "tooth")).collect();
    let union = Solid::union_of(&solids?);
    let sum: f64 = meshes.iter().map(Mesh::volume).sum();
    Ok(union.components() == meshes.len() && (union.volume() - sum).abs() <= 1e-9 * sum)
}

fn line(frames: &[Frame]) -> String {
    let station = |f: &Frame| {
        let [p, n, b] = [(f.p, 4), (f.n, 6), (f.b, 6)].map(|(v, digits)| vector(v, digits));
        format!("[{p}, {n}, {b}]")
    };
    let stations: Vec<String> = frames.iter().map(station).collect();
    format!("[{}]", stations.join(", "))
}

fn vector(v: Vector3<f64>, digits: usize) -> String {
    let [x, y, z] = [v.x, v.y, v.z].map(|c| number(c, digits));
    format!("[{x}, {y}, {z}]")
}

/// A number with at most `digits` decimals and nothing superfluous.
pub fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match text {
        "-0" | "" => "0".into(),
        text => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (1.5, "1.5"),
            (-0.00001, "0"),
            (10.0, "10"),
            (0.12345, "0.1235"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value, 4), text);
        }
    }

    #[test]
    fn touching_meshes_are_not_disjoint() {
        let cube = crate::solid::kernel::lathe(&[(1.0, 0.0), (1.0, 1.0)], 4);
        let at = |x: f64| {
            let mut moved = cube.clone();
            moved.vertices.iter_mut().for_each(|v| v[0] += x);
            moved
        };
        assert!(disjoint(&[at(0.0), at(3.0)]).expect("sound"));
        assert!(!disjoint(&[at(0.0), at(1.5)]).expect("sound"));
    }
}
