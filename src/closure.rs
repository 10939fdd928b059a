//! The measure of dynamic form closure Q (Eq. 4): signed distance from the zero wrench to the boundary
//! of the convex hull of the K projected contact normals, positive inside.

use nalgebra::{Matrix4, Vector3, Vector4};

use crate::motion::Class;

/// Projected generalised normal n̄ in R^N, padded with zeros (order: linear, angular; 1 and mm).
pub type Wrench = [f64; 4];

/// n̄ of contact point `p`, normal `n` about joint centre `centre`, all in Σ; moments are divided by
/// `length` (1 for Q as published, L/2 for the dimensionless Q*).
pub fn wrench(
    class: Class,
    p: Vector3<f64>,
    n: Vector3<f64>,
    centre: Vector3<f64>,
    length: f64,
) -> Wrench {
    let m = (p - centre).cross(&n) / length;
    match class {
        Class::R1 => [m.z, 0.0, 0.0, 0.0],
        Class::R1T1 => [n.z, m.z, 0.0, 0.0],
        Class::R3 => [m.x, m.y, m.z, 0.0],
        Class::R3T1 => [n.z, m.x, m.y, m.z],
    }
}

/// Q of the wrenches in R^`dof`. Inside the hull it is the distance to the nearest facet; outside it is
/// minus the distance to the most violated facet plane, which is continuous across the boundary and
/// never larger in size than the distance to the hull.
///
/// Facets are found by enumerating the N-subsets, which is exact and cheap for the few contacts of a
/// gear. Fewer than N+1 wrenches, a flat hull or a NaN give −∞: no closure.
pub fn measure(wrenches: &[Wrench], dof: usize) -> f64 {
    measure_above(wrenches, dof, f64::NEG_INFINITY)
}

/// [`measure`], but free to return early with any value ≤ `floor` once Q is known not to exceed it.
pub fn measure_above(wrenches: &[Wrench], dof: usize, floor: f64) -> f64 {
    if wrenches.len() <= dof || wrenches.iter().flatten().any(|x| !x.is_finite()) {
        return f64::NEG_INFINITY;
    }
    if dof == 1 {
        let lo = wrenches.iter().map(|w| w[0]).fold(f64::INFINITY, f64::min);
        let hi = wrenches
            .iter()
            .map(|w| w[0])
            .fold(f64::NEG_INFINITY, f64::max);
        return hi.min(-lo);
    }
    let mut q = f64::INFINITY;
    let mut subset: Vec<usize> = (0..dof).collect();
    loop {
        if let Some((_, distance)) = facet(wrenches, &subset, dof) {
            q = q.min(distance);
            if q <= floor {
                return q;
            }
        }
        if !next_subset(&mut subset, wrenches.len()) {
            break;
        }
    }
    if q.is_finite() { q } else { f64::NEG_INFINITY }
}

/// A facet of the hull, as far as Q rests on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Facet {
    /// Signed distance from the zero wrench, outward positive.
    pub distance: f64,
    /// Outward unit normal.
    pub normal: Wrench,
    /// Its wrenches with the weights, of sum 1, at which they average to the point of its plane nearest
    /// to zero: the distance changes by Σ weight · (normal · change of the wrench).
    pub weights: Vec<(usize, f64)>,
}

/// Facets of the hull of the wrenches in R^`dof`; none where there is no hull (see [`measure`]).
pub fn facets(wrenches: &[Wrench], dof: usize) -> Vec<Facet> {
    if wrenches.len() <= dof || wrenches.iter().flatten().any(|x| !x.is_finite()) {
        return Vec::new();
    }
    if dof == 1 {
        let end = |sign: f64| {
            let along = |i: &usize| sign * wrenches[*i][0];
            let last = (0..wrenches.len()).max_by(|a, b| along(a).total_cmp(&along(b)));
            last.map(|i| Facet {
                distance: along(&i),
                normal: [sign, 0.0, 0.0, 0.0],
                weights: vec![(i, 1.0)],
            })
        };
        return [1.0, -1.0].into_iter().filter_map(end).collect();
    }
    let mut facets = Vec::new();
    let mut subset: Vec<usize> = (0..dof).collect();
    loop {
        if let Some((normal, distance)) = facet(wrenches, &subset, dof)
            && let Some(weights) = weights(wrenches, &subset, (normal, distance))
        {
            facets.push(Facet {
                distance,
                normal,
                weights,
            });
        }
        if !next_subset(&mut subset, wrenches.len()) {
            return facets;
        }
    }
}

