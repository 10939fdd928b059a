//! `mpcgear design`: the main job.

use std::path::{Path, PathBuf};

use mpcgear::design::{Design, FORMAT, Section};
use mpcgear::export::tables::Summary;
use mpcgear::export::{self, Source, folder};
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::pipeline::{self, Outcome};
use mpcgear::search::StopReason;
use mpcgear::settings::Method;
use mpcgear::solid::recipe::Recipe;
use mpcgear::{Error, Result};

use super::{json, print_out, say};
use crate::cli::{self, Cli, DesignArgs};
use crate::terminal::Watch;

/// Designs, proves and writes; exit code 0, 3 or 130.
///
/// # Errors
/// Bad input and folders that cannot be written, before anything is computed; defects of ours.
pub fn run(cli: &Cli, args: &DesignArgs) -> Result<u8> {
    let (mut file, motion) = MotionFile::read(&args.file)?;
    override_settings(&mut file, args)?;
    folder::check_writable(&args.out)?;
    let watch = Watch::new(cli.quiet || cli.json, file.settings.search.time_limit_s);
    let outcome = pipeline::run(&file, &motion, &mut |progress| watch.tell(progress));
    watch.finish();
    match outcome {
        Ok(outcome) => deliver(cli, args, &motion, &outcome, &watch),
        Err(Error::Infeasible {
            reason,
            place,
            hint,
        }) => {
            let mut draft = draft(&file);
            draft.problems = vec![format!("{reason} ({place}); {hint}")];
            let mut summary = Summary::of(&draft);
            summary.wall_seconds = watch.seconds();
            let source = Source {
                design: &draft,
                motion: &motion,
                solids: None,
            };
            let written = write(&args.out, &export::files(&source, &summary)?, false)?;
            show(cli, &summary, &written)?;
            Err(Error::Infeasible {
                reason,
                place,
                hint,
            })
        }
        Err(error) => Err(error),
    }
}

fn override_settings(file: &mut MotionFile, args: &DesignArgs) -> Result<()> {
    let search = &mut file.settings.search;
    search.seed = args.seed.unwrap_or(search.seed);
    search.effort = args.effort.unwrap_or(search.effort);
    search.time_limit_s = args.max_time.unwrap_or(search.time_limit_s);
    match args.method {
        Some(cli::Method::Exact) => search.method = Method::Exact,
        Some(cli::Method::Paper) => search.method = Method::Paper,
        None => {}
    }
    let method = search.method;
    let mut problems = file.settings.problems(file.class);
    if method == Method::Paper {
        problems.push(mpcgear::Problem {
            place: "search.method".into(),
            what: "\"paper\" cannot be searched with yet, only solved band by band in the library"
                .into(),
            hint: "use \"exact\"".into(),
        });
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(Error::Input {
            file: "command line".into(),
            problems,
        })
    }
}

fn deliver(
    cli: &Cli,
    args: &DesignArgs,
    motion: &Motion,
    outcome: &Outcome,
    watch: &Watch,
) -> Result<u8> {
    let design = &outcome.design;
    let mut summary = Summary::of(design);
    summary.conjugation_residual_max = Some(outcome.residual);
    if let Some(proof) = outcome.check.as_ref().and_then(|c| c.proof.as_ref()) {
        let overlap = proof.overlap_max_mm3();
        summary.overlap_max_mm3 = overlap.is_finite().then_some(overlap);
        summary.escapes = Some(proof.escapes.len());
        let all_thicker = 1.25 * design.settings.gear.minimum_wall_mm;
        summary.wall_min_mm = Some(proof.wall_min_mm().unwrap_or(all_thicker));
    }
    summary.wall_seconds = watch.seconds();
    let source = Source {
        design,
        motion,
        solids: Some(&outcome.solids),
    };
    let mut files = export::files(&source, &summary)?;
    let paths: Vec<PathBuf> = files.iter().map(|f| f.path.clone()).collect();
    let claims = outcome.check.as_ref().map_or(&[][..], |c| &c.claims);
    let text = std::fs::read_to_string(&args.file).unwrap_or_default();
    files.push(super::report::page(&source, claims, (&paths, &text))?);
    let works = design.problems.is_empty();
    let written = write(&args.out, &files, works)?;
    show(cli, &summary, &written)?;
    if outcome.stop == StopReason::Stopped && !watch.interrupted() {
        say(
            cli,
            "the search was cut short by the time limit; more time may give a better design",
        )?;
    }
    Ok(match (watch.interrupted(), works) {
        (true, _) => 130,
        (false, true) => 0,
        (false, false) => 3,
    })
}

/// Writes the files into `out`; a draft does not replace an existing design but goes beside it.
fn write(out: &Path, files: &[export::File], works: bool) -> Result<PathBuf> {
    let mut target = out.to_path_buf();
    if !works && out.join("design.json").exists() {
        let mut name = out.file_name().unwrap_or_default().to_os_string();
        name.push(".draft");
        target.set_file_name(name);
    }
    folder::publish(&target, files)?;
    Ok(target)
}

fn show(cli: &Cli, summary: &Summary, written: &Path) -> Result<()> {
    if cli.json {
        return print_out(&json(summary)?);
    }
    let figure = |value: Option<f64>| value.map_or("–".into(), |v| format!("{v:.3}"));
    let state = if summary.feasible {
        "works"
    } else {
        "draft, does not work"
    };
    let mut text = format!(
        "{} ({}): {state}. K = {}, min Q {}, η {}, overlap {} mm³, escapes {}, thinnest wall {} mm, {:.1} s\n",
        summary.name,
        summary.class,
        summary.k,
        figure(summary.q_min),
        figure(summary.eta_min),
        figure(summary.overlap_max_mm3),
        summary.escapes.map_or("–".into(), |n| n.to_string()),
        figure(summary.wall_min_mm),
        summary.wall_seconds,
    );
    for problem in &summary.problems {
        text += &format!("  - {problem}\n");
    }
    text += &format!("written: {}", written.display());
    say(cli, &text).map(|_| ())
}

/// A design without teeth, for the folder of a motion that cannot be made.
fn draft(file: &MotionFile) -> Design {
    let gear = &file.settings.gear;
    Design {
        format: FORMAT,
        generator: env!("CARGO_PKG_VERSION").into(),
        name: file.name.clone(),
        class: file.class,
        settings: file.settings.clone(),
        motion: file.source.clone(),
        sub_gear_pairs: Vec::new(),
        section: Section {
            thickness: gear.tooth_thickness_mm,
            flank_radius: gear.flank_radius_mm,
            tip: gear.tip_mm,
            root: gear.root_mm,
            clearance: file.settings.fit.clearance_mm,
            rib: file.settings.spokes.thickness_mm,
        },
        recipe: Recipe::default(),
        closure: Vec::new(),
        problems: Vec::new(),
    }
}
