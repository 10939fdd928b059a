//! A tooth and its rib as a grid of elements along the sweep.
//!
//! Across the rib and the bead it has the same columns, upwards first the rows of the rib and then those of
//! the bead, along it layers. Beyond both ends of the rib only the bead is there.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Matrix3, Vector2, Vector3};

use super::Hub;
use super::bead::Bead;
use super::elastic_body::Grid;
use super::elements;
use crate::design::{Gear, Section, ToothPair};
use crate::solid::rib::{self, Wall};
use crate::solid::sweep::{self, Frame};

/// Layers along each end that no rib carries, and along the rest, at fineness 1.
const END_LAYERS: usize = 2;
const RIB_LAYERS: usize = 6;

/// Heights of the rows at the rib's root, in its thickness, at fineness 1: the second lies half a thickness
/// above the hub, the fourth one and a half.
const ROOT: [f64; 5] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 4.0 / 3.0, 5.0 / 3.0];

/// Middles of those two, counted in rows.
const READ_AT: [f64; 2] = [1.5, 3.5];

/// Rows of the rib above, and rows of the bead.
const UPPER_ROWS: usize = 2;
const BEAD_ROWS: usize = 2;

const RIB_ROWS: usize = ROOT.len() - 1 + UPPER_ROWS;

/// What counts as the thickness of a low rib, as a share of its height.
const ROOT_SHARE: f64 = 0.4;

/// Least height of a rib as a share of its thickness: where a bead nearly touches the hub, the hub is taken
/// as so much smaller.
const LEAST_HEIGHT: f64 = 0.5;

/// A tooth of a gear, continuous along its sweep.
#[derive(Debug)]
pub struct Tooth {
    frames: Vec<Frame>,
    section: Section,
    hub: Hub,
    /// Shares of the contact interval at which the rib begins and ends.
    rib: (f64, f64),
    wall: Wall,
    /// How far from the axis the rib ends, mm.
    foot: f64,
}

/// The cross section somewhere.
struct Plane {
    frame: Frame,
    bead: Bead,
    /// Ends of the rib's two sides at the hub, mm.
    feet: [Vector3<f64>; 2],
    /// Height of the rib, mm.
    height: f64,
    /// Whether a hub is there.
    clamped: bool,
}

impl Tooth {
    /// The tooth of a pair that belongs to `gear`; `None` with too few stations.
    pub fn new(pair: &ToothPair, gear: Gear, section: Section, hub: Hub) -> Option<Tooth> {
        let count = pair.stations.len();
        let chosen = sweep::chosen(count);
        let span = rib::span(&chosen);
        let share = |station: Option<&usize>| Some(*station? as f64 / (count - 1) as f64);
        let rib = (share(span.first())?, share(span.last())?);
        let frames = sweep::frames_at(pair, gear, hub.axis, usize::MAX);
        let wall = Wall {
            section,
            axis: hub.axis,
            foot: hub.foot,
            flare: pair.flare[gear as usize],
        };
        let ribbed = *span.first()?..*span.last()? + 1;
        let foot = wall.reaches_to(frames.get(ribbed)?);
        (frames.len() >= 4).then_some(Tooth {
            frames,
            section,
            hub,
            rib,
            wall,
            foot,
        })
    }

    /// Frame at a share of the contact interval: cubic through the four nearest stations.
    pub fn frame(&self, share: f64) -> Frame {
        let last = self.frames.len() - 1;
        let x = share * last as f64;
        let first = (x as usize).saturating_sub(1).min(last - 3);
        let near = &self.frames[first..first + 4];
        let weights: [f64; 4] = std::array::from_fn(|i| {
            let others = (0..4).filter(|&m| m != i).map(|m| m as f64);
            let x = x - first as f64;
            others.map(|m| (x - m) / (i as f64 - m)).product()
        });
        let blend = |get: fn(&Frame) -> Vector3<f64>| -> Vector3<f64> {
            near.iter()
                .zip(weights)
                .map(|(frame, w)| w * get(frame))
                .sum()
        };
        Frame {
            phi: near.iter().zip(weights).map(|(f, w)| w * f.phi).sum(),
            p: blend(|f| f.p),
            n: blend(|f| f.n).normalize(),
            b: blend(|f| f.b).normalize(),
            t: blend(|f| f.t).normalize(),
        }
    }

