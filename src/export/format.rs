//! The formats that a design can be rendered in.

use std::path::Path;

use super::{
    File, Source, all_poses, card, freecad, gltf, mjcf, openscad, scad_sets, stations, stl, svg,
    threemf,
};
use crate::design::Design;
use crate::solid::Solids;
use crate::{Error, Problem, Result};

/// A format of `mpcgear export`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Parametric OpenSCAD scripts.
    OpenScad,
    /// The FreeCAD macro.
    FreeCad,
    /// Binary STL of the bodies and of the pieces to print.
    Stl,
    /// All bodies in one 3MF file.
    ThreeMf,
    /// STEP through an installed FreeCAD.
    Step,
    /// Drawings of plates and hubs.
    Svg,
    /// A page with picture and figures.
    Card,
    /// The contact stations in all frames.
    Curves,
    /// The gears as a MuJoCo model.
    Mjcf,
    /// The bodies in motion, for viewers and the web.
    Gltf,
    /// Poses of both gears over a whole cycle.
    Poses,
}

impl Format {
    /// All formats, in the order of the list.
    pub const ALL: [Format; 11] = [
        Format::OpenScad,
        Format::FreeCad,
        Format::Stl,
        Format::ThreeMf,
        Format::Step,
        Format::Svg,
        Format::Card,
        Format::Curves,
        Format::Mjcf,
        Format::Gltf,
        Format::Poses,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Format::OpenScad => "openscad",
            Format::FreeCad => "freecad",
            Format::Stl => "stl",
            Format::ThreeMf => "3mf",
            Format::Step => "step",
            Format::Svg => "svg",
            Format::Card => "card",
            Format::Curves => "curves",
            Format::Mjcf => "mjcf",
            Format::Gltf => "gltf",
            Format::Poses => "poses",
        }
    }

    /// One line about it.
    pub fn description(self) -> &'static str {
        match self {
            Format::OpenScad => {
                "parametric scripts with Customizer, and the animated assembly (.scad)"
            }
            Format::FreeCad => "macro that builds a parametric document (.FCMacro)",
            Format::Stl => "bodies in place and pieces to print, binary, mm (.stl)",
            Format::ThreeMf => "all bodies in one file, named and coloured, mm (.3mf)",
            Format::Step => {
                "one named solid per body, mm, and the document, through an installed FreeCAD (.step, .FCStd)"
            }
            Format::Svg => "drawings of hubs and plates in true size, mm (.svg)",
            Format::Card => "picture, figures and pieces on one page (.md, .png)",
            Format::Curves => "contact points, normals and tangents in all frames (.csv)",
            Format::Mjcf => {
                "MuJoCo model that moves by its contacts, with motor and payload; m, kg, s (.xml)"
            }
            Format::Gltf => "coloured bodies that move through a whole cycle, m (.glb)",
            Format::Poses => "poses of driver and follower over a whole cycle, mm (.csv)",
        }
    }

    /// The formats of a list of names.
    ///
    /// # Errors
    /// [`Error::Input`] with every unknown name and what it may have meant.
    pub fn parse(names: &[String]) -> Result<Vec<Format>> {
        let find = |name: &str| Format::ALL.into_iter().find(|f| f.name() == name);
        let unknown = names.iter().filter(|name| find(name).is_none());
        let problems: Vec<Problem> = unknown
            .map(|name| Problem {
                place: "--to".into(),
                what: format!("`{name}` is not a format ({})", all_names()),
                hint: closest(name, &Format::ALL.map(Format::name))
                    .map(|format| format!("did you mean `{format}`?"))
                    .unwrap_or_default(),
            })
            .collect();
        if problems.is_empty() {
            let named = |format: &Format| names.iter().any(|name| name == format.name());
            Ok(Format::ALL.into_iter().filter(named).collect())
        } else {
            Err(Error::Input {
                file: "command line".into(),
                problems: Vec::into(problems),
            })
        }
    }
}

fn all_names() -> String {
    Format::ALL.map(Format::name).join(", ")
}

/// The one of `names` that `word` is a misspelling of, if any.
fn closest<'a>(word: &str, names: &[&'a str]) -> Option<&'a str> {
    let distance = |name: &&str| strsim::damerau_levenshtein(&word.to_lowercase(), name);
    let best = names.iter().copied().min_by_key(distance)?;
    (distance(&best) <= 2).then_some(best)
}

