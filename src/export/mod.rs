//! From a design and its solids to files: meshes, scripts, tables, the parts list.
//!
//! Everything is rendered in memory first ([`files`]), then written at once ([`crate::disk::Folder`]),
//! so that files appear whole or not at all.

mod all_poses;
mod card;
pub mod chart;
mod compact;
pub mod compare;
pub mod curves;
pub mod date;
pub mod evidence;
pub mod figures;
pub mod fitted;
pub mod format;
pub mod freecad;
mod gltf;
pub mod mjcf;
pub mod motion_figures;
pub mod openscad;
pub mod parts;
pub mod picture;
pub mod reference;
pub mod report;
mod scad_bed;
mod scad_csg;
mod scad_customizer;
mod scad_options;
pub mod scad_parameters;
mod scad_part;
mod scad_sets;
mod scad_teeth;
mod stations;
pub mod stl;
pub mod svg;
pub mod tables;
mod template;
pub mod threemf;

use std::path::{Path, PathBuf};

use crate::Result;
use crate::design::{Design, file};
use crate::motion::{Motion, Pose};
use crate::solid::assembly::SolidBody;
use crate::solid::{Mesh, Solids};
use tables::{SUMMARY, Summary};

/// Everything that files are made from.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The design, with its recipe.
    pub design: &'a Design,
    /// Evaluator of `design.motion`.
    pub motion: &'a Motion,
    /// The built bodies and pieces; `None` for a draft that could not be built.
    pub solids: Option<&'a Solids>,
}

impl Source<'_> {
    /// A body's mesh in Σ at φ = 0, mm.
    pub fn placed(&self, body: &SolidBody) -> Mesh {
        body.mesh.moved(&self.pose(body))
    }

    /// Pose in Σ at φ = 0 of a body.
    pub fn pose(&self, body: &SolidBody) -> Pose {
        let drive = self.design.settings.gear.drive();
        body.carrier.pose(self.motion, drive, 0.0)
    }

    /// The design with the recipe that its solids were built from.
    pub fn with_recipe(&self, solids: &Solids) -> Design {
        Design {
            recipe: solids.recipe.clone(),
            ..self.design.clone()
        }
    }
}

/// The program that made a design, with its version.
fn maker(design: &Design) -> String {
    format!("mpcgear {}", design.generator)
}

/// One file of an output folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Path below the folder.
    pub path: PathBuf,
    /// Contents.
    pub bytes: Vec<u8>,
}

impl File {
    /// A file from anything that turns into bytes.
    pub fn new(path: impl Into<PathBuf>, bytes: impl Into<Vec<u8>>) -> File {
        File {
            path: path.into(),
            bytes: bytes.into(),
        }
    }
}

/// All files of the output folder that `mpcgear design` writes. Without solids (an infeasible
/// draft) only `design.json`, `summary.json` and `poses.csv` are made.
///
/// # Errors
/// [`crate::Error::Internal`] when a template or an encoder fails.
pub fn files(source: &Source, summary: &Summary) -> Result<Vec<File>> {
    let mut files = vec![
        File::new("design.json", file::text(source.design)?),
        File::new(SUMMARY, tables::summary_json(summary)?),
        File::new("poses.csv", tables::poses_csv(source.motion)?),
    ];
    let Some(solids) = source.solids else {
        return Ok(files);
    };
    for body in &solids.bodies {
        files.push(File::new(
            format!("meshes/{}.stl", body.name),
            stl::binary(&source.placed(body))?,
        ));
    }
    files.push(File::new(
        "meshes/assembly.3mf",
        threemf::assembly(source, solids, None)?,
    ));
    for piece in &solids.pieces {
        files.push(File::new(
            format!("print/{}.stl", piece.name),
            stl::binary(&piece.mesh)?,
        ));
    }
    for script in openscad::scripts(source, &solids.recipe)? {
        files.push(File::new(format!("openscad/{}", script.name), script.text));
    }
    let sets = scad_sets::file(&solids.recipe)?;
    files.push(File::new(Path::new("openscad").join(sets.path), sets.bytes));
    files.push(File::new(
        "parts.md",
        parts::markdown(source.design, solids)?,
    ));
    Ok(files)
}
