//! Distance between two triangles and from a point to a triangle, with the points where it is taken.
//! Everything is a minimum over features, so it stays continuous through degenerate cases: two
//! triangles that meet have distance zero within rounding, never "no answer".

use nalgebra::Vector3;

use crate::motion::Pose;

/// A triangle with its unit normal (zero when it has no area).
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub corners: [Vector3<f64>; 3],
    pub normal: Vector3<f64>,
}

/// Closest points `p` on the first and `q` on the second shape, and their distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Closest {
    pub distance: f64,
    pub p: Vector3<f64>,
    pub q: Vector3<f64>,
}

impl Triangle {
    pub fn new(corners: [Vector3<f64>; 3]) -> Triangle {
        let [a, b, c] = corners;
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::zeros);
        Triangle { corners, normal }
    }

    /// The triangle in the frame that `pose` leads to.
    pub fn moved(&self, pose: &Pose) -> Triangle {
        Triangle {
            corners: self.corners.map(|v| pose.apply(v)),
            normal: pose.rotation * self.normal,
        }
    }

    pub fn edges(&self) -> [(Vector3<f64>, Vector3<f64>); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }

    /// Smallest height, mm: below the resolution of a mesh the normal means nothing.
    pub fn height(&self) -> f64 {
        let [a, b, c] = self.corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let height = (b - a).cross(&(c - a)).norm() / longest;
        if height.is_finite() { height } else { 0.0 }
    }

    pub fn centroid(&self) -> Vector3<f64> {
        (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0
    }

    /// Where the segment crosses this triangle, border included; `None` when parallel to it.
    pub fn pierced(&self, from: Vector3<f64>, to: Vector3<f64>) -> Option<Vector3<f64>> {
        let [a, b, c] = self.corners;
        let (d0, d1) = (self.normal.dot(&(from - a)), self.normal.dot(&(to - a)));
        // Written so that NaN is no crossing; the distance terms then carry the NaN.
        if d0 == d1 || (d0 > 0.0) == (d1 > 0.0) && d0 != 0.0 && d1 != 0.0 {
            return None;
        }
        let x = from + (to - from) * (d0 / (d0 - d1));
        let inside =
            |u: Vector3<f64>, v: Vector3<f64>| self.normal.dot(&(v - u).cross(&(x - u))) >= 0.0;
        (inside(a, b) && inside(b, c) && inside(c, a)).then_some(x)
    }

    /// Point of the triangle nearest to `p`.
    pub fn nearest(&self, p: Vector3<f64>) -> Vector3<f64> {
        let [a, b, c] = self.corners;
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return a;
        }
        let bp = p - b;
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return b;
        }
        let cp = p - c;
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return c;
        }
        let vc = d1 * d4 - d3 * d2;
        let vb = d5 * d2 - d1 * d6;
        let va = d3 * d6 - d5 * d4;
        let sum = va + vb + vc;
        if vc > 0.0 && vb > 0.0 && va > 0.0 && sum.is_normal() {
            return a + ab * (vb / sum) + ac * (vc / sum);
        }
        // On an edge (or degenerate): the nearest of the three.
        let mut best = a;
        for (u, v) in self.edges() {
            let x = u + (v - u) * fraction(u, v, p);
            if (x - p).norm_squared() < (best - p).norm_squared() {
                best = x;
            }
        }
        best
    }

    /// Closest points of two triangles, or `None` when they are at least `within` apart.
    pub fn closest(&self, other: &Triangle, within: f64) -> Option<Closest> {
        if self.side_of(other).1 >= within || other.side_of(self).1 >= within {
            return None;
        }
        let mut best = Closest {
            distance: within * within,
            p: Vector3::zeros(),
            q: Vector3::zeros(),
        };
        let mut found = false;
        let mut offer = |p: Vector3<f64>, q: Vector3<f64>| {
            let d2 = (p - q).norm_squared();
            // A NaN distance counts as a meeting: undecided is a collision.
            if d2 < best.distance || d2.is_nan() {
                best = Closest {
                    distance: if d2.is_nan() { 0.0 } else { d2 },
                    p,
                    q,
                };
                found = true;
            }
        };
        for (a, b) in self.edges() {
            for (c, d) in other.edges() {
                let (p, q) = segments(a, b, c, d);
                offer(p, q);
            }
        }
        for &v in &self.corners {
            offer(v, other.nearest(v));
        }
        for &v in &other.corners {
            offer(self.nearest(v), v);
        }
        for (a, b) in self.edges() {
            if let Some(x) = other.pierced(a, b) {
                offer(x, x);
            }
        }
        for (a, b) in other.edges() {
            if let Some(x) = self.pierced(a, b) {
                offer(x, x);
            }
        }
        best.distance = best.distance.sqrt();
        found.then_some(best)
    }

    /// The side of this triangle's plane that `other` lies on as a whole (unit vector) and how far
    /// from the plane: a lower bound of their distance; not positive when the plane cuts `other`.
    pub fn side_of(&self, other: &Triangle) -> (Vector3<f64>, f64) {
        let [x, y, z] = other
            .corners
            .map(|v| self.normal.dot(&(v - self.corners[0])));
        let (lo, hi) = (x.min(y).min(z), x.max(y).max(z));
        if lo >= -hi {
            (self.normal, lo)
        } else {
            (-self.normal, -hi)
        }
    }
}