/// Weights of the wrenches of a facet, see [`Facet`].
fn weights(
    wrenches: &[Wrench],
    subset: &[usize],
    (normal, distance): (Wrench, f64),
) -> Option<Vec<(usize, f64)>> {
    let dof = subset.len();
    let base = Vector4::from(wrenches[subset[0]]);
    let normal = Vector4::from(normal);
    // Differences to the first wrench, the normal, and what the space lacks to four dimensions.
    let matrix = Matrix4::from_fn(|row, column| match column {
        c if c + 1 < dof => wrenches[subset[c + 1]][row] - base[row],
        c if c + 1 == dof => normal[row],
        c => f64::from(row == c),
    });
    let shares = matrix.lu().solve(&(normal * distance - base))?;
    let first = 1.0 - shares.iter().take(dof - 1).sum::<f64>();
    let all = std::iter::once(first).chain(shares.iter().copied());
    Some(subset.iter().copied().zip(all).collect())
}

/// Outward unit normal and signed distance from zero, outward positive, of the facet through `subset`, when
/// all other points are on one side of it.
fn facet(wrenches: &[Wrench], subset: &[usize], dof: usize) -> Option<(Wrench, f64)> {
    let normal = hyperplane_normal(wrenches, subset, dof);
    let norm = dot(&normal, &normal).sqrt();
    let base = &wrenches[subset[0]];
    let scale = wrenches
        .iter()
        .map(|w| dot(w, w))
        .fold(0.0, f64::max)
        .sqrt();
    if norm <= 1e-12 * scale.powi(dof as i32 - 1) {
        return None;
    }
    let offset = dot(&normal, base) / norm;
    let (mut above, mut below) = (0.0_f64, 0.0_f64);
    for (i, w) in wrenches.iter().enumerate() {
        if !subset.contains(&i) {
            let side = dot(&normal, w) / norm - offset;
            above = above.max(side);
            below = below.min(side);
        }
    }
    let flat = 1e-12 * scale;
    let outward = match (above > flat, below < -flat) {
        (false, true) => 1.0,
        (true, false) => -1.0,
        _ => return None,
    };
    Some((normal.map(|x| outward * x / norm), outward * offset))
}

fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// Generalised cross product of the differences of `dof` points: normal of their hyperplane.
fn hyperplane_normal(wrenches: &[Wrench], subset: &[usize], dof: usize) -> Wrench {
    let d = |i: usize| -> Wrench {
        let (a, b) = (&wrenches[subset[i]], &wrenches[subset[0]]);
        [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
    };
    match dof {
        2 => {
            let a = d(1);
            [-a[1], a[0], 0.0, 0.0]
        }
        3 => {
            let (a, b) = (d(1), d(2));
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
                0.0,
            ]
        }
        _ => {
            let (a, b, c) = (d(1), d(2), d(3));
            let minor = |i: usize, j: usize, k: usize| {
                a[i] * (b[j] * c[k] - b[k] * c[j]) - a[j] * (b[i] * c[k] - b[k] * c[i])
                    + a[k] * (b[i] * c[j] - b[j] * c[i])
            };
            [
                minor(1, 2, 3),
                -minor(0, 2, 3),
                minor(0, 1, 3),
                -minor(0, 1, 2),
            ]
        }
    }
}

