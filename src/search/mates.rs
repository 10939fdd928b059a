//! A tooth against its own mate, which it touches by design: beads as round bars along their axes,
//! ribs as walls.

use nalgebra::Vector3;

use crate::motion::Pose;

/// A tooth and its mate.
pub(super) struct Mates {
    pub driver: Bead,
    pub follower: Bead,
    /// Of the beads, and half the thickness of the ribs, mm.
    pub radius: f64,
    pub rib_radius: f64,
}

/// Axis of a bead in the frame of its gear, points relative to the gear's axis.
pub(super) struct Bead {
    axis: Vector3<f64>,
    points: Vec<Vector3<f64>>,
    pieces: Vec<Piece>,
    /// Ball around the points.
    centre: Vector3<f64>,
    radius: f64,
    /// Largest distance from the axis, squared.
    outside: f64,
    low: f64,
    high: f64,
}

/// The rib under one piece of a bead, a wall of level lines towards the axis.
struct Piece {
    start: Vector3<f64>,
    along: Vector3<f64>,
    low: f64,
    high: f64,
    /// How much the wall leans, per mm from the axis.
    lean: f64,
}

impl Bead {
    /// Of `points` in the frame of a gear with this `axis`.
    pub fn new(mut points: Vec<Vector3<f64>>, axis: Vector3<f64>) -> Bead {
        for point in &mut points {
            *point -= axis;
        }
        let piece = |pair: &[Vector3<f64>]| {
            let (a, b) = (pair[0], pair[1]);
            let turn = (a.x * b.y - a.y * b.x) / (a.xy().norm() * b.xy().norm());
            Piece {
                start: a,
                along: b - a,
                low: a.z.min(b.z),
                high: a.z.max(b.z),
                lean: turn / (b.z - a.z),
            }
        };
        let centre = points[points.len() / 2];
        let most = |of: &dyn Fn(&Vector3<f64>) -> f64| {
            points.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        Bead {
            axis,
            pieces: points.windows(2).map(piece).collect(),
            centre,
            radius: most(&|p| (p - centre).norm()),
            outside: most(&|p| p.xy().norm_squared()),
            low: -most(&|p| -p.z),
            high: most(&|p| p.z),
            points,
        }
    }

    /// The points as seen from the gear that `pose` leads to, relative to `axis` of it.
    fn placed(&self, pose: &Pose, axis: Vector3<f64>) -> Vec<Vector3<f64>> {
        let shift = pose.apply(self.axis) - axis;
        let place = |p: &Vector3<f64>| pose.rotation * p + shift;
        self.points.iter().map(place).collect()
    }

    /// Whether all `points` keep `limit` from the middle surface of the rib; only what lies between
    /// bead and axis counts, the bead is tested by itself.
    fn rib_clears(&self, points: &[Vector3<f64>], limit: f64) -> bool {
        points
            .iter()
            .filter(|p| p.z >= self.low && p.z <= self.high)
            .all(|p| {
                let squared = p.xy().norm_squared();
                squared >= self.outside
                    || self
                        .pieces
                        .iter()
                        .filter(|s| p.z >= s.low && p.z <= s.high)
                        .all(|s| s.clears(p, squared, limit))
            })
    }
}

impl Piece {
    /// Whether the point `p`, on the height of this piece and `squared` from the axis, keeps `limit`.
    fn clears(&self, p: &Vector3<f64>, squared: f64, limit: f64) -> bool {
        if self.high - self.low < 1e-9 {
            return true;
        }
        let f = (p.z - self.start.z) / self.along.z;
        let (x, y) = (
            self.start.x + f * self.along.x,
            self.start.y + f * self.along.y,
        );
        let edge = x * x + y * y;
        if squared >= edge {
            return true;
        }
        // Across the wall: level distance from the line, less where the wall leans.
        let across = x * p.y - y * p.x;
        let lean = self.lean * self.lean * squared;
        across * across > limit * limit * edge * (lean + 1.0)
    }
}

impl Mates {
    /// Whether the beads nowhere sink into each other by more than [`SINK`] and keep [`RIB_GAP`] from
    /// each other's ribs, at one phase.
    pub fn clear(&self, follower_in_driver: &Pose, driver_in_follower: &Pose) -> bool {
        let placed = self.follower.placed(follower_in_driver, self.driver.axis);
        let limit = 2.0 * self.radius - SINK;
        let middle = placed[placed.len() / 2] - self.driver.centre;
        let near = self.driver.radius + self.follower.radius + limit;
        if middle.norm_squared() <= near * near && closest(&self.driver.points, &placed) <= limit {
            return false;
        }
        let reach = self.radius + self.rib_radius + RIB_GAP;
        let back = self.driver.placed(driver_in_follower, self.follower.axis);
        self.driver.rib_clears(&placed, reach) && self.follower.rib_clears(&back, reach)
    }
}

/// Distance of two chains of points taken as polylines: the nearest pair of points, refined on the
/// segments around it.
fn closest(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let mut nearest = (f64::INFINITY, 0, 0);
    for (i, p) in a.iter().enumerate() {
        for (k, q) in b.iter().enumerate() {
            let d = (p - q).norm_squared();
            if d < nearest.0 {
                nearest = (d, i, k);
            }
        }
    }
    let (mut best, i, k) = nearest;
    for s in i.saturating_sub(1)..(i + 1).min(a.len() - 1) {
        for t in k.saturating_sub(1)..(k + 1).min(b.len() - 1) {
            best = best.min(segments([a[s], a[s + 1]], [b[t], b[t + 1]]));
        }
    }
    best.sqrt()
}

/// Squared distance of two segments, by alternating projection from their middles: exact enough for
/// nearly parallel pieces of a bead, and never below the true distance.
fn segments([a0, a1]: [Vector3<f64>; 2], [b0, b1]: [Vector3<f64>; 2]) -> f64 {
    let project = |p: Vector3<f64>, o: Vector3<f64>, e: Vector3<f64>| {
        let d = e - o;
        o + d * ((p - o).dot(&d) / d.norm_squared()).clamp(0.0, 1.0)
    };
    let mut p = (a0 + a1) * 0.5;
    let mut q = project(p, b0, b1);
    for _ in 0..6 {
        p = project(q, a0, a1);
        q = project(p, b0, b1);
    }
    (p - q).norm_squared()
}

/// Depth to which beads may seem to sink into each other between sampled phases, mm: a fraction of
/// the default clearance.
const SINK: f64 = 0.01;

/// Least gap between a bead and its mate's rib, mm.
const RIB_GAP: f64 = 0.06;
