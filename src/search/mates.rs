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

    /// The nearest spot of the rib's middle surface to each of `points` that has less than `near` to spare
    /// there, with the piece that it is on; only what lies between bead and axis counts, the bead is
    /// tested by itself.
    fn beside<'a>(
        &'a self,
        points: &'a [Vector3<f64>],
        near: f64,
    ) -> impl Iterator<Item = (usize, (usize, Beside))> + use<'a> {
        let reach = near + RIB_GAP;
        let level = move |p: &Vector3<f64>| {
            p.z >= self.low - reach
                && p.z <= self.high + reach
                && p.xy().norm_squared() < self.outside
        };
        let points = points.iter().enumerate().filter(move |(_, p)| level(p));
        points.filter_map(move |(i, p)| {
            let mut home = self
                .pieces
                .iter()
                .enumerate()
                .filter(|(_, s)| s.is_level(p));
            let nearest = match home.next() {
                Some((k, s)) if s.is_near(p, reach) => self.descend(p, k),
                Some(_) => return None,
                // Below or above the rib.
                None => [0, self.pieces.len() - 1]
                    .map(|k| self.descend(p, k))
                    .into_iter()
                    .min_by(|a, b| a.1.spare.total_cmp(&b.1.spare))?,
            };
            (nearest.1.spare < near).then_some((i, nearest))
        })
    }

    /// The piece nearest to the point `p`, from piece `k` on: the wall is a smooth surface.
    fn descend(&self, p: &Vector3<f64>, mut k: usize) -> (usize, Beside) {
        let mut best = self.pieces[k].beside(p);
        loop {
            let beside = [k.checked_sub(1), Some(k + 1)].into_iter().flatten();
            let pieces = beside.filter_map(|i| Some((i, self.pieces.get(i)?.beside(p))));
            match pieces.min_by(|a, b| a.1.spare.total_cmp(&b.1.spare)) {
                Some((i, next)) if next.spare < best.spare => (k, best) = (i, next),
                _ => return (k, best),
            }
        }
    }

    /// Whether all `points` keep `limit` from the middle surface of the rib, and [`RIB_GAP`] more where it
    /// is deep.
    fn rib_clears(&self, points: &[Vector3<f64>], limit: f64) -> bool {
        self.beside(points, limit).next().is_none()
    }

    /// Where the `points` have less than `near` to spare beside the rib: of each run of points the nearest
    /// with what it has to spare, the spot of the rib, and the direction from there.
    fn rib_meets(&self, points: &[Vector3<f64>], near: f64) -> Vec<(f64, At, At, Vector3<f64>)> {
        let mut nearest: Vec<Option<(usize, Beside)>> = points.iter().map(|_| None).collect();
        for (i, found) in self.beside(points, near) {
            nearest[i] = Some(found);
        }
        let spare = |n: &Option<(usize, Beside)>| n.as_ref().map_or(f64::INFINITY, |n| n.1.spare);
        let spares: Vec<f64> = nearest.iter().map(spare).collect();
        valleys(&spares)
            .filter_map(|i| {
                let (k, b) = nearest[i].as_ref()?;
                Some((b.spare, (i, 0.0, 1.0), (*k, b.along, b.share), b.way))
            })
            .collect()
    }
}

/// Finite values that are no larger than those beside them.
pub(super) fn valleys(values: &[f64]) -> impl Iterator<Item = usize> {
    let at = |i: Option<usize>| {
        i.and_then(|i| values.get(i))
            .copied()
            .unwrap_or(f64::INFINITY)
    };
    (0..values.len()).filter(move |&i| {
        let here = values[i];
        here.is_finite() && here <= at(i.checked_sub(1)) && here < at(Some(i + 1))
    })
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
    /// Distance from the axis of the nearest point of the wall, as a share of the bead's.
    share: f64,
    /// Unit vector from there to the point.
    way: Vector3<f64>,
    /// Distance to the point, less the gap that is wanted on top of that of bead and bead.
    spare: f64,
}

impl Piece {
    /// Whether the point `p` is at the height of this piece.
    fn is_level(&self, p: &Vector3<f64>) -> bool {
        p.z >= self.low && p.z <= self.high && self.high - self.low > 1e-9
    }

    /// Whether the point `p` at this height may come within `near` of the wall, taken as endless: level
    /// distance, less where the wall leans.
    fn is_near(&self, p: &Vector3<f64>, near: f64) -> bool {
        let edge = self.start + self.along * ((p.z - self.start.z) / self.along.z);
        let across = edge.x * p.y - edge.y * p.x;
        let lean = self.lean * self.lean * p.xy().norm_squared() + 1.0;
        across * across < near * near * edge.xy().norm_squared() * lean
    }

