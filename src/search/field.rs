//! Distance to the driver's balls on a regular grid.

use nalgebra::Vector3;

use crate::motion::Pose;

/// Balls of one tooth with its rib, in the frame of its gear: centres, mm.
#[derive(Debug, Clone, Default)]
pub(super) struct ToothBalls {
    /// Of the bead; all of one radius, as those of the rib.
    pub beads: Vec<Vector3<f64>>,
    pub ribs: Vec<Vector3<f64>>,
}

impl ToothBalls {
    /// The balls as `pose` moves them.
    pub fn moved(&self, pose: &Pose) -> ToothBalls {
        let moved = |balls: &Vec<Vector3<f64>>| balls.iter().map(|&c| pose.apply(c)).collect();
        ToothBalls {
            beads: moved(&self.beads),
            ribs: moved(&self.ribs),
        }
    }
}

/// Radii of a gear's balls, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Radii {
    pub bead: f64,
    pub rib: f64,
}

/// Shape of a grid and what its one-byte codes stand for.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    pub low: [f32; 3],
    pub size: [usize; 3],
    pub cell: f32,
    /// Codes per mm, and the depth inside a ball that code 0 stands for.
    scale: f32,
    pub depth: f32,
    /// Distances up to this are exact.
    pub range: f32,
    /// Codes above this are too far to matter.
    far: u8,
}

impl Lattice {
    /// Around the balls of all teeth, good for distances up to `need` (mm).
    fn new(teeth: &[ToothBalls], radii: Radii, (cell, need): (f64, f64)) -> Lattice {
        let mut depth = radii.bead;
        let mut bounds: Option<(Vector3<f64>, Vector3<f64>)> = None;
        for tooth in teeth {
            if !tooth.ribs.is_empty() {
                depth = depth.max(radii.rib);
            }
            for c in tooth.beads.iter().chain(&tooth.ribs) {
                bounds = Some(bounds.map_or((*c, *c), |(lo, hi)| (lo.inf(c), hi.sup(c))));
            }
        }
        let (lo, hi) = bounds.unwrap_or_default();
        let range = need + 2.0 * cell + 0.1;
        let pad = range + depth;
        let (lo, hi) = (lo.add_scalar(-pad), hi.add_scalar(pad));
        let scale = 254.0 / pad;
        Lattice {
            low: [lo.x as f32, lo.y as f32, lo.z as f32],
            size: std::array::from_fn(|k| ((hi[k] - lo[k]) / cell).ceil() as usize + 1),
            cell: cell as f32,
            scale: scale as f32,
            depth: depth as f32,
            range: range as f32,
            far: ((range - 2.0 * cell + depth) * scale) as u8,
        }
    }

    fn cells(&self) -> usize {
        self.size.iter().product()
    }

    /// Highest z of the grid.
    pub fn top(&self) -> f32 {
        self.low[2] + self.cell * (self.size[2] - 1) as f32
    }

    /// Codes that a distance of `mm` lies between.
    fn decode(&self, code: f32) -> f32 {
        code / self.scale - self.depth
    }

    /// Index of the grid point below `p` and where `p` is in its cell; `None` outside the grid.
    fn locate(&self, p: [f32; 3]) -> Option<(usize, [f32; 3])> {
        let x: [f32; 3] = std::array::from_fn(|k| (p[k] - self.low[k]) / self.cell);
        let inside = (0..3).all(|k| x[k] >= 0.0 && x[k] < (self.size[k] - 1) as f32);
        if !inside {
            return None;
        }
        let i = x.map(|x| x as u32 as usize);
        let base = (i[0] * self.size[1] + i[1]) * self.size[2] + i[2];
        Some((base, std::array::from_fn(|k| x[k] - i[k] as f32)))
    }

    /// Indices and weights of the corners of the cell above grid point `base`.
    fn corners(&self, base: usize, f: [f32; 3]) -> [(usize, f32); 8] {
        let strides = [self.size[1] * self.size[2], self.size[2], 1];
        std::array::from_fn(|corner| {
            let (mut weight, mut at) = (1.0, base);
            for k in 0..3 {
                if corner >> k & 1 == 1 {
                    weight *= f[k];
                    at += strides[k];
                } else {
                    weight *= 1.0 - f[k];
                }
            }
            (at, weight)
        })
    }
}