    /// The cross section at a share of the contact interval; `None` where the tooth runs straight towards
    /// the axis.
    fn plane(&self, share: f64) -> Option<Plane> {
        let (frame, section, hub) = (self.frame(share), &self.section, &self.hub);
        let [middle, _, _] = rib::line(&frame, section, hub.axis, 0.0);
        let outwards = (middle - hub.axis).component_mul(&Vector3::new(1.0, 1.0, 0.0));
        let radial = outwards.try_normalize(1e-6)?;
        // Towards the hub within the section, and across the rib.
        let down = -Vector2::new(radial.dot(&frame.n), radial.dot(&frame.b)).try_normalize(1e-3)?;
        let across = -down.y * frame.n + down.x * frame.b;
        let centre = Vector2::new(0.5 * (section.clearance + section.thickness), 0.0);
        let bead = Bead::new(section, (centre, down), 0.5 * section.rib)?;
        let [left, right] = bead.chord();
        let neck = frame.place((0.5 * (left + right)).into());
        let away = (neck - hub.axis).xy().norm();
        let drum = hub.radius_at(middle.z);
        let radius = drum.unwrap_or(hub.foot);
        let radius = radius.min(away - LEAST_HEIGHT * section.rib).max(0.0);
        let foot = middle - (outwards.norm() - radius) * radial;
        let share = (outwards.norm() - radius) / (outwards.norm() - self.foot).max(1e-6);
        let mut halves = self.wall.halves(share.clamp(0.0, 1.0));
        if frame.t.cross(&radial).dot(&across) < 0.0 {
            halves.reverse();
        }
        Some(Plane {
            height: (neck - foot).norm(),
            frame,
            bead,
            feet: [foot + halves[0] * across, foot - halves[1] * across],
            clamped: drum.is_some(),
        })
    }

    /// Height over the hub, mm, at `y` rows of fineness 1.
    fn height(&self, plane: &Plane, y: f64) -> f64 {
        let root = self.section.rib.min(ROOT_SHARE * plane.height);
        let rest = ROOT.len() - 1;
        let i = (y as usize).min(rest - 1);
        let below = root * (ROOT[i] + (y - i as f64).min(1.0) * (ROOT[i + 1] - ROOT[i]));
        let above = (y - rest as f64).max(0.0) / UPPER_ROWS as f64;
        below + above * (plane.height - root * ROOT[rest])
    }

    /// The point of a cross section at `x` across (0 to 1) and `y` upwards, counted in rows of fineness 1.
    fn point(&self, plane: &Plane, x: f64, y: f64) -> Vector3<f64> {
        let rows = RIB_ROWS as f64;
        let place = |v: Vector2<f64>| plane.frame.place(v.into());
        if y >= rows {
            return place(plane.bead.at(x, (y - rows) / BEAD_ROWS as f64));
        }
        let [left, right] = plane.bead.chord().map(place);
        let [foot_left, foot_right] = plane.feet;
        let share = self.height(plane, y) / plane.height;
        let foot = foot_left + x * (foot_right - foot_left);
        foot + share * (left + x * (right - left) - foot)
    }
}

/// A point of an element: which, and where on the reference cube.
type Place = (usize, [f64; 3]);

/// A tooth cut into elements.
#[derive(Debug)]
pub struct ToothGrid {
    /// The elements; nodes at the hub are fixed.
    pub grid: Grid,
    fineness: usize,
    /// Shares of the contact interval between the layers.
    shares: Vec<f64>,
    /// The layers that the rib carries.
    carried: Range<usize>,
}