    /// The spot of this piece that is nearest to the point `p`: by turns along the spoke and along the
    /// piece.
    fn beside(&self, p: &Vector3<f64>) -> Beside {
        let (mut along, mut share) = (0.5, 1.0);
        let mut away = Vector3::zeros();
        let mut edge = 0.0;
        for _ in 0..FEET {
            let at = self.start + self.along * along;
            let squared = at.xy().norm_squared();
            edge = squared.sqrt();
            share = (at.xy().dot(&p.xy()) / squared).clamp(0.0, 1.0);
            let narrow = Vector3::new(share, share, 1.0);
            let (start, line) = (
                self.start.component_mul(&narrow),
                self.along.component_mul(&narrow),
            );
            along = ((p - start).dot(&line) / line.norm_squared()).clamp(0.0, 1.0);
            away = p - (start + line * along);
        }
        let distance = away.norm();
        let depth = ((1.0 - share) * edge / RIB_DEPTH).min(1.0);
        Beside {
            along,
            share,
            way: away / distance.max(f64::MIN_POSITIVE),
            spare: distance - RIB_GAP * depth,
        }
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
        let reach = self.radius + self.rib_radius - SINK;
        let back = self.driver.placed(driver_in_follower, self.follower.axis);
        self.driver.rib_clears(&placed, reach) && self.follower.rib_clears(&back, reach)
    }

    /// Where beads and ribs come nearest to each other, with less than `window` to spare, at one phase.
    pub fn meetings(
        &self,
        [follower_in_driver, driver_in_follower]: [&Pose; 2],
        window: f64,
    ) -> Vec<Meeting> {
        let placed = self.follower.placed(follower_in_driver, self.driver.axis);
        let back = self.driver.placed(driver_in_follower, self.follower.axis);
        let limit = 2.0 * self.radius;
        let bead = |(station, along): (usize, f64)| (station, along, 1.0);
        let mut meetings: Vec<Meeting> = all_closest(&self.driver.points, &placed, limit + window)
            .into_iter()
            .map(|beads| Meeting {
                slack: beads.distance - limit,
                at: [bead(beads.at[0]), bead(beads.at[1])],
                way: beads.way,
            })
            .collect();
        let reach = self.radius + self.rib_radius;
        let near = reach + window;
        let driver = self.driver.rib_meets(&placed, near).into_iter();
        meetings.extend(driver.map(|(spare, follower, driver, way)| Meeting {
            slack: spare - reach,
            at: [driver, follower],
            way,
        }));
        let follower = self.follower.rib_meets(&back, near).into_iter();
        meetings.extend(follower.map(|(spare, driver, follower, way)| Meeting {
            slack: spare - reach,
            at: [driver, follower],
            way: -(follower_in_driver.rotation * way),
        }));
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

/// Nearest points of two chains taken as polylines: the nearest pair of points, refined on the segments
/// around it.
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
    refined(a, b, nearest)
}

/// All places where two chains come nearer to each other than `near`.
fn all_closest(a: &[Vector3<f64>], b: &[Vector3<f64>], near: f64) -> Vec<Closest> {
    let nearest = |p: &Vector3<f64>| {
        let away = b.iter().map(|q| (p - q).norm_squared()).enumerate();
        away.min_by(|x, y| x.1.total_cmp(&y.1))
            .unwrap_or((0, f64::INFINITY))
    };
    let pairs: Vec<(usize, f64)> = a.iter().map(nearest).collect();
    let squared: Vec<f64> = pairs.iter().map(|p| p.1).collect();
    let found = valleys(&squared).map(|i| refined(a, b, (squared[i], i, pairs[i].0)));
    found.filter(|c| c.distance < near).collect()
}

fn refined(a: &[Vector3<f64>], b: &[Vector3<f64>], (least, i, k): (f64, usize, usize)) -> Closest {
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
fn segments([a0, a1]: [Vector3<f64>; 2], [b0, b1]: [Vector3<f64>; 2]) -> ([f64; 2], Vector3<f64>) {
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

/// Least gap between a bead and its mate's rib, mm; just behind the contact it grows from nothing, over
/// this depth.
const RIB_GAP: f64 = 0.06;
const RIB_DEPTH: f64 = 0.5;

/// Turns in which the foot of a point on a piece of a rib is found.
const FEET: usize = 4;
