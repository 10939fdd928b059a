//! Takes triangles without area out of a closed mesh: booleans leave them where corners fall on edges.
//! A flat one gives its longest edge up to the line between the corners beside it; a needle shrinks to
//! its tip. Either moves the surface by no more than the sliver is high.

use std::collections::{HashMap, HashSet};

use super::Mesh;

/// Triangles lower than this are slivers, mm: an STL file's single precision, which moves corners by
/// up to 4e-6 mm along each axis at 100 mm, leaves no higher one flat.
const SLIVER: f64 = 2e-5;

/// Edges up to this may shrink to a point, mm.
const NEEDLE: f64 = 2e-5;

/// Rounds after which what is left stays: a chain of slivers takes one each.
const ROUNDS: usize = 16;

/// Removes the slivers of a closed two-manifold mesh as far as it stays one.
pub fn remove(mesh: &mut Mesh) {
    for _ in 0..ROUNDS {
        if !round(mesh) {
            break;
        }
    }
}

/// One pass over all slivers; whether anything changed.
fn round(mesh: &mut Mesh) -> bool {
    let slivers: Vec<usize> = (0..mesh.triangles.len())
        .filter(|&t| height(mesh, mesh.triangles[t]) <= SLIVER)
        .collect();
    if slivers.is_empty() {
        return false;
    }
    let mut owner: HashMap<(u32, u32), usize> = HashMap::new();
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        owner.extend([((a, b), t), ((b, c), t), ((c, a), t)]);
    }
    // What a change has touched waits for the next round, when the owners of edges are known again.
    let mut touched = HashSet::new();
    let mut gone = HashSet::new();
    for t in slivers {
        if touched.contains(&t) {
            continue;
        }
        let mut sides = [0, 1, 2].map(|k| (mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]));
        sides.sort_by(|&x, &y| length(mesh, x).total_cmp(&length(mesh, y)));
        if length(mesh, sides[0]) <= NEEDLE {
            shrink(mesh, sides[0], &mut touched, &mut gone);
        } else {
            flip(mesh, t, sides[2], &owner, &mut touched);
        }
    }
    let before = mesh.triangles.len();
    let mut index = 0..;
    mesh.triangles
        .retain(|_| index.next().is_none_or(|t: usize| !gone.contains(&t)));
    !touched.is_empty() || mesh.triangles.len() < before
}

/// Turns the longest edge of sliver `t` into the other diagonal of it and its neighbour.
fn flip(
    mesh: &mut Mesh,
    t: usize,
    (a, b): (u32, u32),
    owner: &HashMap<(u32, u32), usize>,
    touched: &mut HashSet<usize>,
) {
    let Some(&other) = owner.get(&(b, a)) else {
        return;
    };
    let apex = |t: usize| mesh.triangles[t].into_iter().find(|&v| v != a && v != b);
    let (Some(c), Some(d)) = (apex(t), apex(other)) else {
        return;
    };
    let [one, two] = [[a, d, c], [d, b, c]];
    let blocked = touched.contains(&other)
        || c == d
        || owner.contains_key(&(c, d))
        || owner.contains_key(&(d, c))
        || height(mesh, one).min(height(mesh, two)) <= height(mesh, mesh.triangles[t]);
    if !blocked {
        mesh.triangles[t] = one;
        mesh.triangles[other] = two;
        touched.extend([t, other]);
    }
}

