//! `mpcgear design`: the main job.

use std::path::{Path, PathBuf};

use mpcgear::design::{Design, file};
use mpcgear::disk::Folder;
use mpcgear::export::tables::{self, Summary};
use mpcgear::export::{self, Source};
use mpcgear::motion::{Motion, MotionFile};
use mpcgear::pipeline::{self, Outcome};
use mpcgear::search::StopReason;
use mpcgear::settings::Method;
use mpcgear::{Error, Result};

use super::{json, print_out, say};
use crate::cli::{self, Cli, DesignArgs};
use crate::terminal::Watch;

/// Designs, proves and writes; exit code 0, 3 or 130.
///
/// # Errors
/// Bad input and folders that cannot be written, before anything is computed; motions that cannot be
/// made, after their draft is written; an interrupt before there was a design; defects of ours.
pub fn run(cli: &Cli, args: &DesignArgs) -> Result<u8> {
    let (mut file, motion) = MotionFile::read_draft(&args.file)?;
    override_settings(&mut file, args)?;
    let job = Job {
        cli,
        target: Target::claim(&args.out)?,
        watch: Watch::new(cli.quiet || cli.json, file.settings.search.time_limit_s),
    };
    let motion = match motion {
        Ok(motion) => motion,
        Err(error) => return job.give_up(&file, None, error),
    };
    let outcome = pipeline::run(&file, &motion, &mut |progress| job.watch.tell(progress));
    job.watch.finish();
    match outcome {
        Ok(outcome) => job.deliver(&args.file, &motion, &outcome),
        Err(Error::Interrupted) if !job.watch.interrupted() => {
            job.give_up(&file, Some(&motion), out_of_time(&file))
        }
        Err(error) => job.give_up(&file, Some(&motion), error),
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
    let problems = file.settings.problems(file.class);
    if problems.is_empty() {
        Ok(())
    } else {
        Err(Error::Input {
            file: "command line".into(),
            problems: problems.into(),
        })
    }
}

/// One run: who asked, where the result goes, how long it takes.
struct Job<'a> {
    cli: &'a Cli,
    target: Target,
    watch: Watch,
}

impl Job<'_> {
    /// Writes what was found and tells of it; `asked` is the motion file.
    fn deliver(&self, asked: &Path, motion: &Motion, outcome: &Outcome) -> Result<u8> {
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
        summary.stopped = outcome.stop == StopReason::Stopped;
        summary.wall_seconds = self.watch.seconds();
        let source = Source {
            design,
            motion,
            solids: Some(&outcome.solids),
        };
        let mut files = export::files(&source, &summary)?;
        let paths: Vec<PathBuf> = files.iter().map(|f| f.path.clone()).collect();
        let claims = outcome.check.as_ref().map_or(&[][..], |c| &c.claims);
        let text = std::fs::read_to_string(asked).unwrap_or_default();
        files.push(super::report::page(&source, claims, (&paths, &text))?);
        let works = design.problems.is_empty();
        let folder = self.target.folder(works);
        folder.publish(&files)?;
        show(self.cli, &summary, folder.path())?;
        Ok(match (self.watch.interrupted(), works) {
            (true, _) => 130,
            (false, true) => 0,
            (false, false) => 3,
        })
    }

    /// Writes the draft of a motion that cannot be made and hands the error on; other errors leave nothing.
    fn give_up(&self, file: &MotionFile, motion: Option<&Motion>, error: Error) -> Result<u8> {
        if let Error::Infeasible {
            reason,
            place,
            hint,
        } = &error
        {
            let mut draft = Design::draft(file);
            draft.problems = vec![format!("{reason} ({place}); {hint}")];
            let mut summary = Summary::of(&draft);
            summary.wall_seconds = self.watch.seconds();
            let files = match motion {
                Some(motion) => export::files(
                    &Source {
                        design: &draft,
                        motion,
                        solids: None,
                    },
                    &summary,
                )?,
                None => vec![
                    export::File::new("design.json", file::text(&draft)?),
                    export::File::new("summary.json", tables::summary_json(&summary)?),
                ],
            };
            let folder = self.target.folder(false);
            folder.publish(&files)?;
            show(self.cli, &summary, folder.path())?;
        }
        Err(error)
    }
}

fn out_of_time(file: &MotionFile) -> Error {
    Error::Infeasible {
        reason: "the time limit ended the search before there was any design".into(),
        place: format!("{} s of search", file.settings.search.time_limit_s),
        hint: "allow more time (--max-time, search.time_limit_s)".into(),
    }
}

/// Where the result goes: a draft does not replace an existing design, it goes beside it.
struct Target {
    out: Folder,
    draft: Option<Folder>,
}

impl Target {
    /// Takes the folders, before any long work.
    fn claim(path: &Path) -> Result<Target> {
        let out = Folder::claim(path)?;
        let draft = match out.has_design() {
            true => Some(Folder::claim(&beside(path)?)?),
            false => None,
        };
        Ok(Target { out, draft })
    }

    fn folder(&self, works: bool) -> &Folder {
        match &self.draft {
            Some(draft) if !works => draft,
            _ => &self.out,
        }
    }
}

/// The folder for a draft beside `out`.
fn beside(out: &Path) -> Result<PathBuf> {
    // `.` and `..` have no name of their own.
    let whole = if out.file_name().is_some() {
        out.to_path_buf()
    } else {
        out.canonicalize().map_err(Error::io(out))?
    };
    let mut name = whole.file_name().unwrap_or_default().to_os_string();
    name.push(".draft");
    Ok(whole.with_file_name(name))
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
    if summary.stopped {
        text += "stopped early: the best so far; more time may give a better design\n";
    }
    text += &format!("written: {}", written.display());
    say(cli, &text).map(|_| ())
}
