//! A tooth: the fixed cross section carried along the contact curve.

use nalgebra::Vector3;

use super::Mesh;
use super::section;
use crate::design::{Design, Gear, Section, ToothPair};
use crate::motion::{Drive, Pose};
use crate::{Error, Result};

/// Most stations of a swept tooth; longer lists are thinned evenly. The chords leave the sharpest
/// of curves by 5 µm, usual ones by 2 µm.
pub const MAX_STATIONS: usize = 25;

/// Corners of a full flank circle in the section polygon.
pub const SECTION_SEGMENTS: u32 = 24;

/// Where the cross section stands at one station, in the gear's own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Phase of the contact, rad.
    pub phi: f64,
    /// Contact point, mm.
    pub p: Vector3<f64>,
    /// Unit normal into the material.
    pub n: Vector3<f64>,
    /// Unit vector across, pointing away from the gear's axis.
    pub b: Vector3<f64>,
    /// Unit tangent of the contact curve.
    pub t: Vector3<f64>,
}

impl Frame {
    /// Section coordinates (n, b) → gear frame.
    pub fn place(&self, [n, b]: [f64; 2]) -> Vector3<f64> {
        self.p + n * self.n + b * self.b
    }

    /// The frame as `pose` moves it.
    fn moved(&self, pose: &Pose) -> Frame {
        let [n, b, t] = [self.n, self.b, self.t].map(|v| pose.rotation * v);
        Frame {
            p: pose.apply(self.p),
            n,
            b,
            t,
            ..*self
        }
    }
}

/// A tooth as it stands on its gear.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Its sub-gear pair, from 0.
    pub pair: usize,
    /// Its number around the gear in order of contact, from 0: tooth pair j, then its copies J₂ further on.
    pub number: usize,
    /// Its frames.
    pub frames: Vec<Frame>,
    /// By how much its rib thickens ([`ToothPair::flare`]).
    pub flare: [f64; 2],
}

/// All teeth of `gear`, at `most` stations each: pair by pair in order of contact.
pub fn standing(design: &Design, gear: Gear, most: usize) -> Vec<Standing> {
    let drive = design.settings.gear.drive();
    let pairs = design.sub_gear_pairs.iter().enumerate();
    pairs
        .flat_map(|(pair, band)| {
            around(&band.teeth, gear, (drive, most)).map(move |(number, frames)| Standing {
                pair,
                number,
                frames,
                flare: band.teeth[number % band.teeth.len()].flare[gear as usize],
            })
        })
        .collect()
}

/// The teeth of one band as they stand around `gear`, numbered from 0 ([`Standing::number`]), at `most`
/// stations each.
pub fn around(
    teeth: &[ToothPair],
    gear: Gear,
    (drive, most): (Drive, usize),
) -> impl Iterator<Item = (usize, Vec<Frame>)> {
    let axis = axis_point(gear, drive.center_distance());
    let own: Vec<_> = teeth
        .iter()
        .map(|tooth| frames_at(tooth, gear, axis, most))
        .collect();
    let count = own.len();
    (0..copies(drive, gear) * count).map(move |number| {
        let frames = &own[number % count];
        let frames = match number / count {
            0 => frames.clone(),
            copy => {
                let pose = drive.copy(copy);
                frames.iter().map(|f| f.moved(&pose)).collect()
            }
        };
        (number, frames)
    })
}

/// How often every tooth of one period stands on `gear`.
pub fn copies(drive: Drive, gear: Gear) -> usize {
    match gear {
        Gear::Driver => drive.copies(),
        Gear::Follower => 1,
    }
}

/// A point on the gear's own axis, which is parallel to z in the gear's frame, mm.
pub fn axis_point(gear: Gear, center_distance: f64) -> Vector3<f64> {
    match gear {
        Gear::Driver => Vector3::new(-center_distance, 0.0, 0.0),
        Gear::Follower => Vector3::zeros(),
    }
}

/// Which of a tooth's `stations` carry a frame.
pub fn chosen(stations: usize) -> Vec<usize> {
    thinned(stations, MAX_STATIONS)
}

/// At most `most` of a tooth's `stations`, evenly thinned, both ends included.
pub fn thinned(stations: usize, most: usize) -> Vec<usize> {
    let last = stations.saturating_sub(1);
    let count = stations.min(most);
    (0..count)
        .map(|i| (i * last) / (count - 1).max(1))
        .collect()
}

