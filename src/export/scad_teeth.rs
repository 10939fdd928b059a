//! The teeth's stations as OpenSCAD data, and the proof that they may share one polyhedron.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::Result;
use crate::design::{Design, Gear, Section};
use crate::solid::kernel::Solid;
use crate::solid::rib::{self, Wall};
use crate::solid::sweep::{self, Frame};
use crate::solid::{Mesh, layout};

/// How much thicker the sections are for which disjointness is proved, mm: the Customizer's
/// clearance may move a tooth by half of its range without touching a neighbour.
pub const SPARE: f64 = 0.25;

/// Teeth of one gear.
#[derive(Debug, Clone, PartialEq)]
pub struct Teeth {
    /// The stations of every tooth.
    pub frames: Vec<Vec<Frame>>,
    /// How much the rib of every tooth thickens on either side, mm: on that of (n × b) × radial first.
    pub flares: Vec<[f64; 2]>,
    /// Point on the gear's axis.
    pub axis: Vector3<f64>,
    /// Middle height of every sub-gear pair, mm.
    pub bands: Vec<f64>,
    /// Where ribs end, distance from the axis, mm.
    pub foot: f64,
    /// Numbers of the teeth whose beads are disjoint, so that they may be shells of one polyhedron;
    /// every tooth is in one list.
    pub beads: Vec<Vec<usize>>,
    /// The same for the ribs.
    pub ribs: Vec<Vec<usize>>,
}

/// Stations and proofs of the teeth of `gear`.
///
/// # Errors
/// As [`sweep::tooth`] and [`rib::rib`].
pub fn teeth(design: &Design, gear: Gear) -> Result<Teeth> {
    let axis = sweep::axis_point(gear, design.settings.gear.center_distance_mm);
    let foot = layout::rib_foot(design, gear);
    let mut pairs: Vec<Vec<Vec<Frame>>> = vec![Vec::new(); design.sub_gear_pairs.len()];
    let mut flares = Vec::new();
    for tooth in sweep::standing(design, gear, sweep::MAX_STATIONS) {
        let (frames, flare) = forwards(tooth.frames, tooth.flare);
        pairs[tooth.pair].push(frames);
        flares.push(flare);
    }
    let mut own = flares.iter().copied();
    let bands = pairs.iter().map(|teeth| middle_height(teeth)).collect();
    let place = format!("{gear:?} tooth").to_lowercase();
    let (mut beads, mut ribs) = (Vec::new(), Vec::new());
    for (pair, teeth) in design.sub_gear_pairs.iter().zip(&pairs) {
        let thicker = thicker(&design.section_of(pair));
        for frames in teeth {
            beads.push(sweep::tooth(frames, &thicker, &place)?);
            let wall = Wall {
                section: thicker,
                axis,
                foot,
                flare: own.next().unwrap_or_default(),
            };
            ribs.push(wall.mesh(frames, &place)?);
        }
    }
    Ok(Teeth {
        frames: pairs.into_iter().flatten().collect(),
        flares,
        axis,
        bands,
        foot,
        beads: apart(&beads)?,
        ribs: apart(&ribs)?,
    })
}

/// A section that holds every one that the Customizer makes of `section`.
fn thicker(section: &Section) -> Section {
    Section {
        thickness: section.thickness + SPARE,
        flank_radius: section.flank_radius + 0.5 * SPARE,
        clearance: 0.0,
        // The wall may be as thick as the bead at the hub.
        rib: section.thickness + SPARE,
        ..*section
    }
}

