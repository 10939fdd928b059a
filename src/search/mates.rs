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

    /// Those of `points` that lie between bead and axis, with the pieces of the rib at their height; the
    /// bead is tested by itself.
    fn beside<'a>(
        &'a self,
        points: &'a [Vector3<f64>],
    ) -> impl Iterator<Item = ((usize, &'a Vector3<f64>), (usize, Beside))> {
        let level = move |(_, p): &(usize, &Vector3<f64>)| p.z >= self.low && p.z <= self.high;
        let points = points.iter().enumerate().filter(level);
        points.flat_map(move |(i, p)| {
            let squared = p.xy().norm_squared();
            let pieces = match squared < self.outside {
                true => &self.pieces[..],
                false => &[],
            };
            let beside = move |(k, s): (usize, &Piece)| Some(((i, p), (k, s.beside(p, squared)?)));
            pieces.iter().enumerate().filter_map(beside)
        })
    }

    /// Whether all `points` keep `limit` from the middle surface of the rib.
    fn rib_clears(&self, points: &[Vector3<f64>], limit: f64) -> bool {
        self.beside(points)
            .all(|(_, (_, b))| b.across * b.across > limit * limit * b.edge * b.lean)
    }

    /// Where the `points` come nearest to the middle surface of the rib: distance, the point, and the
    /// spot of the rib with the direction from it to the point.
    fn rib_meets(&self, points: &[Vector3<f64>]) -> Option<(f64, At, At, Vector3<f64>)> {
        let distance = |b: &Beside| b.across.abs() / (b.edge * b.lean).sqrt();
        let nearest = self.beside(points);
        let ((i, p), (k, beside)) =
            nearest.min_by(|a, b| distance(&a.1.1).total_cmp(&distance(&b.1.1)))?;
        let (piece, edge) = (&self.pieces[k], beside.edge.sqrt());
        let share = p.xy().norm() / edge;
        let at = piece.start + piece.along * beside.along;
        let outward = Vector3::new(at.x, at.y, 0.0) / edge;
        let line = piece.along.component_mul(&Vector3::new(share, share, 1.0));
        let normal = outward.cross(&line).normalize();
        let to = p - at.component_mul(&Vector3::new(share, share, 1.0));
        let way = normal * normal.dot(&to).signum();
        Some((distance(&beside), (i, 0.0, 1.0), (k, beside.along, share), way))
    }
}

/// A spot of a tooth: station, share of the way to the next one, and distance from the axis as a share
/// of the bead's.
pub(super) type At = (usize, f64, f64);

/// Where a tooth and its mate come near each other.
pub(super) struct Meeting {
    /// What is left above the gap wanted, mm.
    pub slack: f64,
    /// Spots of driver and follower.
    pub at: [At; 2],
    /// From driver to follower, in the driver's frame.
    pub way: Vector3<f64>,
}

/// A point beside a piece of a rib.
struct Beside {
    /// Share of the piece below the point.
    along: f64,
    /// Area between the directions of point and piece, whose size over that of the edge is the level
    /// distance.
    across: f64,
    /// Of the piece's bead from the axis, squared.
    edge: f64,
    /// Square by which the wall's lean shortens the level distance.
    lean: f64,
}

impl Piece {
    /// The point `p`, `squared` from the axis, beside this piece; `None` above, below or outside it.
    fn beside(&self, p: &Vector3<f64>, squared: f64) -> Option<Beside> {
        if p.z < self.low || p.z > self.high || self.high - self.low < 1e-9 {
            return None;
        }
        let along = (p.z - self.start.z) / self.along.z;
        let (x, y) = (
            self.start.x + along * self.along.x,
            self.start.y + along * self.along.y,
        );
        let edge = x * x + y * y;
        (squared < edge).then(|| Beside {
            along,
            across: x * p.y - y * p.x,
            edge,
            lean: self.lean * self.lean * squared + 1.0,
        })
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
        if middle.norm_squared() <= near * near
            && closest(&self.driver.points, &placed).distance <= limit
        {
            return false;
        }
        let reach = self.radius + self.rib_radius + RIB_GAP;
        let back = self.driver.placed(driver_in_follower, self.follower.axis);
        self.driver.rib_clears(&placed, reach) && self.follower.rib_clears(&back, reach)
    }

