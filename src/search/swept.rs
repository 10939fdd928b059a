//! A band made ready for collision tests: a distance field around the driver's balls, the follower's
//! balls carried through the period, and the fins of both gears unrolled.

use nalgebra::Vector3;

/// Ball of a tooth or rib in the frame of its gear: centre (mm), radius (mm), tooth index.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub centre: Vector3<f64>,
    pub radius: f64,
    pub tooth: u8,
}

/// A band ready for collision tests.
#[derive(Debug, Clone)]
pub struct Swept {
    pub(super) field: Field,
    pub(super) sweep: Sweep,
    /// Of driver and follower.
    pub(super) fins: [Fins; 2],
}

/// The fins of one gear unrolled on a cylinder between hub and tip: lines of (arc, z), mm.
#[derive(Debug, Clone)]
pub(super) struct Fins {
    teeth: Vec<Vec<[f64; 2]>>,
    /// Arc of a full turn.
    turn: f64,
}

/// Radius on which fins are unrolled, as a share of the centre distance: half way up a fin.
const FIN_RADIUS: f64 = 0.36;

impl Fins {
    /// Unrolls the bead axes of all teeth, points relative to the gear's axis.
    pub fn new(beads: impl Iterator<Item = Vec<Vector3<f64>>>, center_distance: f64) -> Fins {
        let radius = FIN_RADIUS * center_distance;
        let unrolled = |p: &Vector3<f64>| [radius * p.y.atan2(p.x), p.z];
        Fins {
            teeth: beads
                .map(|bead| bead.iter().map(unrolled).collect())
                .collect(),
            turn: std::f64::consts::TAU * radius,
        }
    }

    /// Whether all fins of one band stay `limit` away from all of the other: fins that cross or graze
    /// leave slivers of material between them.
    fn apart(&self, other: &Fins, limit: f64) -> bool {
        let range = |tooth: &[[f64; 2]]| {
            tooth.iter().fold((f64::MAX, f64::MIN), |(low, high), p| {
                (low.min(p[1]), high.max(p[1]))
            })
        };
        let others: Vec<_> = other.teeth.iter().map(|t| (t, range(t))).collect();
        self.teeth.iter().all(|a| {
            let (low, high) = range(a);
            others
                .iter()
                .filter(|(_, r)| r.0 < high + limit && r.1 > low - limit)
                .all(|(b, _)| {
                    a.iter().all(|p| {
                        b.iter().all(|q| {
                            let arc = (p[0] - q[0]).abs() % self.turn;
                            arc.min(self.turn - arc).hypot(p[1] - q[1]) >= limit
                        })
                    })
                })
        })
    }
}

impl Swept {
    /// Whether driver teeth of either band keep `gap` from follower teeth of the other, and the fins
    /// of both stand `apart` on their gears.
    pub fn compatible(&self, other: &Swept, gap: f64, apart: f64) -> bool {
        (0..2).all(|g| self.fins[g].apart(&other.fins[g], apart))
            && self.sweep.clears(&other.field, gap, false)
            && other.sweep.clears(&self.field, gap, false)
    }

    /// Memory that it takes, bytes.
    pub fn bytes(&self) -> usize {
        self.field.cells.len() * size_of::<[u8; 3]>()
            + self.sweep.points.len() * size_of::<SweptPoint>()
    }

    /// Axial extent of the mesh, driver and follower together, lowest and highest z in Σ.
    pub fn extent(&self) -> (f64, f64) {
        let field = &self.field;
        let pad = field.range + field.depth;
        let top = field.low[2] + field.cell * (field.size[2] - 1) as f32 - pad;
        let low = self.sweep.low.min(field.low[2] + pad);
        (f64::from(low), f64::from(self.sweep.high.max(top)))
    }
}

/// Centre and radius in units of the sweep: thousands of bands are held at once.
#[derive(Debug, Clone, Copy)]
struct SweptPoint {
    at: [i16; 3],
    radius: u16,
    tooth: u8,
}

#[derive(Debug, Clone)]
pub(super) struct Sweep {
    points: Vec<SweptPoint>,
    /// Length of a unit, mm.
    unit: f32,
    low: f32,
    high: f32,
}

impl Sweep {
    /// Without any points yet; for gears of this centre distance, in units of a ten-thousandth of it.
    pub fn empty(center_distance: f64) -> Sweep {
        Sweep {
            points: Vec::new(),
            unit: 1e-4 * center_distance as f32,
            low: f32::MAX,
            high: f32::MIN,
        }
    }

    /// Adds a ball as seen from the driver.
    pub fn push(&mut self, at: Vector3<f64>, ball: &Ball) {
        let [x, y, z] = [at.x as f32, at.y as f32, at.z as f32];
        let radius = ball.radius as f32;
        self.low = self.low.min(z - radius);
        self.high = self.high.max(z + radius);
        self.points.push(SweptPoint {
            at: [x, y, z].map(|c| (c / self.unit).round() as i16),
            radius: (radius / self.unit).round() as u16,
            tooth: ball.tooth,
        });
    }

    /// Gives back the room for points that were not added.
    pub fn trim(&mut self) {
        self.points.shrink_to_fit();
    }