impl ToothGrid {
    /// Cuts `tooth`; every element of fineness 1 is cut into `fineness` along each direction. `None` where a
    /// cross section does not exist or nothing holds the tooth.
    pub fn new(tooth: &Tooth, fineness: usize) -> Option<ToothGrid> {
        let (begin, end) = tooth.rib;
        let mut shares = vec![0.0];
        let mut add = |to: f64, layers: usize| {
            let from = shares[shares.len() - 1];
            let layers = if to > from { layers * fineness } else { 0 };
            shares.extend((1..=layers).map(|i| from + (to - from) * i as f64 / layers as f64));
            shares.len() - 1
        };
        let first = add(begin, END_LAYERS);
        let carried = first..add(end, RIB_LAYERS);
        add(1.0, END_LAYERS);
        let between = shares.windows(2).map(|s| 0.5 * (s[0] + s[1]));
        let mut halves = vec![0.0];
        halves.extend(
            between
                .zip(&shares[1..])
                .flat_map(|(middle, &to)| [middle, to]),
        );
        let planes: Vec<Plane> = halves
            .iter()
            .map(|&s| tooth.plane(s))
            .collect::<Option<_>>()?;

        let fine = fineness as f64;
        // Columns run from the chord's first end to its other, against the sense from n to b.
        let mirrored = {
            let frame = &planes[0].frame;
            frame.n.cross(&frame.b).dot(&frame.t) > 0.0
        };
        let rows = (RIB_ROWS + BEAD_ROWS) * fineness;
        let counts = [fineness, rows, shares.len() - 1];
        let exists =
            |[_, row, layer]: [usize; 3]| row >= RIB_ROWS * fineness || carried.contains(&layer);
        let mut grid = Grid::new(counts, exists, |[i, j, k]| {
            let x = 0.5 * i as f64 / fine;
            let x = if mirrored { 1.0 - x } else { x };
            tooth.point(&planes[k], x, 0.5 * j as f64 / fine)
        });
        let held = |[_, j, k]: [usize; 3]| j == 0 && planes[k].clamped;
        for (fixed, half) in grid.fixed.iter_mut().zip(&grid.halves) {
            *fixed = [held(*half); 3];
        }
        Some(ToothGrid {
            grid,
            fineness,
            shares,
            carried,
        })
    }

    /// Weights of the nodes that a force spread evenly over the bead's cross section at a share of the
    /// contact interval has.
    ///
    /// The middle of the section lies on the line of the contact force; what the spot of contact itself gives
    /// is Hertz's.
    pub fn section_weights(&self, share: f64) -> Vec<(usize, f64)> {
        let last = self.shares.len() - 1;
        let layer = self.shares.partition_point(|&s| s <= share).clamp(1, last) - 1;
        let (from, to) = (self.shares[layer], self.shares[layer + 1]);
        let z = 2.0 * (share - from) / (to - from) - 1.0;
        let mut weights: Vec<(usize, f64)> = Vec::new();
        let mut area = 0.0;
        let rib_rows = RIB_ROWS * self.fineness;
        for (element, cell) in self.grid.cells.iter().enumerate() {
            if cell[2] != layer || cell[1] < rib_rows {
                continue;
            }
            for [x, y, _] in &elements::points()[..4] {
                let at = [*x, *y, z];
                let corners = self.grid.corners(element);
                let slopes = elements::slopes(at);
                let along = |axis: usize| -> Vector3<f64> {
                    corners.iter().zip(&slopes).map(|(c, s)| s[axis] * c).sum()
                };
                let piece = along(0).cross(&along(1)).norm();
                area += piece;
                let nodes = self.grid.elements[element].iter();
                weights.extend(nodes.zip(elements::shape(at)).map(|(&n, w)| (n, piece * w)));
            }
        }
        weights.iter_mut().for_each(|(_, w)| *w /= area);
        weights
    }