/// Next subset in lexicographic order of indices below `count`; false after the last.
pub(crate) fn next_subset(subset: &mut [usize], count: usize) -> bool {
    let size = subset.len();
    for i in (0..size).rev() {
        if subset[i] < count - size + i {
            subset[i] += 1;
            for k in i + 1..size {
                subset[k] = subset[k - 1] + 1;
            }
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn regular_simplex_has_inradius_r_over_n() {
        let tetrahedron = [
            [1.0, 1.0, 1.0, 0.0],
            [1.0, -1.0, -1.0, 0.0],
            [-1.0, 1.0, -1.0, 0.0],
            [-1.0, -1.0, 1.0, 0.0],
        ];
        assert_relative_eq!(measure(&tetrahedron, 3), 3f64.sqrt() / 3.0, epsilon = 1e-12);
        let s = (5.0_f64).sqrt().recip();
        let simplex4 = [
            [1.0, 1.0, 1.0, -s],
            [1.0, -1.0, -1.0, -s],
            [-1.0, 1.0, -1.0, -s],
            [-1.0, -1.0, 1.0, -s],
            [0.0, 0.0, 0.0, 4.0 * s],
        ];
        assert_relative_eq!(measure(&simplex4, 4), s, epsilon = 1e-12);
    }

    #[test]
    fn interval_triangle_and_octahedron() {
        assert_relative_eq!(
            measure(&[[3.0, 0.0, 0.0, 0.0], [-2.0, 0.0, 0.0, 0.0]], 1),
            2.0
        );
        assert_relative_eq!(
            measure(&[[3.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]], 1),
            -2.0
        );
        let h = 0.75_f64.sqrt();
        let triangle = [
            [1.0, 0.0, 0.0, 0.0],
            [-0.5, h, 0.0, 0.0],
            [-0.5, -h, 0.0, 0.0],
        ];
        assert_relative_eq!(measure(&triangle, 2), 0.5, epsilon = 1e-12);
        let mut octahedron = Vec::new();
        for i in 0..3 {
            for s in [-1.0, 1.0] {
                let mut w = [0.0; 4];
                w[i] = s;
                octahedron.push(w);
            }
        }
        assert_relative_eq!(measure(&octahedron, 3), 1.0 / 3f64.sqrt(), epsilon = 1e-12);
    }

    #[test]
    fn flat_or_broken_hulls_do_not_close() {
        let flat = [
            [1.0, 0.0, 0.0, 0.0],
            [-1.0, 1.0, 0.0, 0.0],
            [-1.0, -1.0, 0.0, 0.0],
            [0.5, 0.5, 0.0, 0.0],
        ];
        assert!(measure(&flat, 3) <= 0.0);
        assert!(measure(&[[f64::NAN; 4]; 5], 4) < 0.0);
        assert!(measure(&flat[..3], 3) < 0.0);
    }

    proptest! {
        /// The least distance of a facet is Q, and it follows a change of the wrenches as the weights say.
        #[test]
        fn facets_follow_their_wrenches(
            dof in 1usize..=4,
            points in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 5..8),
            change in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 8),
        ) {
            let within = |w: &Wrench| std::array::from_fn(|i| if i < dof { w[i] } else { 0.0 });
            let points: Vec<Wrench> = points.iter().map(within).collect();
            let least = |facets: &[Facet]| {
                facets.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).cloned()
            };
            let Some(facet) = least(&facets(&points, dof)) else {
                return Err(TestCaseError::fail("no facets"));
            };
            prop_assert!((facet.distance - measure(&points, dof)).abs() < 1e-12);
            prop_assert!((facet.weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-9);
            let rate: f64 = facet.weights.iter().map(|&(i, weight)| {
                weight * dot(&facet.normal, &within(&change[i]))
            }).sum();
            let step = 1e-7;
            let moved: Vec<Wrench> = points.iter().zip(&change).map(|(p, c)| {
                let c = within(c);
                std::array::from_fn(|i| p[i] + step * c[i])
            }).collect();
            let same = facets(&moved, dof).into_iter().find(|f| {
                f.weights.iter().map(|w| w.0).eq(facet.weights.iter().map(|w| w.0))
                    && dot(&f.normal, &facet.normal) > 0.9
            });
            // Slender facets turn quickly: what is left of second order grows with the weights.
            let slender = facet.weights.iter().map(|w| w.1.abs()).fold(1.0, f64::max);
            if let Some(same) = same.filter(|_| slender < 10.0) {
                prop_assert!(((same.distance - facet.distance) / step - rate).abs() < 1e-2);
            }
        }

        /// No direction is left in which the support function of a closed hull falls below Q.
        #[test]
        fn q_bounds_the_support_function(
            points in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 5..8),
            direction in prop::array::uniform4(-1.0f64..1.0),
        ) {
            let q = measure(&points, 4);
            let norm = dot(&direction, &direction).sqrt();
            prop_assume!(norm > 0.1);
            let support = points.iter().map(|w| dot(w, &direction) / norm).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(q <= support.max(0.0) + 1e-9, "q {} support {}", q, support);
        }

        /// Q does not change when all wrenches are rotated in a coordinate plane.
        #[test]
        fn q_is_invariant_under_rotation(
            points in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 4..7),
            angle in 0.0f64..6.0,
        ) {
            let (s, c) = angle.sin_cos();
            let a: Vec<Wrench> = points.iter().map(|p| [p[0], p[1], p[2], 0.0]).collect();
            let b: Vec<Wrench> = points.iter().map(|p| [c * p[0] - s * p[2], p[1], s * p[0] + c * p[2], 0.0]).collect();
            prop_assert!((measure(&a, 3) - measure(&b, 3)).abs() < 1e-9);
        }
    }
}