/// The files of a design in `format`; `part` restricts them to one body.
///
/// # Errors
/// [`Error::Input`] for a body that the design does not have or a format that cannot be had for
/// one body, [`Error::Internal`] when a template, an encoder or FreeCAD fails.
pub fn render(source: &Source, format: Format, part: Option<&str>) -> Result<Vec<File>> {
    let Some(solids) = source.solids else {
        return Err(Error::Internal("the design has no solids".into()));
    };
    let names: Vec<&str> = solids.bodies.iter().map(|b| b.name.as_str()).collect();
    if let Some(part) = part
        && !names.contains(&part)
    {
        let what = format!(
            "`{part}` is not a body of this design ({})",
            names.join(", ")
        );
        let hint = closest(part, &names).map(|name| format!("did you mean `{name}`?"));
        return Err(refused("--part", what, hint.unwrap_or_default()));
    }
    let wanted = |body: &str| part.is_none_or(|part| part == body);
    match format {
        Format::OpenScad => openscad::scripts(source, &solids.recipe)?
            .into_iter()
            .filter(|s| part.is_none_or(|part| s.name == format!("{part}.scad")))
            .map(|s| Ok(File::new(s.name, s.text)))
            .chain(part.is_none().then(|| scad_sets::file(&solids.recipe)))
            .collect(),
        Format::Stl => {
            let mut files = Vec::new();
            for body in solids.bodies.iter().filter(|b| wanted(&b.name)) {
                files.push(File::new(
                    format!("{}.stl", body.name),
                    stl::binary(&source.placed(body))?,
                ));
            }
            for piece in solids.pieces.iter().filter(|p| wanted(&p.body)) {
                files.push(File::new(
                    format!("print/{}.stl", piece.name),
                    stl::binary(&piece.mesh)?,
                ));
            }
            Ok(files)
        }
        Format::Svg => svg::drawings(source, solids, part),
        Format::ThreeMf => Ok(vec![File::new(
            format!("{}.3mf", part.unwrap_or("assembly")),
            threemf::assembly(source, solids, part)?,
        )]),
        Format::FreeCad => {
            let date = super::date::from_environment().unwrap_or_default();
            let design = one_part(source.with_recipe(solids), part);
            Ok(vec![File::new(
                format!("{}.FCMacro", freecad::stem(&design)),
                freecad::macro_text(&design, &date)?,
            )])
        }
        Format::Card => card::files(source, solids),
        Format::Curves => Ok(vec![File::new("curves.csv", stations::csv(source.design)?)]),
        Format::Mjcf if part.is_some() => Err(refused(
            "--part",
            "a MuJoCo model (mjcf) has both gears".into(),
            "leave `--part` out".into(),
        )),
        Format::Mjcf => Ok(vec![mjcf::file(source, solids)?]),
        Format::Gltf => Ok(vec![gltf::file(source, solids, part)?]),
        Format::Poses => Ok(vec![File::new("all_poses.csv", all_poses::csv(source)?)]),
        Format::Step => step(&one_part(source.with_recipe(solids), part), solids),
    }
}

/// The design with one body only, if one is wanted, and named after it.
fn one_part(mut design: Design, part: Option<&str>) -> Design {
    if let Some(part) = part {
        design.recipe.bodies.retain(|body| body.name == part);
        design.name = format!("{} {part}", design.name);
    }
    design
}

/// Largest difference between the volumes that FreeCAD and the embedded kernel make of a body, share.
const SAME_VOLUME: f64 = 0.005;

fn step(design: &Design, solids: &Solids) -> Result<Vec<File>> {
    let folder = tempfile::tempdir().map_err(Error::io(std::env::temp_dir()))?;
    let date = super::date::from_environment().unwrap_or_default();
    let headless = freecad::Headless {
        program: "freecadcmd".as_ref(),
        folder: folder.path(),
        thorough: false,
    };
    let built = freecad::run(design, &date, &headless)?;
    for (name, volume) in &built.volumes {
        let body = solids.bodies.iter().find(|body| body.name == *name);
        let mesh = body.map_or(f64::NAN, |body| body.mesh.volume());
        if !((volume / mesh - 1.0).abs() < SAME_VOLUME) {
            return Err(Error::Internal(format!(
                "FreeCAD makes {volume:.1} mm³ of the {name}, which has {mesh:.1} mm³ as a mesh"
            )));
        }
    }
    let file = |path: &Path, extension: &str| {
        let bytes = std::fs::read(path).map_err(Error::io(path))?;
        let name = format!("{}.{extension}", freecad::stem(design));
        Ok(File::new(name, bytes))
    };
    Ok(vec![
        file(&built.step, "step")?,
        file(&built.document, "FCStd")?,
    ])
}

fn refused(place: &str, what: String, hint: String) -> Error {
    Error::Input {
        file: "command line".into(),
        problems: vec![Problem {
            place: place.into(),
            what,
            hint,
        }]
        .into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_formats_are_all_named_with_suggestions() {
        let names = ["openscad", "setp", "dwg"].map(String::from);
        let error = Format::parse(&names).expect_err("two unknown").to_string();
        assert!(error.contains("`setp`") && error.contains("did you mean `step`?"));
        assert!(error.contains("`dwg`"));
    }

    #[test]
    fn every_format_is_found_by_its_name() {
        let names = Format::ALL.map(|f| f.name().to_string());
        assert_eq!(Format::parse(&names).expect("all known"), Format::ALL);
    }
}
