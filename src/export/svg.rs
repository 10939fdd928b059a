//! Drawings in true size: cross sections of hubs, plates and pieces, as closed outlines for laser
//! cutters and for checking dimensions.

use std::fmt::Write as _;

use nalgebra::Vector3;

use super::{File, Source};
use crate::solid::{Mesh, Solids};
use crate::{Error, Result};

/// Margin around a drawing, mm.
const MARGIN: f64 = 5.0;

/// Greatest height above the bed, and depth below the top, of the outer sections, mm: low enough for
/// the plate under a tower.
const NEAR_FACE: f64 = 2.0;

/// Corners closer than this are one, mm.
const SAME: f64 = 1e-7;

/// Three outlines of every piece to print: near its bed, at half height, near its top.
///
/// # Errors
/// [`Error::Internal`] when a section is not a set of closed outlines.
pub fn drawings(source: &Source, solids: &Solids, part: Option<&str>) -> Result<Vec<File>> {
    let wanted = solids
        .pieces
        .iter()
        .filter(|p| part.is_none_or(|part| part == p.body));
    wanted
        .map(|piece| {
            let title = format!("{}: {}", source.design.name, piece.name);
            let text = drawing(&title, &piece.mesh)?;
            Ok(File::new(format!("{}.svg", piece.name), text))
        })
        .collect()
}

/// Sections of a mesh that lies on z = 0, side by side on one sheet.
fn drawing(title: &str, mesh: &Mesh) -> Result<String> {
    let (lo, hi) = mesh.bounds();
    let size = hi - lo;
    let near = (0.1 * size.z).min(NEAR_FACE);
    let heights = [lo.z + near, lo.z + 0.5 * size.z, hi.z - near];
    let sheet = (
        3.0 * (size.x + MARGIN) + MARGIN,
        size.y + 2.0 * MARGIN + 10.0,
    );
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w:.3}mm\" height=\"{h:.3}mm\" \
         viewBox=\"0 0 {w:.3} {h:.3}\">\n<title>{t}</title>\n",
        w = sheet.0,
        h = sheet.1,
        t = crate::escape::markup(title),
    );
    for (i, z) in heights.into_iter().enumerate() {
        let left = MARGIN + i as f64 * (size.x + MARGIN);
        let mut path = String::new();
        for outline in outlines(mesh, z)? {
            let corners: Vec<String> = outline
                .iter()
                .map(|[x, y]| format!("{:.4} {:.4}", x - lo.x + left, hi.y - y + MARGIN))
                .collect();
            path += &format!("M{}Z", corners.join("L"));
        }
        // Writing to a String cannot fail.
        let _ = writeln!(
            svg,
            "<g id=\"section_{n}\">\n<path d=\"{path}\" fill=\"none\" stroke=\"black\" \
             stroke-width=\"0.1\" fill-rule=\"evenodd\"/>\n<text x=\"{left:.3}\" y=\"{y:.3}\" \
             font-size=\"3\" font-family=\"sans-serif\">z = {h:.2} of {total:.2} mm</text>\n</g>",
            n = i + 1,
            y = sheet.1 - 4.0,
            h = z - lo.z,
            total = size.z,
        );
    }
    svg += "</svg>\n";
    Ok(svg)
}

/// Closed outlines of the section of a closed mesh at height `z`; outer ones turn
/// counter-clockwise, holes clockwise.
///
/// # Errors
/// [`Error::Internal`] when the mesh is open there.
pub fn outlines(mesh: &Mesh, z: f64) -> Result<Vec<Vec<[f64; 2]>>> {
    // Each triangle that the plane meets gives one piece, from the edge that goes down through the
    // plane to the edge that goes up; edges are named by their vertices, so pieces join exactly.
    let above = |i: u32| mesh.vertices[i as usize][2] > z;
    let mut next = std::collections::BTreeMap::new();
    for triangle in &mesh.triangles {
        let mut ends = [None, None];
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            match (above(a), above(b)) {
                (true, false) => ends[0] = Some((b, a)),
                (false, true) => ends[1] = Some((a, b)),
                _ => {}
            }
        }
        if let [Some(down), Some(up)] = ends {
            next.insert(down, up);
        }
    }
    let point = |(below, over): (u32, u32)| {
        let (a, b): (Vector3<f64>, Vector3<f64>) = (mesh.vertex(below), mesh.vertex(over));
        let p = a + (b - a) * ((z - a.z) / (b.z - a.z));
        [p.x, p.y]
    };
    let mut outlines = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut outline = vec![point(start)];
        while at != start {
            let corner = point(at);
            let last = outline[outline.len() - 1];
            if (corner[0] - last[0]).hypot(corner[1] - last[1]) > SAME {
                outline.push(corner);
            }
            at = next.remove(&at).ok_or_else(|| {
                Error::Internal(format!("drawing: the mesh is open at z = {z:.3} mm"))
            })?;
        }
        if outline.len() > 2 {
            outlines.push(outline);
        }
    }
    Ok(outlines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::kernel::{Solid, lathe};

    fn area(outline: &[[f64; 2]]) -> f64 {
        let n = outline.len();
        (0..n)
            .map(|i| {
                let (a, b) = (outline[i], outline[(i + 1) % n]);
                0.5 * (a[0] * b[1] - a[1] * b[0])
            })
            .sum()
    }

    #[test]
    fn a_tube_has_an_outer_outline_and_a_hole() {
        let solid = |radius| {
            Solid::new(&lathe(&[(radius, 0.0), (radius, 2.0)], 4), "prism").expect("sound")
        };
        let high = lathe(&[(1.0, -1.0), (1.0, 3.0)], 4);
        let tube = solid(2.0).difference(&Solid::new(&high, "hole").expect("sound"));
        let found = outlines(&tube.mesh(), 1.0).expect("closed");
        let mut areas: Vec<f64> = found.iter().map(|o| area(o)).collect();
        areas.sort_by(f64::total_cmp);
        // Squares standing on a corner: area 2r².
        assert_eq!(areas.len(), 2);
        assert!((areas[0] + 2.0).abs() < 1e-9, "hole: {}", areas[0]);
        assert!((areas[1] - 8.0).abs() < 1e-9, "outside: {}", areas[1]);
    }

    #[test]
    fn an_open_mesh_is_refused() {
        let mut mesh = lathe(&[(1.0, 0.0), (1.0, 2.0)], 6);
        mesh.triangles.remove(0);
        assert!(outlines(&mesh, 1.0).is_err());
    }
}