/// Moves corner `b` onto `a` where that keeps the mesh a two-manifold and turns no triangle over.
fn shrink(
    mesh: &mut Mesh,
    (a, b): (u32, u32),
    touched: &mut HashSet<usize>,
    gone: &mut HashSet<usize>,
) {
    let around = |v: u32| -> Vec<usize> {
        (0..mesh.triangles.len())
            .filter(|t| !gone.contains(t) && mesh.triangles[*t].contains(&v))
            .collect()
    };
    let (near_a, near_b) = (around(a), around(b));
    let ring = |near: &[usize]| -> HashSet<u32> {
        near.iter()
            .flat_map(|&t| mesh.triangles[t])
            .filter(|&v| v != a && v != b)
            .collect()
    };
    let common = ring(&near_a).intersection(&ring(&near_b)).count();
    let busy = near_a.iter().chain(&near_b).any(|t| touched.contains(t));
    let moved = |t: usize| mesh.triangles[t].map(|v| if v == b { a } else { v });
    let turns = near_b
        .iter()
        .filter(|&&t| !mesh.triangles[t].contains(&a))
        .any(|&t| {
            let old = normal(mesh, mesh.triangles[t]);
            height(mesh, mesh.triangles[t]) > SLIVER && normal(mesh, moved(t)).dot(&old) <= 0.0
        });
    if common != 2 || busy || turns {
        return;
    }
    let changed: Vec<(usize, [u32; 3])> = near_b.iter().map(|&t| (t, moved(t))).collect();
    for (t, corners) in changed {
        if mesh.triangles[t].contains(&a) {
            gone.insert(t);
        }
        mesh.triangles[t] = corners;
    }
    touched.extend(near_a.into_iter().chain(near_b));
}

fn normal(mesh: &Mesh, [a, b, c]: [u32; 3]) -> nalgebra::Vector3<f64> {
    (mesh.vertex(b) - mesh.vertex(a)).cross(&(mesh.vertex(c) - mesh.vertex(a)))
}

fn length(mesh: &Mesh, (a, b): (u32, u32)) -> f64 {
    (mesh.vertex(b) - mesh.vertex(a)).norm()
}

fn height(mesh: &Mesh, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle;
    let longest = length(mesh, (a, b))
        .max(length(mesh, (b, c)))
        .max(length(mesh, (c, a)));
    let height = normal(mesh, triangle).norm() / longest;
    if height.is_finite() { height } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::Defect;
    use crate::verify::mesh::problems;

    /// A box whose front edge carries a corner: `shift` along the edge, with a flat triangle beside it.
    fn block_with_sliver(shift: f64) -> Mesh {
        let corner = |i: u32| {
            [
                f64::from(i & 1),
                f64::from(i >> 1 & 1),
                f64::from(i >> 2 & 1),
            ]
        };
        let mut vertices: Vec<[f64; 3]> = (0..8).map(corner).collect();
        vertices.push([shift, 0.0, 0.0]);
        let mut triangles = vec![
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
            [2, 6, 7],
            [2, 7, 3],
        ];
        // Front face 0-1-5-4 with corner 8 on its edge 0-1, and a flat triangle 0-1-8 below it.
        triangles.extend([[8, 1, 5], [8, 5, 4], [8, 4, 0], [0, 1, 8]]);
        Mesh {
            vertices,
            triangles,
        }
    }

    #[test]
    fn flat_triangles_and_needles_go_and_the_body_stays() {
        for shift in [0.4, 1e-6] {
            let mut mesh = block_with_sliver(shift);
            let found = problems("box", &mesh);
            assert!(found.iter().any(|p| p.defect == Defect::Degenerate));
            remove(&mut mesh);
            assert_eq!(problems("box", &mesh), vec![]);
            assert!((mesh.volume() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn no_triangle_is_left_that_single_precision_makes_flat() {
        let mut mesh = block_with_sliver(0.4);
        for v in &mut mesh.vertices {
            v[2] += 100.0;
        }
        // The corner stands out by less than single precision shows beside 100.
        mesh.vertices[8][2] -= 3e-6;
        assert!(mesh.triangles.iter().any(|&t| height(&mesh, t) < 4e-6));
        remove(&mut mesh);
        for v in mesh.vertices.iter_mut().flatten() {
            *v = f64::from(*v as f32);
        }
        assert_eq!(problems("box", &mesh), vec![]);
    }
}