    /// Whether all points keep `gap` from the field. In a band's test against itself (`own`) a tooth
    /// touches its mate by design: there only penetration beyond the field's accuracy counts.
    pub fn clears(&self, field: &Field, gap: f64, own: bool) -> bool {
        let top = field.low[2] + field.cell * (field.size[2] - 1) as f32;
        if self.low > top || self.high < field.low[2] {
            return true;
        }
        let gap = gap as f32;
        self.points.iter().all(|point| {
            let Some(near) = field.at(point.at.map(|c| f32::from(c) * self.unit)) else {
                return true;
            };
            let radius = f32::from(point.radius) * self.unit;
            if own && near.tooth == point.tooth {
                near.distance - radius > -TOUCH && near.other - radius > gap
            } else {
                near.distance - radius > gap
            }
        })
    }
}

/// Accuracy of the interpolated field near a contact, mm: designed contacts may seem this deep.
const TOUCH: f32 = 0.08;

#[derive(Debug, Clone, Copy)]
struct Near {
    distance: f32,
    tooth: u8,
    other: f32,
}

/// Distance to the driver's balls on a regular grid: nearest tooth and nearest other tooth, as
/// one-byte codes.
#[derive(Debug, Clone)]
pub(super) struct Field {
    low: [f32; 3],
    size: [usize; 3],
    cell: f32,
    /// Codes per mm, and the depth inside a ball that code 0 stands for.
    scale: f32,
    depth: f32,
    /// Distances up to this are exact.
    range: f32,
    cells: Vec<[u8; 3]>,
}

impl Field {
    /// Field around `balls`, good for distances up to `need` (mm).
    pub fn new(balls: &[Ball], cell: f64, need: f64) -> Field {
        let (mut lo, mut hi) = (balls[0].centre, balls[0].centre);
        for ball in balls {
            lo = lo.inf(&ball.centre);
            hi = hi.sup(&ball.centre);
        }
        let depth = balls.iter().map(|b| b.radius).fold(0.0, f64::max);
        let range = need + 2.0 * cell + 0.1;
        let scale = 254.0 / (range + depth);
        let pad = range + depth;
        lo = lo.add_scalar(-pad);
        hi = hi.add_scalar(pad);
        let size: [usize; 3] =
            std::array::from_fn(|k| ((hi[k] - lo[k]) / cell).ceil() as usize + 1);
        let mut cells = vec![[254, u8::MAX, 254]; size.iter().product()];
        for ball in balls {
            let reach = range + ball.radius;
            let first: [usize; 3] = std::array::from_fn(|k| {
                ((ball.centre[k] - reach - lo[k]) / cell).ceil().max(0.0) as usize
            });
            let last: [usize; 3] =
                std::array::from_fn(|k| ((ball.centre[k] + reach - lo[k]) / cell).floor() as usize);
            for ix in first[0]..=last[0].min(size[0] - 1) {
                let dx = lo.x + ix as f64 * cell - ball.centre.x;
                for iy in first[1]..=last[1].min(size[1] - 1) {
                    let dy = lo.y + iy as f64 * cell - ball.centre.y;
                    let row = (ix * size[1] + iy) * size[2];
                    let planar = dx * dx + dy * dy;
                    if planar > reach * reach {
                        continue;
                    }
                    for iz in first[2]..=last[2].min(size[2] - 1) {
                        let dz = lo.z + iz as f64 * cell - ball.centre.z;
                        let distance = (planar + dz * dz).sqrt() - ball.radius;
                        let code = ((distance + depth) * scale).clamp(0.0, 254.0) as u8;
                        let c = &mut cells[row + iz];
                        if c[1] == ball.tooth {
                            c[0] = c[0].min(code);
                        } else if code < c[0] {
                            *c = [code, ball.tooth, c[0]];
                        } else {
                            c[2] = c[2].min(code);
                        }
                    }
                }
            }
        }
        Field {
            low: [lo.x as f32, lo.y as f32, lo.z as f32],
            size,
            cell: cell as f32,
            scale: scale as f32,
            depth: depth as f32,
            range: range as f32,
            cells,
        }
    }

    /// Interpolated distances at `p`; `None` outside the grid or beyond the stored range.
    fn at(&self, p: [f32; 3]) -> Option<Near> {
        let mut index = [0_usize; 3];
        let mut fraction = [0.0_f32; 3];
        for k in 0..3 {
            let x = (p[k] - self.low[k]) / self.cell;
            if !(x >= 0.0 && x < (self.size[k] - 1) as f32) {
                return None;
            }
            index[k] = x as usize;
            fraction[k] = x - index[k] as f32;
        }
        let base = (index[0] * self.size[1] + index[1]) * self.size[2] + index[2];
        let strides = [self.size[1] * self.size[2], self.size[2], 1];
        // Within a cell the distance changes by less than its diagonal: far cells need no more.
        let decode = |code: u8| f32::from(code) / self.scale - self.depth;
        if decode(self.cells[base][0]) > self.range - 2.0 * self.cell {
            return None;
        }
        let (mut distance, mut other) = (0.0, 0.0);
        let mut nearest = (f32::MIN, u8::MAX);
        for corner in 0..8 {
            let (mut weight, mut at) = (1.0, base);
            for k in 0..3 {
                if corner >> k & 1 == 1 {
                    weight *= fraction[k];
                    at += strides[k];
                } else {
                    weight *= 1.0 - fraction[k];
                }
            }
            let c = self.cells[at];
            distance += weight * decode(c[0]);
            other += weight * decode(c[2]);
            if weight > nearest.0 {
                nearest = (weight, c[1]);
            }
        }
        Some(Near {
            distance,
            tooth: nearest.1,
            other,
        })
    }
}