/// Distance to the nearest ball as one-byte codes.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub lattice: Lattice,
    codes: Vec<u8>,
}

/// [`Field`] with the tooth that is nearest and the distance of the nearest other tooth: what a band's
/// test against itself needs.
#[derive(Debug)]
pub(super) struct ToothField {
    field: Field,
    tooth: Vec<u8>,
    other: Vec<u8>,
}

/// What a [`ToothField`] says of a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub distance: f32,
    pub tooth: u8,
    pub other: f32,
}

impl Field {
    /// Interpolated distance at `p`; `None` outside the grid or beyond the stored range.
    #[inline]
    pub fn at(&self, p: [f32; 3]) -> Option<f32> {
        let (base, f) = self.lattice.locate(p)?;
        // Within a cell the distance changes by less than its diagonal: far cells need no more.
        if self.codes[base] > self.lattice.far {
            return None;
        }
        let corners = self.lattice.corners(base, f);
        let code = corners
            .iter()
            .map(|&(at, w)| w * f32::from(self.codes[at]))
            .sum();
        Some(self.lattice.decode(code))
    }

    /// Memory that it takes, bytes.
    pub fn bytes(&self) -> usize {
        self.codes.len()
    }
}

impl ToothField {
    /// Field around the balls of all teeth, good for distances up to `need` (mm).
    pub fn new(teeth: &[ToothBalls], radii: Radii, (cell, need): (f64, f64)) -> ToothField {
        let lattice = Lattice::new(teeth, radii, (cell, need));
        let cells = lattice.cells();
        let mut made = ToothField {
            field: Field {
                codes: vec![254; cells],
                lattice,
            },
            tooth: vec![u8::MAX; cells],
            other: vec![254; cells],
        };
        let mut scratch = Scratch::default();
        for (j, tooth) in teeth.iter().enumerate() {
            made.add(j as u8, tooth, radii, &mut scratch);
        }
        made
    }

    /// What is near `p`; `None` outside the grid or beyond the stored range.
    pub fn at(&self, p: [f32; 3]) -> Option<Near> {
        let Field { lattice, codes } = &self.field;
        let (base, f) = lattice.locate(p)?;
        if codes[base] > lattice.far {
            return None;
        }
        let (mut distance, mut other) = (0.0, 0.0);
        let mut nearest = (f32::MIN, u8::MAX);
        for (at, weight) in lattice.corners(base, f) {
            distance += weight * f32::from(codes[at]);
            other += weight * f32::from(self.other[at]);
            if weight > nearest.0 {
                nearest = (weight, self.tooth[at]);
            }
        }
        Some(Near {
            distance: lattice.decode(distance),
            tooth: nearest.1,
            other: lattice.decode(other),
        })
    }

    /// The distances alone.
    pub fn into_field(self) -> Field {
        self.field
    }

    /// Takes the balls of one tooth in: squared distances over the box around it, rows of z at a time,
    /// then their codes.
    fn add(&mut self, j: u8, tooth: &ToothBalls, radii: Radii, scratch: &mut Scratch) {
        let Field { lattice, codes } = &mut self.field;
        let Some(window) = Window::around(tooth, radii, lattice) else {
            return;
        };
        let row = window.count[2];
        let rows = window.count[0] * window.count[1];
        scratch.clear(rows, row);
        for (balls, radius, squares) in [
            (&tooth.beads, radii.bead, &mut scratch.beads),
            (&tooth.ribs, radii.rib, &mut scratch.ribs),
        ] {
            let reach = lattice.range + radius as f32;
            for ball in balls {
                window.spread(ball, (reach, lattice.cell), squares, &mut scratch.touched);
            }
        }
        let (bead, rib) = (
            lattice.depth - radii.bead as f32,
            lattice.depth - radii.rib as f32,
        );
        for index in 0..rows {
            if !scratch.touched[index] {
                continue;
            }
            let (ix, iy) = (index / window.count[1], index % window.count[1]);
            let first = ((ix + window.first[0]) * lattice.size[1] + iy + window.first[1])
                * lattice.size[2]
                + window.first[2];
            let here = index * row..(index + 1) * row;
            let there = first..first + row;
            let cells = codes[there.clone()]
                .iter_mut()
                .zip(&mut self.tooth[there.clone()])
                .zip(&mut self.other[there]);
            let squares = scratch.beads[here.clone()].iter().zip(&scratch.ribs[here]);
            for (((near, tooth), other), (&a, &b)) in cells.zip(squares) {
                let (a, b) = (a.sqrt() + bead, b.sqrt() + rib);
                let least = if a < b { a } else { b };
                let code = ((least * lattice.scale) as i32).clamp(0, 254) as u8;
                let nearer = code < *near;
                let (old, rest) = (*near, (*other).min(code));
                *other = if nearer { old } else { rest };
                *tooth = if nearer { j } else { *tooth };
                *near = if nearer { code } else { old };
            }
        }
    }
}

