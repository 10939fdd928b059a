//! STL: binary out, binary and ASCII in.

use std::io::Cursor;
use std::path::Path;

use crate::solid::Mesh;
use crate::{Error, Problem, Result};

/// Larger files are refused before they are read: five million triangles.
const MAX_BYTES: u64 = 250_000_000;

/// Reads an STL file, ASCII or binary, mm; corners at the same place become one vertex.
///
/// # Errors
/// [`Error::Io`] when it cannot be read, [`Error::Input`] when it is no STL file, breaks off, or has
/// no triangles or coordinates that are no numbers.
pub fn read(path: &Path) -> Result<Mesh> {
    // To open a pipe is to wait for its writer.
    let about = std::fs::metadata(path).map_err(Error::io(path))?;
    let refuse = |what: &str, hint| Err(Error::input(path, Problem::new("STL", what, hint)));
    if !about.is_file() {
        return refuse("is not a regular file", "give the path of an STL file");
    }
    if about.len() > MAX_BYTES {
        let what = format!(
            "has {} MB, allowed {}",
            about.len() / 1_000_000,
            MAX_BYTES / 1_000_000
        );
        return refuse(&what, "export it with fewer triangles, or as binary STL");
    }
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    parse(bytes, path)
}

/// Understands the bytes of the STL file `path`.
///
/// # Errors
/// [`Error::Input`] as [`read`].
pub fn parse(mut bytes: Vec<u8>, path: &Path) -> Result<Mesh> {
    let wrong = |what: String| {
        let hint = "export the part as STL, ASCII or binary, in mm";
        Error::input(path, vec![Problem::new("STL", what, hint)])
    };
    // Some programs begin binary files with the word that marks ASCII ones; the length tells.
    let count = bytes.get(80..84).and_then(|n| <[u8; 4]>::try_from(n).ok());
    let binary = count.is_some_and(|n| bytes.len() == 84 + 50 * u32::from_le_bytes(n) as usize);
    if binary {
        bytes[..5].fill(b' ');
    } else {
        let text = bytes.trim_ascii();
        let has = |at: Option<&[u8]>, word: &[u8]| at.is_some_and(|b| b.eq_ignore_ascii_case(word));
        if !has(text.get(..5), b"solid") {
            return Err(wrong(
                "is neither ASCII nor binary STL of the length it states".into(),
            ));
        }
        let last = text.rsplit(|b| *b == b'\n').next().unwrap_or_default();
        if !has(last.trim_ascii().get(..8), b"endsolid") {
            return Err(wrong(
                "breaks off: ASCII STL ends with `endsolid`, binary STL has the length it states"
                    .into(),
            ));
        }
        bytes = text.to_vec();
        bytes[..5].make_ascii_lowercase();
    }
    let stl = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| wrong(e.to_string()))?;
    if stl.faces.is_empty() {
        return Err(wrong("has no triangles".into()));
    }
    if stl
        .vertices
        .iter()
        .any(|v| (0..3).any(|i| !v[i].is_finite()))
    {
        return Err(wrong("has coordinates that are no numbers".into()));
    }
    Ok(Mesh {
        vertices: stl
            .vertices
            .iter()
            .map(|v| [0, 1, 2].map(|i| f64::from(v[i])))
            .collect(),
        triangles: stl
            .faces
            .iter()
            .map(|f| f.vertices.map(|i| i as u32))
            .collect(),
    })
}

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
