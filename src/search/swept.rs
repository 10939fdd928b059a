//! A band made ready for collision tests: a distance field around the driver's balls, the follower's
//! balls carried through the period, and the fins of both gears unrolled.

use nalgebra::Vector3;

use super::field::{Field, Radii, ToothField};

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
    /// Lowest and highest z of each.
    ranges: Vec<[f64; 2]>,
    /// Arc after which the teeth repeat themselves.
    turn: f64,
}

impl Fins {
    /// Unrolls the bead axes of the teeth on a cylinder, points relative to the gear's axis, around which
    /// they stand `copies` times.
    pub fn new(beads: impl Iterator<Item = Vec<Vector3<f64>>>, radius: f64, copies: usize) -> Fins {
        let unrolled = |p: &Vector3<f64>| [radius * p.y.atan2(p.x), p.z];
        let teeth: Vec<Vec<[f64; 2]>> = beads
            .map(|bead| bead.iter().map(unrolled).collect())
            .collect();
        let range = |tooth: &Vec<[f64; 2]>| {
            tooth.iter().fold([f64::MAX, f64::MIN], |[low, high], p| {
                [low.min(p[1]), high.max(p[1])]
            })
        };
        Fins {
            ranges: teeth.iter().map(range).collect(),
            teeth,
            turn: std::f64::consts::TAU * radius / copies as f64,
        }
    }

    /// Whether all fins of one band stay `limit` away from all of the other: fins that cross or graze
    /// leave slivers of material between them.
    fn apart(&self, other: &Fins, limit: f64) -> bool {
        self.teeth
            .iter()
            .zip(&self.ranges)
            .all(|(a, &[low, high])| {
                let near = other.teeth.iter().zip(&other.ranges);
                near.filter(|(_, r)| r[0] < high + limit && r[1] > low - limit)
                    .all(|(b, _)| self.keeps(a, b, limit))
            })
    }

    fn keeps(&self, a: &[[f64; 2]], b: &[[f64; 2]], limit: f64) -> bool {
        a.iter().all(|p| {
            b.iter().all(|q| {
                let arc = p[0] - q[0];
                let arc = arc - self.turn * (arc / self.turn).round();
                arc * arc + (p[1] - q[1]).powi(2) >= limit * limit
            })
        })
    }
}

impl Swept {
    /// Whether driver teeth of either band keep `gap` from follower teeth of the other, and the fins
    /// of both stand `apart` on their gears.
    pub fn compatible(&self, other: &Swept, gap: f64, apart: f64) -> bool {
        (0..2).all(|g| self.fins[g].apart(&other.fins[g], apart))
            && self.sweep.clears(&other.field, gap)
            && other.sweep.clears(&self.field, gap)
    }

    /// Memory that it takes, bytes.
    pub fn bytes(&self) -> usize {
        let points = self.sweep.beads.len() + self.sweep.ribs.len();
        self.field.bytes() + points * size_of::<[i16; 3]>()
    }

    /// Axial extent of the mesh, driver and follower together, lowest and highest z in Σ.
    pub fn extent(&self) -> (f64, f64) {
        let lattice = &self.field.lattice;
        let pad = lattice.range + lattice.depth;
        let low = self.sweep.low.min(lattice.low[2] + pad);
        let high = self.sweep.high.max(lattice.top() - pad);
        (f64::from(low), f64::from(high))
    }
}

/// The follower's balls through the period as seen from the driver: centres in units of a
/// ten-thousandth of the centre distance, since thousands of bands are held at once.
#[derive(Debug, Clone)]
pub(super) struct Sweep {
    beads: Vec<[i16; 3]>,
    ribs: Vec<[i16; 3]>,
    radii: [f32; 2],
    /// Length of a unit, mm.
    unit: f32,
    low: f32,
    high: f32,
}

/// Points of one tooth at one phase: up to where they go in each of a sweep's lists.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub tooth: u8,
    end: [usize; 2],
}

impl Sweep {
    /// Without any points yet; for gears of this centre distance.
    pub fn empty(center_distance: f64, radii: Radii) -> Sweep {
        let unit = 1e-4 * center_distance as f32;
        Sweep {
            beads: Vec::new(),
            ribs: Vec::new(),
            radii: [radii.bead, radii.rib].map(|r| (r as f32 / unit).round() * unit),
            unit,
            low: f32::MAX,
            high: f32::MIN,
        }
    }

    /// Adds a ball of a bead as seen from the driver.
    pub fn push_bead(&mut self, at: Vector3<f64>) {
        let point = self.note(at, 0);
        self.beads.push(point);
    }

    /// Adds a ball of a rib as seen from the driver.
    pub fn push_rib(&mut self, at: Vector3<f64>) {
        let point = self.note(at, 1);
        self.ribs.push(point);
    }

    fn note(&mut self, at: Vector3<f64>, kind: usize) -> [i16; 3] {
        let (z, radius) = (at.z as f32, self.radii[kind]);
        self.low = self.low.min(z - radius);
        self.high = self.high.max(z + radius);
        // Rounded without a call: coordinates are far below 32,768 units.
        let units = 1.0 / f64::from(self.unit);
        [at.x, at.y, at.z].map(|c| ((c * units + 32_768.5) as i32 - 32_768) as i16)
    }

    /// What was added since the run before belongs to `tooth`.
    pub fn run(&self, tooth: u8) -> Run {
        Run {
            tooth,
            end: [self.beads.len(), self.ribs.len()],
        }
    }

    /// Gives back the room for points that were not added.
    pub fn trim(&mut self) {
        self.beads.shrink_to_fit();
        self.ribs.shrink_to_fit();
    }

    fn point(&self, at: &[i16; 3]) -> [f32; 3] {
        at.map(|c| f32::from(c) * self.unit)
    }

    /// Whether all points keep `gap` from the field of another band.
    fn clears(&self, field: &Field, gap: f64) -> bool {
        if self.low > field.lattice.top() || self.high < field.lattice.low[2] {
            return true;
        }
        [(&self.beads, self.radii[0]), (&self.ribs, self.radii[1])]
            .into_iter()
            .all(|(points, radius)| {
                let limit = radius + gap as f32;
                points
                    .iter()
                    .all(|p| field.at(self.point(p)).is_none_or(|d| d > limit))
            })
    }

    /// Whether the follower's teeth keep `gap` from the driver's teeth of the same band. A tooth
    /// touches its mate by design: there only penetration beyond the field's accuracy counts.
    pub fn clears_own(&self, field: &ToothField, runs: &[Run], gap: f64) -> bool {
        let gap = gap as f32;
        let mut start = [0, 0];
        runs.iter().all(|run| {
            let lists = [
                (&self.beads[start[0]..run.end[0]], self.radii[0]),
                (&self.ribs[start[1]..run.end[1]], self.radii[1]),
            ];
            start = run.end;
            lists.into_iter().all(|(points, radius)| {
                points.iter().all(|p| {
                    let Some(near) = field.at(self.point(p)) else {
                        return true;
                    };
                    if near.tooth == run.tooth {
                        near.distance - radius > -TOUCH && near.other - radius > gap
                    } else {
                        near.distance - radius > gap
                    }
                })
            })
        })
    }
}

/// Accuracy of the interpolated field near a contact, mm: designed contacts may seem this deep.
const TOUCH: f32 = 0.08;
