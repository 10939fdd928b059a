//! Binary STL.

use crate::solid::Mesh;
use crate::{Error, Result};

/// The mesh as binary STL, mm. Corners are rounded to f32; triangles that the rounding makes
/// degenerate keep their place, so that the surface stays closed.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails.
pub fn binary(mesh: &Mesh) -> Result<Vec<u8>> {
    let corner = |i: u32| stl_io::Vertex::new(mesh.vertices[i as usize].map(|c| c as f32));
    let triangles: Vec<stl_io::Triangle> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.vertex(i));
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
            stl_io::Triangle {
                normal: stl_io::Normal::new(normal.unwrap_or_default().map(|x| x as f32).into()),
                vertices: t.map(corner),
            }
        })
        .collect();
    let mut bytes = Vec::with_capacity(84 + 50 * triangles.len());
    stl_io::write_stl(&mut bytes, triangles.iter())
        .map_err(|e| Error::Internal(format!("STL: {e}")))?;
    Ok(bytes)
}
