//! Gears as meshes.

use nalgebra::{Rotation2, Vector2};

use super::{Pair, profile};
use crate::solid::Mesh;

/// Radius of the hole for the shaft, as a share of that of the roots.
const BORE: f64 = 0.25;

/// Gear `i` of a pair as a mesh, in place at φ = 0: the follower's axis is z, the driver's is at x = −L, the
/// teeth mesh, and the face is between z = 0 and the face width, mm.
pub fn mesh(pair: &Pair, i: usize) -> Mesh {
    let outline = profile::outline(pair, i);
    let pitch = std::f64::consts::TAU / pair.wheels[i].teeth as f64;
    // A gap of the driver looks at the follower, where a tooth of that looks at the driver.
    let (place, turn) = match i {
        0 => (-pair.center_distance, 0.0),
        _ => (0.0, std::f64::consts::PI + 0.5 * pitch),
    };
    let points: Vec<Vector2<f64>> = outline.iter().map(|p| Rotation2::new(turn) * p).collect();
    let root = points
        .iter()
        .map(|p| p.norm())
        .fold(f64::INFINITY, f64::min);
    let bore = points.iter().map(|p| p.normalize() * (BORE * root));
    let inner: Vec<Vector2<f64>> = bore.collect();
    let count = points.len() as u32;
    let mut mesh = Mesh::default();
    for z in [0.0, pair.face_width] {
        for p in points.iter().chain(&inner) {
            mesh.vertices.push([p.x + place, p.y, z]);
        }
    }
    // Rings: outside below, inside below, outside above, inside above.
    let [out_low, in_low, out_high, in_high] = [0, 1, 2, 3].map(|ring| ring * count);
    let mut strip = |a: u32, b: u32| {
        for k in 0..count {
            let next = (k + 1) % count;
            mesh.triangles.push([a + k, a + next, b + next]);
            mesh.triangles.push([a + k, b + next, b + k]);
        }
    };
    strip(out_low, out_high);
    strip(out_high, in_high);
    strip(in_high, in_low);
    strip(in_low, out_low);
    mesh
}
