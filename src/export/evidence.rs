//! What the report shows, gathered from a design, its solids, its proof and its files.

use super::report::{Claim, FileLink, ReportInput};
use super::{File, Source};
use crate::load::sensitivity::{Sensitivity, sensitivity};
use crate::load::{LoadReport, Sampling, analyse};
use crate::solid::assembly::SolidBody;
use crate::verify::Proof;
use crate::{Error, Result};

/// Angles at which assembly errors are tried; each takes a hundred small programs.
const ERROR_ANGLES: usize = 60;

/// Everything that belongs into a report beside the design itself.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Bodies at φ = 0 in Σ.
    pub bodies: Vec<SolidBody>,
    /// Load figures; `None` where the contacts cannot hold the load.
    pub load: Option<LoadReport>,
    /// Effect of assembly errors; `None` as above.
    pub sensitivity: Option<Sensitivity>,
    /// Verdicts.
    pub claims: Vec<Claim>,
    /// Files beside the report.
    pub files: Vec<FileLink>,
}

impl Evidence {
    /// Gathers the evidence for `source`, beside which `files` are written. Designs that do not
    /// close lack load figures instead of failing: their report says why they are drafts.
    ///
    /// # Errors
    /// [`Error::Input`] for impossible `[load]` settings.
    pub fn gather(source: &Source, claims: Vec<Claim>, files: &[File]) -> Result<Evidence> {
        let (design, motion) = (source.design, source.motion);
        let settings = &design.settings.load;
        let l = design.settings.gear.center_distance_mm;
        let place = |body: &SolidBody| SolidBody {
            mesh: body.mesh.moved(&body.carrier.pose(motion, l, 0.0)),
            ..body.clone()
        };
        let few = Sampling {
            count: ERROR_ANGLES,
            ..Sampling::default()
        };
        Ok(Evidence {
            bodies: source
                .solids
                .map_or(Vec::new(), |s| s.bodies.iter().map(place).collect()),
            load: where_closed(analyse(design, motion, settings, Sampling::default()))?,
            sensitivity: where_closed(sensitivity(design, motion, settings, few))?,
            claims,
            files: files.iter().filter_map(link).collect(),
        })
    }

    /// Input of the report; `motion_file` is shown as the user wrote it and may be empty.
    pub fn input<'a>(&'a self, source: &Source<'a>, motion_file: &'a str) -> ReportInput<'a> {
        ReportInput {
            design: source.design,
            motion: source.motion,
            sampling: Sampling::default(),
            bodies: &self.bodies,
            claims: &self.claims,
            load: self.load.as_ref(),
            sensitivity: self.sensitivity.as_ref(),
            files: &self.files,
            motion_file,
        }
    }
}

/// The result, or nothing where the mechanism is not form closed.
fn where_closed<T>(result: Result<T>) -> Result<Option<T>> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(Error::Infeasible { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Link to a file of the output folder, with what it is for.
fn link(file: &File) -> Option<FileLink> {
    let path = file.path.to_str()?.replace('\\', "/");
    let (group, note) = match path.split('/').next()? {
        "print" => ("Pieces to print", "lies as it is printed"),
        "meshes" if path.ends_with(".3mf") => ("Meshes, assembled", "all parts, named"),
        "meshes" => ("Meshes, assembled", "at φ = 0"),
        "openscad" => ("OpenSCAD", "parametric, open and customise"),
        "freecad" => ("FreeCAD", "parametric, run the macro"),
        "parts.md" => ("Documents", "what to print, buy, and how to assemble"),
        "design.json" => ("Data", "the design, to export again"),
        "summary.json" => ("Data", "figures"),
        "poses.csv" => ("Data", "pose of the follower at every degree"),
        _ => ("Further files", ""),
    };
    Some(FileLink {
        path,
        note: note.into(),
        group: group.into(),
    })
}

/// Verdicts of the proof on the meshes, of the closure samples and of the conjugation `residual`
/// (mm/rad) in plain words. Empty without a proof: not checked.
pub fn claims(source: &Source, proof: Option<&Proof>, residual: f64) -> Vec<Claim> {
    let Some(proof) = proof else {
        return Vec::new();
    };
    let gear = &source.design.settings.gear;
    let degrees = |phi: f64| format!("φ = {:.1}°", phi.to_degrees());
    let mut claims = vec![Claim {
        name: "true contact".into(),
        meaning: "Touching teeth roll and slide on each other without lifting off or digging in."
            .into(),
        figure: format!("{residual:.1e} mm/rad"),
        limit: format!("{:.0e} mm/rad", crate::pipeline::RESIDUAL_LIMIT),
        place: String::new(),
        holds: residual <= crate::pipeline::RESIDUAL_LIMIT,
    }];
    if let Some(worst) = source
        .design
        .closure
        .iter()
        .min_by(|a, b| a.q.total_cmp(&b.q))
    {
        claims.push(Claim {
            name: "held at every moment".into(),
            meaning: "The contacts leave the follower no direction to move in, all the way round."
                .into(),
            figure: format!("Q = {:.3}", worst.q),
            limit: format!("above {}", gear.closure_threshold),
            place: degrees(worst.phi),
            holds: worst.q > gear.closure_threshold,
        });
    }
    for pair in &proof.pairs {
        let [a, b] = &pair.bodies;
        claims.push(Claim {
            name: format!("{a} clear of {b}"),
            meaning: format!("The {a} and the {b} never share space, at no angle of the motor."),
            figure: match pair.overlap_mm3 {
                Some(0.0) => format!("smallest gap {:.3} mm", pair.gap_mm),
                Some(volume) => format!("overlap {volume:.3} mm³"),
                None => "they meet".into(),
            },
            limit: "no overlap".into(),
            place: pair
                .overlap_at
                .or(pair.doubts.first().copied())
                .unwrap_or(pair.gap_at)
                .to_string(),
            holds: pair.holds(),
        });
    }
    claims.push(Claim {
        name: "no escape".into(),
        meaning: "Pushed a little in any direction with the motor held, the follower hits a tooth."
            .into(),
        figure: format!(
            "{} of {} tries escape",
            proof.escapes.len(),
            proof.displacements
        ),
        limit: "0".into(),
        place: proof
            .escapes
            .first()
            .map_or(String::new(), |e| degrees(e.phi)),
        holds: proof.escapes.is_empty() && proof.displacements > 0,
    });
    for (body, wall) in &proof.walls {
        claims.push(Claim {
            name: format!("walls of the {body}"),
            meaning: "Nothing is too thin to be printed.".into(),
            figure: wall.map_or("all thicker".into(), |w| {
                format!("{:.2} mm", w.thickness_mm)
            }),
            limit: format!("{} mm", proof.minimum_wall_mm),
            place: wall.map_or(String::new(), |w| {
                format!("({:.1}, {:.1}, {:.1}) mm", w.at[0], w.at[1], w.at[2])
            }),
            holds: wall.is_none_or(|w| w.thickness_mm >= proof.minimum_wall_mm),
        });
    }
    claims.push(Claim {
        name: "sound meshes".into(),
        meaning: "Every part is one closed solid that a slicer understands.".into(),
        figure: match proof.mesh_problems.len() {
            0 => "no defect".into(),
            n => format!("{n} defects"),
        },
        limit: "none".into(),
        place: proof
            .mesh_problems
            .first()
            .map_or(String::new(), ToString::to_string),
        holds: proof.mesh_problems.is_empty(),
    });
    claims
}
