//! The card of a design: picture, figures and pieces on a small Markdown page.

use serde::Serialize;

use super::parts::extent;
use super::picture::{self, View};
use super::scad_teeth::number;
use super::tables::Summary;
use super::{File, Source, template};
use crate::Result;
use crate::solid::Solids;
use crate::solid::assembly::SolidBody;

#[derive(Serialize)]
struct Piece<'a> {
    name: &'a str,
    size: String,
    volume: String,
}

#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    picture: String,
    words: String,
    class: String,
    k: usize,
    j: usize,
    q_min: String,
    eta_min: String,
    size: String,
    pieces: Vec<Piece<'a>>,
}

/// `NAME.md` and its picture `NAME.png`.
///
/// # Errors
/// [`crate::Error::Internal`] when the template or the picture fails.
pub fn files(source: &Source, solids: &Solids) -> Result<Vec<File>> {
    let design = source.design;
    let summary = Summary::of(design);
    let stem: String = design
        .name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    let bodies: Vec<SolidBody> = solids
        .bodies
        .iter()
        .map(|body| SolidBody {
            mesh: source.placed(body),
            ..body.clone()
        })
        .collect();
    let view = View {
        width: 800,
        height: 600,
        ..View::default()
    };
    let figure = |value: Option<f64>| value.map_or("not known".into(), |v| number(v, 3));
    let page = Page {
        name: &design.name,
        picture: format!("{stem}.png"),
        words: match design.problems.as_slice() {
            [] => "The proof over the whole turn found no fault.".into(),
            problems => format!("A draft that does not work yet: {}.", problems.join("; ")),
        },
        class: design.class.to_string(),
        k: summary.k,
        j: summary.j,
        q_min: figure(summary.q_min),
        eta_min: figure(summary.eta_min),
        size: extent(bodies.iter().map(|b| &b.mesh)),
        pieces: solids
            .pieces
            .iter()
            .map(|p| Piece {
                name: &p.name,
                size: extent([&p.mesh]),
                volume: number(p.mesh.volume() / 1000.0, 1),
            })
            .collect(),
    };
    let png = picture::mechanism(&bodies, view)?;
    Ok(vec![
        File::new(format!("{stem}.md"), template::render("card.md", page)?),
        File::new(format!("{stem}.png"), png),
    ])
}
