//! Can the pieces be made: size against the printer, faces that need support.

use nalgebra::Vector3;

use super::claim::{Claim, Spot};
use crate::settings::Fit;
use crate::solid::Mesh;

/// Faces that lean farther than this from upright need support, deg.
pub const OVERHANG_DEG: f64 = 45.0;

/// The printer that pieces have to suit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printer {
    /// Room on the bed, x, y, z, mm. Default 220 × 220 × 250.
    pub volume_mm: [f64; 3],
    /// How far a printed surface may lie outside its place, mm: `fit.surface_error_mm` of the design.
    pub tolerance_mm: f64,
    /// Faces that lean farther than this from upright need support, deg. Default 45.
    pub overhang_deg: f64,
}

impl Printer {
    /// The usual printer, as accurate as `fit` says.
    pub fn of(fit: &Fit) -> Printer {
        Printer {
            volume_mm: [220.0, 220.0, 250.0],
            tolerance_mm: fit.surface_error_mm,
            overhang_deg: OVERHANG_DEG,
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
        let limit = printer.overhang_deg;
        let hanging = Overhang::of(mesh, limit);
        claims.push(
            Claim::new(
                format!("overhangs of {name}"),
                "how much of the piece hangs in the air: support material for a filament printer",
            )
            .say(
                hanging.area_mm2.is_finite(),
                match hanging.area_mm2 {
                    0.0 => format!("none beyond {limit:.0}°"),
                    area if area.is_finite() => {
                        format!("{area:.0} mm² up to {:.0}°", hanging.steepest_deg)
                    }
                    _ => "undecided: not a number".into(),
                },
                &format!("known (beyond {limit:.0}° from upright counts)"),
            )
            .measured(hanging.area_mm2, "mm²", f64::INFINITY)
            .at(Spot {
                at_mm: hanging.at,
                ..Spot::default()
            }),
        );
    }
    claims
}

/// Faces of a piece, as it lies on z = 0, that look down too flatly to be printed without support.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overhang {
    /// Their area, mm².
    pub area_mm2: f64,
    /// Angle from upright of the flattest of them: 90 is a ceiling, deg.
    pub steepest_deg: f64,
    /// The middle of that face.
    pub at: Option<[f64; 3]>,
}

impl Overhang {
    /// Faces leaning more than `limit_deg` from upright that are off the bed.
    pub fn of(mesh: &Mesh, limit_deg: f64) -> Overhang {
        let mut found = Overhang::default();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.vertex(i));
            let area: Vector3<f64> = (b - a).cross(&(c - a)) / 2.0;
            let size = area.norm();
            let on_bed = a.z.max(b.z).max(c.z) < 0.1;
            let lean = (-area.z / size).clamp(-1.0, 1.0).asin().to_degrees();
            if size == 0.0 || on_bed || lean <= limit_deg {
                continue;
            }
            found.area_mm2 += size;
            if !(lean <= found.steepest_deg) {
                found.steepest_deg = lean;
                found.at = Some(((a + b + c) / 3.0).into());
            }
        }
        found
    }
}
