//! Can the pieces be made: size against the printer, faces that need support.

use nalgebra::Vector3;

use super::claim::Claim;
use crate::solid::Mesh;

/// The printer that pieces have to suit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printer {
    /// Room on the bed, x, y, z, mm. Default 220 × 220 × 250.
    pub volume_mm: [f64; 3],
    /// How far a printed surface may lie outside its place, mm. Default 0.03.
    pub tolerance_mm: f64,
    /// Faces flatter than this above the horizontal need support, deg. Default 45.
    pub overhang_deg: f64,
}

impl Default for Printer {
    fn default() -> Self {
        Printer {
            volume_mm: [220.0, 220.0, 250.0],
            tolerance_mm: 0.03,
            overhang_deg: 45.0,
        }
    }
}

/// Claims about the pieces as they lie on the bed (z = 0).
pub(super) fn claims<'a>(
    pieces: impl Iterator<Item = (&'a str, &'a Mesh)>,
    printer: &Printer,
) -> Vec<Claim> {
    let mut claims = Vec::new();
    for (name, mesh) in pieces {
        let (lo, hi) = mesh.bounds();
        let size = hi - lo;
        let [x, y, z] = printer.volume_mm;
        let fits = size.z <= z && (size.x <= x && size.y <= y || size.x <= y && size.y <= x);
        claims.push(
            Claim::new(
                format!("{name} fits the printer"),
                "the piece can be printed in one go",
            )
            .say(
                fits,
                format!("{:.1} × {:.1} × {:.1} mm", size.x, size.y, size.z),
                &format!("≤ {x:.0} × {y:.0} × {z:.0} mm"),
            ),
        );
        let area = overhang(mesh, printer.overhang_deg);
        let name = format!("overhangs of {name}");
        let meaning =
            "how much of the piece hangs in the air: support material for a filament printer";
        let limit = format!("known (steeper than {:.0}° counts)", printer.overhang_deg);
        claims.push(match area {
            a if a.is_finite() => {
                Claim::new(name, meaning).say(true, format!("{a:.0} mm²"), &limit)
            }
            _ => Claim::new(name, meaning).undecided("not a number"),
        });
    }
    claims
}

/// Area of the faces that look down flatter than `limit_deg` and are off the bed, mm².
fn overhang(mesh: &Mesh, limit_deg: f64) -> f64 {
    let flat = limit_deg.to_radians().cos();
    mesh.triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.vertex(i));
            let area: Vector3<f64> = (b - a).cross(&(c - a)) / 2.0;
            let on_bed = a.z.max(b.z).max(c.z) < 0.1;
            let hangs = -area.z > flat * area.norm() && !on_bed;
            if hangs { area.norm() } else { 0.0 }
        })
        .sum()
}