/// Squared distances over the window of a tooth, and which rows of it any ball comes near.
#[derive(Default)]
struct Scratch {
    beads: Vec<f32>,
    ribs: Vec<f32>,
    touched: Vec<bool>,
}

/// Squared distance of what is not there.
const NOWHERE: f32 = 1e12;

impl Scratch {
    fn clear(&mut self, rows: usize, row: usize) {
        for squares in [&mut self.beads, &mut self.ribs] {
            squares.clear();
            squares.resize(rows * row, NOWHERE);
        }
        self.touched.clear();
        self.touched.resize(rows, false);
    }
}

/// Part of a grid.
struct Window {
    first: [usize; 3],
    count: [usize; 3],
    /// First grid point, mm.
    low: [f32; 3],
}

impl Window {
    /// What the balls of a tooth reach of a grid; `None` without balls.
    fn around(tooth: &ToothBalls, radii: Radii, lattice: &Lattice) -> Option<Window> {
        let start = *tooth.beads.first()?;
        let balls = tooth.beads.iter().chain(&tooth.ribs);
        let (lo, hi) = balls.fold((start, start), |(lo, hi), c| (lo.inf(c), hi.sup(c)));
        let reach = lattice.range + radii.bead.max(radii.rib) as f32;
        let at = |k: usize, x: f32| (x - lattice.low[k]) / lattice.cell;
        let first: [usize; 3] =
            std::array::from_fn(|k| at(k, lo[k] as f32 - reach).ceil().max(0.0) as usize);
        let last: [usize; 3] = std::array::from_fn(|k| {
            (at(k, hi[k] as f32 + reach).floor() as usize).min(lattice.size[k] - 1)
        });
        Some(Window {
            count: std::array::from_fn(|k| last[k] + 1 - first[k]),
            low: std::array::from_fn(|k| lattice.low[k] + first[k] as f32 * lattice.cell),
            first,
        })
    }

    /// Squared distances to one ball where they are below `reach`, if less than what is there.
    fn spread(
        &self,
        ball: &Vector3<f64>,
        (reach, cell): (f32, f32),
        squares: &mut [f32],
        touched: &mut [bool],
    ) {
        let c: [f32; 3] = std::array::from_fn(|k| ball[k] as f32 - self.low[k]);
        let first = |k: usize| (((c[k] - reach) / cell).max(0.0) as usize).min(self.count[k]);
        let end = |k: usize| ((((c[k] + reach) / cell).max(0.0)) as usize + 1).min(self.count[k]);
        let (z0, z1) = (first(2), end(2));
        let along = (z0..z1).map(|i| (i as f32 * cell - c[2]).powi(2));
        let along: Vec<f32> = along.collect();
        for ix in first(0)..end(0) {
            let dx = ix as f32 * cell - c[0];
            for iy in first(1)..end(1) {
                let dy = iy as f32 * cell - c[1];
                let planar = dx * dx + dy * dy;
                if planar > reach * reach {
                    continue;
                }
                let row = ix * self.count[1] + iy;
                touched[row] = true;
                let start = row * self.count[2] + z0;
                for (square, d) in squares[start..].iter_mut().zip(&along) {
                    let here = planar + d;
                    *square = if here < *square { here } else { *square };
                }
            }
        }
    }
}
