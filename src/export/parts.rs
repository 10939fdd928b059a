//! `parts.md`: what to print, what to buy, how to assemble.

use nalgebra::Vector3;
use serde::Serialize;

use super::template;
use crate::Result;
use crate::design::Design;
use crate::settings::{Fit, Profile};
use crate::solid::{Mesh, Solids, pieces};
use crate::verify::{OVERHANG_DEG, Overhang};

/// A piece whose height is more than this many times the width of its foot needs a brim.
const SLENDER: f64 = 3.0;

#[derive(Serialize)]
struct Printed<'a> {
    name: &'a str,
    count: u32,
    what: &'a str,
    size: String,
    volume: String,
    /// Whether it stands too slender to stick by its own foot.
    brim: bool,
    /// Faces that need support, cm².
    support: String,
}

#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    class: String,
    generator: String,
    profile: Option<&'static str>,
    fit: &'a Fit,
    printed: Vec<Printed<'a>>,
    bought: &'a [(u32, String)],
    steps: &'a [String],
}

/// Outer dimensions of meshes together, "x × y × z" in mm.
pub(super) fn extent<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> String {
    let bounds = meshes.into_iter().map(Mesh::bounds);
    let both = bounds.reduce(|(lo, hi), (low, high)| (lo.inf(&low), hi.sup(&high)));
    let size = both.map_or_else(Vector3::zeros, |(lo, hi)| hi - lo);
    format!("{:.1} × {:.1} × {:.1}", size.x, size.y, size.z)
}

/// The parts list with the order of assembly, Markdown.
///
/// # Errors
/// [`crate::Error::Internal`] when the template fails.
pub fn markdown(design: &Design, solids: &Solids) -> Result<String> {
    let assembly = pieces::assembly(design.class, &solids.recipe)?;
    let printed = solids
        .pieces
        .iter()
        .map(|piece| {
            let what = assembly
                .printed
                .iter()
                .find(|(name, _)| *name == piece.name);
            Printed {
                name: &piece.name,
                count: piece.count,
                what: what.map_or(&piece.body, |(_, what)| what),
                size: extent([&piece.mesh]),
                brim: slender(&piece.mesh),
                support: match Overhang::of(&piece.mesh, OVERHANG_DEG).area_mm2 {
                    area if area < 1.0 => "–".into(),
                    area => format!("{:.1}", area / 100.0),
                },
                volume: format!("{:.1}", piece.mesh.volume() / 1000.0),
            }
        })
        .collect();
    let fit = &design.settings.fit;
    template::render(
        "parts.md",
        Page {
            name: &design.name,
            class: design.class.to_string(),
            generator: super::maker(design),
            profile: (fit.profile != Profile::Any).then(|| fit.profile.name()),
            fit,
            printed,
            bought: &assembly.bought,
            steps: &assembly.steps,
        },
    )
}

/// Whether a mesh on z = 0 is tall for the width of its foot.
fn slender(mesh: &Mesh) -> bool {
    let on_bed = mesh.vertices.iter().filter(|v| v[2] < 1.0);
    let foot = on_bed.fold(
        [f64::MAX, f64::MIN, f64::MAX, f64::MIN],
        |[a, b, c, d], v| [a.min(v[0]), b.max(v[0]), c.min(v[1]), d.max(v[1])],
    );
    mesh.bounds().1.z > SLENDER * (foot[1] - foot[0]).min(foot[3] - foot[2])
}