    /// Where beads and ribs come nearest to each other, at one phase.
    pub fn meetings(&self, [follower_in_driver, driver_in_follower]: [&Pose; 2]) -> Vec<Meeting> {
        let placed = self.follower.placed(follower_in_driver, self.driver.axis);
        let back = self.driver.placed(driver_in_follower, self.follower.axis);
        let beads = closest(&self.driver.points, &placed);
        let bead = |(station, along): (usize, f64)| (station, along, 1.0);
        let mut meetings = vec![Meeting {
            slack: beads.distance - (2.0 * self.radius - SINK),
            at: [bead(beads.at[0]), bead(beads.at[1])],
            way: beads.way,
        }];
        let reach = self.radius + self.rib_radius + RIB_GAP;
        if let Some((distance, follower, driver, way)) = self.driver.rib_meets(&placed) {
            meetings.push(Meeting {
                slack: distance - reach,
                at: [driver, follower],
                way,
            });
        }
        if let Some((distance, driver, follower, way)) = self.follower.rib_meets(&back) {
            meetings.push(Meeting {
                slack: distance - reach,
                at: [driver, follower],
                way: -(follower_in_driver.rotation * way),
            });
        }
        meetings
    }
}

/// Nearest points of two chains.
struct Closest {
    distance: f64,
    /// Station and share of the way to the next one, on either.
    at: [(usize, f64); 2],
    /// Unit vector from the first to the second.
    way: Vector3<f64>,
}

/// Distance of two chains of points taken as polylines: the nearest pair of points, refined on the
/// segments around it.
fn closest(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> Closest {
    let mut nearest = (f64::INFINITY, 0, 0);
    for (i, p) in a.iter().enumerate() {
        for (k, q) in b.iter().enumerate() {
            let d = (p - q).norm_squared();
            if d < nearest.0 {
                nearest = (d, i, k);
            }
        }
    }
    let (least, i, k) = nearest;
    let mut best = (least, [(i, 0.0), (k, 0.0)], b[k] - a[i]);
    for s in i.saturating_sub(1)..(i + 1).min(a.len() - 1) {
        for t in k.saturating_sub(1)..(k + 1).min(b.len() - 1) {
            let ([f, g], way) = segments([a[s], a[s + 1]], [b[t], b[t + 1]]);
            let squared = way.norm_squared();
            if squared < best.0 {
                best = (squared, [(s, f), (t, g)], way);
            }
        }
    }
    let distance = best.0.sqrt();
    Closest {
        distance,
        at: best.1,
        way: best.2 / distance,
    }
}

/// Nearest points of two segments as shares of them, and the way between, by alternating projection from
/// their middles: exact enough for nearly parallel pieces of a bead, and never nearer than they are.
fn segments(
    [a0, a1]: [Vector3<f64>; 2],
    [b0, b1]: [Vector3<f64>; 2],
) -> ([f64; 2], Vector3<f64>) {
    let project = |p: Vector3<f64>, o: Vector3<f64>, e: Vector3<f64>| {
        let d = e - o;
        let f = ((p - o).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
        (f, o + d * f)
    };
    let (mut f, mut p) = (0.5, (a0 + a1) * 0.5);
    let (mut g, mut q) = project(p, b0, b1);
    for _ in 0..6 {
        (f, p) = project(q, a0, a1);
        (g, q) = project(p, b0, b1);
    }
    ([f, g], q - p)
}

/// Depth to which beads may seem to sink into each other between sampled phases, mm: a fraction of
/// the default clearance.
const SINK: f64 = 0.01;

/// Least gap between a bead and its mate's rib, mm.
const RIB_GAP: f64 = 0.06;