/// The frames in the order in which n × b points forward, as the OpenSCAD functions want them, and the
/// flare with its sides as they are then.
fn forwards(mut frames: Vec<Frame>, mut flare: [f64; 2]) -> (Vec<Frame>, [f64; 2]) {
    let along: f64 = frames.iter().map(|f| f.n.cross(&f.b).dot(&f.t)).sum();
    if along < 0.0 {
        frames.reverse();
        frames.iter_mut().for_each(|f| f.t = -f.t);
        flare.reverse();
    }
    (frames, flare)
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

/// The numbers of the meshes in as few lists as come by taking one after the other, so that no two
/// of a list touch.
fn apart(meshes: &[Mesh]) -> Result<Vec<Vec<usize>>> {
    let solids: Result<Vec<Solid>> = meshes.iter().map(|m| Solid::new(m, "tooth")).collect();
    let solids = solids?;
    let boxes: Vec<_> = meshes.iter().map(Mesh::bounds).collect();
    let touch = |i: usize, j: usize| {
        let ((low, high), (from, to)) = (boxes[i], boxes[j]);
        let near = (0..3).all(|k| low[k] <= to[k] && from[k] <= high[k]);
        near && !disjoint(&solids[i], &solids[j])
    };
    let mut lists: Vec<Vec<usize>> = Vec::new();
    for i in 0..meshes.len() {
        let free = |list: &&mut Vec<usize>| list.iter().all(|&j| !touch(i, j));
        match lists.iter_mut().find(free) {
            Some(list) => list.push(i),
            None => lists.push(vec![i]),
        }
    }
    Ok(lists)
}

/// Whether two solids do not touch: their union then has two components, and the sum of their
/// volumes.
fn disjoint(a: &Solid, b: &Solid) -> bool {
    let (union, sum) = (a.union(b), a.volume() + b.volume());
    union.components() == 2 && (union.volume() - sum).abs() <= 1e-9 * sum
}

impl Teeth {
    /// One line of OpenSCAD per tooth, with at most `most` stations: `[[x, y, z, turn], …]`, where the
    /// three numbers of the turn are its axis times its angle in degrees.
    pub fn lines(&self, most: usize) -> Vec<String> {
        let chosen = |frames: &Vec<Frame>| {
            let kept = sweep::thinned(frames.len(), most).into_iter();
            let stations: Vec<String> = kept.map(|i| station(&frames[i])).collect();
            format!("[{}]", stations.join(","))
        };
        self.frames.iter().map(chosen).collect()
    }

    /// The flares as an OpenSCAD list.
    pub fn flare_list(&self) -> String {
        let pair = |flare: &[f64; 2]| format!("[{}]", flare.map(|f| number(f, 3)).join(","));
        let pairs: Vec<String> = self.flares.iter().map(pair).collect();
        format!("[{}]", pairs.join(", "))
    }

    /// How many of `most` stations at either end of a tooth have no rib.
    pub fn inset(most: usize) -> usize {
        (rib::INSET * most + sweep::MAX_STATIONS / 2) / sweep::MAX_STATIONS
    }
}

/// Point and turn of a frame: the turn takes x to n and y to b.
fn station(frame: &Frame) -> String {
    let columns = Matrix3::from_columns(&[frame.n, frame.b, frame.n.cross(&frame.b)]);
    let turn = Rotation3::from_matrix_unchecked(columns);
    // By way of a quaternion: a half turn has no axis in its matrix alone.
    let turn = UnitQuaternion::from_rotation_matrix(&turn).scaled_axis();
    let point = frame.p.iter().map(|&c| number(c, 4));
    let turn = turn.iter().map(|&c| number(c.to_degrees(), 3));
    let numbers: Vec<String> = point.chain(turn).collect();
    format!("[{}]", numbers.join(","))
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
    fn a_turn_of_a_half_is_told_by_its_axis() {
        let frame = Frame {
            phi: 0.0,
            p: Vector3::new(1.0, -2.5, 0.0),
            n: -Vector3::x(),
            b: Vector3::y(),
            t: -Vector3::z(),
        };
        let text = station(&frame);
        assert!(
            ["[1,-2.5,0,0,180,0]", "[1,-2.5,0,0,-180,0]"].contains(&text.as_str()),
            "{text}"
        );
    }

    #[test]
    fn thinned_teeth_keep_their_ends() {
        let frame = |i: u32| Frame {
            phi: 0.0,
            p: Vector3::new(f64::from(i), 0.0, 0.0),
            n: Vector3::x(),
            b: Vector3::y(),
            t: Vector3::z(),
        };
        let teeth = Teeth {
            frames: vec![(0..33).map(frame).collect()],
            flares: vec![[0.0; 2]],
            axis: Vector3::zeros(),
            bands: Vec::new(),
            foot: 0.0,
            beads: Vec::new(),
            ribs: Vec::new(),
        };
        let text = teeth.lines(3);
        assert_eq!(text, ["[[0,0,0,0,0,0],[16,0,0,0,0,0],[32,0,0,0,0,0]]"]);
        assert_eq!(
            (Teeth::inset(25), Teeth::inset(17), Teeth::inset(9)),
            (1, 1, 0)
        );
    }

    #[test]
    fn touching_meshes_are_kept_in_different_lists() {
        let cube = crate::solid::kernel::lathe(&[(1.0, 0.0), (1.0, 1.0)], 4);
        let at = |x: f64| {
            let mut moved = cube.clone();
            moved.vertices.iter_mut().for_each(|v| v[0] += x);
            moved
        };
        let row = [0.0, 1.5, 3.0, 7.0].map(at);
        assert_eq!(apart(&row).expect("sound"), [vec![0, 2, 3], vec![1]]);
    }
}