    /// Stresses, MPa, at the root and beside the ends of the rib, of those that `stresses` has at the
    /// integration points of an element.
    ///
    /// Each is extrapolated from half a step and one and a half steps away: linear, as the surface stress of
    /// bending is, and without the singularity of the corner (hot-spot stress; Hobbacher, "Recommendations for
    /// Fatigue Design of Welded Joints and Components", IIW-2259-15).
    pub fn hottest(
        &self,
        stresses: impl Fn(usize) -> [Matrix3<f64>; elements::POINTS],
    ) -> impl Iterator<Item = Matrix3<f64>> {
        let mut known = BTreeMap::new();
        let mut mean = |places: &[Place]| -> Matrix3<f64> {
            let at = |(element, x): &Place| {
                let stresses = known.entry(*element).or_insert_with(|| stresses(*element));
                elements::between_points(stresses, *x)
            };
            places.iter().map(at).sum::<Matrix3<f64>>() / places.len() as f64
        };
        let pairs = [self.over_the_root(), self.beside_the_rib()].concat();
        let spots = pairs
            .iter()
            .map(|[near, far]| 1.5 * mean(near) - 0.5 * mean(far));
        spots.collect::<Vec<_>>().into_iter()
    }

    /// Pairs of places on both sides of the rib over its foot, half as high and one and a half times as high
    /// as a root row: stress at the root is extrapolated from them, beyond the reach of the clamp's corner.
    fn over_the_root(&self) -> Vec<[Vec<Place>; 2]> {
        let along = 1.0 / 3.0_f64.sqrt();
        let mut pairs = Vec::new();
        for layer in self.carried.clone() {
            for (column, x) in self.sides() {
                for z in [-along, along] {
                    let at = |row: f64| -> Vec<Place> {
                        let places = self.either_side(row);
                        let place = |(row, y): (usize, f64)| {
                            Some((self.element([column, row, layer])?, [x, y, z]))
                        };
                        places.into_iter().filter_map(place).collect()
                    };
                    pairs.push(READ_AT.map(at));
                }
            }
        }
        pairs
    }

    /// The same at the ends of the rib, on the bead that stands out beyond: a quarter and three quarters of
    /// its length from the rib.
    fn beside_the_rib(&self) -> Vec<[Vec<Place>; 2]> {
        let mut pairs = Vec::new();
        let fine = self.fineness;
        let (first, last) = (self.carried.start, self.carried.end);
        let ends = [(first, true), (self.shares.len() - 1 - last, false)];
        for (_, before) in ends.into_iter().filter(|(layers, _)| *layers > 0) {
            for row in RIB_ROWS * fine..(RIB_ROWS + BEAD_ROWS) * fine {
                for ((column, x), y) in self
                    .sides()
                    .into_iter()
                    .flat_map(|side| [-1.0, 0.0, 1.0].map(|y| (side, y)))
                {
                    let at = |away: f64| -> Vec<Place> {
                        let place = |(layers, z): (usize, f64)| {
                            let (layer, z) = match before {
                                true => (first - 1 - layers, -z),
                                false => (last + layers, z),
                            };
                            Some((self.element([column, row, layer])?, [x, y, z]))
                        };
                        self.either_side(away)
                            .into_iter()
                            .filter_map(place)
                            .collect()
                    };
                    pairs.push([at(0.5), at(1.5)]);
                }
            }
        }
        pairs
    }

    /// Both outermost columns with the outer side's place on the reference cube.
    fn sides(&self) -> [(usize, f64); 2] {
        [(0, -1.0), (self.fineness - 1, 1.0)]
    }

    /// Cells and places in them that lie at `coarse` cells of fineness 1: two where that is between cells.
    fn either_side(&self, coarse: f64) -> Vec<(usize, f64)> {
        let fine = coarse * self.fineness as f64;
        match fine.fract() == 0.0 {
            true => vec![(fine as usize - 1, 1.0), (fine as usize, -1.0)],
            false => vec![(fine as usize, 2.0 * fine.fract() - 1.0)],
        }
    }

    fn element(&self, cell: [usize; 3]) -> Option<usize> {
        // Cells are in order: the first coordinate fastest, then the second.
        let key = |c: &[usize; 3]| [c[2], c[1], c[0]];
        let found = self.grid.cells.binary_search_by_key(&key(&cell), key);
        found.ok()
    }
}