/// Parameter in [0, 1] of the point of segment `u`–`v` nearest to `p`.
fn fraction(u: Vector3<f64>, v: Vector3<f64>, p: Vector3<f64>) -> f64 {
    let d = v - u;
    let len2 = d.norm_squared();
    if len2 > 0.0 {
        (d.dot(&(p - u)) / len2).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// Closest points of segments `a`–`b` and `c`–`d`.
fn segments(
    a: Vector3<f64>,
    b: Vector3<f64>,
    c: Vector3<f64>,
    d: Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let det = uu * vv - uv * uv;
    // Parallel within rounding: any s will do, the two clamped projections below do the rest.
    let mut s = if det > 1e-14 * uu * vv {
        ((uv * vw - vv * uw) / det).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let t = if vv > 0.0 {
        ((uv * s + vw) / vv).clamp(0.0, 1.0)
    } else {
        0.0
    };
    if uu > 0.0 {
        s = ((uv * t - uw) / uu).clamp(0.0, 1.0);
    }
    (a + u * s, c + v * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vector3<f64>> {
        [-2.0..2.0, -2.0..2.0, -2.0..2.0].prop_map(Vector3::from)
    }

    fn triangle() -> impl Strategy<Value = Triangle> {
        [point(), point(), point()].prop_map(Triangle::new)
    }

    /// Dense sampling of both triangles: an upper bound that converges to the distance.
    fn sampled(a: &Triangle, b: &Triangle) -> f64 {
        let grid = |t: &Triangle| {
            let [p, q, r] = t.corners;
            (0..=24)
                .flat_map(move |i| (0..=24 - i).map(move |j| (i, j)))
                .map(move |(i, j)| {
                    p + (q - p) * (f64::from(i) / 24.0) + (r - p) * (f64::from(j) / 24.0)
                })
                .collect::<Vec<_>>()
        };
        let mut best = f64::INFINITY;
        for x in grid(a) {
            best = best.min((b.nearest(x) - x).norm());
        }
        for x in grid(b) {
            best = best.min((a.nearest(x) - x).norm());
        }
        best
    }

    proptest! {
        #[test]
        fn distance_is_the_sampled_one(a in triangle(), b in triangle()) {
            let d = a.closest(&b, f64::INFINITY).unwrap();
            let reference = sampled(&a, &b);
            prop_assert!(d.distance <= reference + 1e-9);
            // Spacing of the samples is at most 4·√3/24.
            prop_assert!(d.distance >= reference - 0.3);
            prop_assert!(((d.p - d.q).norm() - d.distance).abs() < 1e-9);
            prop_assert!((a.nearest(d.p) - d.p).norm() < 1e-9);
            prop_assert!((b.nearest(d.q) - d.q).norm() < 1e-9);
        }

        #[test]
        fn symmetric(a in triangle(), b in triangle()) {
            let d = a.closest(&b, f64::INFINITY).unwrap().distance;
            let e = b.closest(&a, f64::INFINITY).unwrap().distance;
            prop_assert!((d - e).abs() < 1e-9);
        }
    }

    #[test]
    fn crossing_triangles_are_at_zero() {
        let a = Triangle::new([
            Vector3::new(-1.0, -1.0, 0.0),
            Vector3::new(1.0, -1.0, 0.0),
            Vector3::new(0.0, 1.0, 0.0),
        ]);
        let b = Triangle::new([
            Vector3::new(0.0, 0.0, -1.0),
            Vector3::new(0.1, 0.0, 1.0),
            Vector3::new(-0.1, 0.1, 1.0),
        ]);
        assert_eq!(a.closest(&b, f64::INFINITY).unwrap().distance, 0.0);
    }

    #[test]
    fn needles_and_points_have_distances_too() {
        let needle = Triangle::new([Vector3::zeros(), Vector3::x(), Vector3::x() * 2.0]);
        let dot = Triangle::new([Vector3::y() * 3.0 + Vector3::x(); 3]);
        let d = needle.closest(&dot, f64::INFINITY).unwrap();
        assert!((d.distance - 3.0).abs() < 1e-12);
    }
}
