//! `parts.md`: what to print, what to buy, how to assemble.

use nalgebra::Vector3;
use serde::Serialize;

use super::template;
use crate::Result;
use crate::design::Design;
use crate::solid::{Mesh, Solids, pieces};

#[derive(Serialize)]
struct Printed<'a> {
    name: &'a str,
    count: u32,
    what: &'a str,
    size: String,
    volume: String,
}

#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    class: String,
    generator: String,
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
                volume: format!("{:.1}", piece.mesh.volume() / 1000.0),
            }
        })
        .collect();
    template::render(
        "parts.md",
        Page {
            name: &design.name,
            class: design.class.to_string(),
            generator: super::maker(design),
            printed,
            bought: &assembly.bought,
            steps: &assembly.steps,
        },
    )
}