/// The section's frames along a tooth of `gear`, whose axis passes through `axis`.
pub fn frames(tooth: &ToothPair, gear: Gear, axis: Vector3<f64>) -> Vec<Frame> {
    frames_at(tooth, gear, axis, MAX_STATIONS)
}

/// The same at `most` stations.
pub fn frames_at(tooth: &ToothPair, gear: Gear, axis: Vector3<f64>, most: usize) -> Vec<Frame> {
    let mut frames: Vec<Frame> = thinned(tooth.stations.len(), most)
        .into_iter()
        .map(|i| {
            let station = &tooth.stations[i];
            let (p, n, t) = station.frame(gear);
            Frame {
                phi: station.phi,
                p,
                n,
                b: t.cross(&n).normalize(),
                t,
            }
        })
        .collect();
    // One sign for the whole tooth: the one that points outwards along most of it.
    let outwards: f64 = frames
        .iter()
        .map(|f| (f.p - axis).xy().dot(&f.b.xy()))
        .sum();
    if outwards < 0.0 {
        frames.iter_mut().for_each(|f| f.b = -f.b);
    }
    frames
}

/// The closed mesh of one tooth, outward winding; `place` names the tooth in errors.
///
/// # Errors
/// [`Error::Infeasible`] when the sweep folds: a point of the section moves backwards along the
/// tangent because the curve bends or twists more sharply than the section is high.
pub fn tooth(frames: &[Frame], section: &Section, place: &str) -> Result<Mesh> {
    let outline = section::polygon(section, SECTION_SEGMENTS);
    let rings: Vec<Vec<Vector3<f64>>> = frames
        .iter()
        .map(|frame| outline.iter().map(|&c| frame.place(c)).collect())
        .collect();
    skin(frames, &rings, place)
}

/// Skin over one ring of points per frame, capped at both ends, after checking that every point
/// moves forward along the tangent. The edges of a ring's first half lie opposite those of its
/// second, and the diagonals on both sides are parallel: what a twisted wall loses against the ruled
/// surface on one side it gains on the other. Equal turning directions would make it 1 % too thick
/// or too thin.
///
/// # Errors
/// As [`tooth`].
pub(super) fn skin(frames: &[Frame], rings: &[Vec<Vector3<f64>>], place: &str) -> Result<Mesh> {
    if rings.len() < 2 {
        return Err(Error::Internal(format!("{place}: fewer than two stations")));
    }
    for (k, pair) in rings.windows(2).enumerate() {
        let tangent = frames[k].t + frames[k + 1].t;
        let forward = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (b - a).dot(&tangent) > 0.0;
        if !pair[0].iter().zip(&pair[1]).all(forward) {
            return Err(Error::Infeasible {
                reason: "twisted tooth: the swept cross section folds over itself".into(),
                place: format!("{place}, φ = {:.1}°", frames[k].phi.to_degrees()),
                hint: "smaller motion, more teeth (gear.teeth), or a smaller section (gear.tip_mm, gear.root_mm)".into(),
            });
        }
    }
    let corners = rings[0].len() as u32;
    let mut mesh = Mesh {
        vertices: rings.iter().flatten().map(|&v| v.into()).collect(),
        triangles: Vec::new(),
    };
    for ring in 0..rings.len() as u32 - 1 {
        for i in 0..corners {
            let (a, b) = (ring * corners + i, ring * corners + (i + 1) % corners);
            if 2 * i < corners {
                mesh.triangles.push([a, b, b + corners]);
                mesh.triangles.push([a, b + corners, a + corners]);
            } else {
                mesh.triangles.push([a, b, a + corners]);
                mesh.triangles.push([b, b + corners, a + corners]);
            }
        }
    }
    let top = (rings.len() as u32 - 1) * corners;
    // Caps as strips between the two halves of the outline, which is narrower at its neck.
    let (mut low, mut high) = (0, corners - 1);
    let mut cap = |a: u32, b: u32, c: u32| {
        mesh.triangles.push([a, c, b]);
        mesh.triangles.push([top + a, top + b, top + c]);
    };
    while high - low > 1 {
        cap(low, low + 1, high);
        low += 1;
        if high - low > 1 {
            cap(low, high - 1, high);
            high -= 1;
        }
    }
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(mesh)
}
