//! `mpcgear check`: every claim of a design, tried on its file and meshes.

use std::path::{Path, PathBuf};

use mpcgear::design::{Design, Gear, Stored};
use mpcgear::export::{Source, stl};
use mpcgear::motion::Motion;
use mpcgear::solid::Mesh;
use mpcgear::solid::assembly::{Carrier, SolidBody, Solids};
use mpcgear::solid::kernel::Solid;
use mpcgear::solid::slivers;
use mpcgear::verify::{Check, CheckInput, Claim, Effort, Mechanism, Printer, check};
use mpcgear::{Error, Problem, Result};
use serde::Serialize;

use super::{json, print_out, say};
use crate::cli::{CheckArgs, Cli, MeshArgs};
use crate::terminal::{Watch, warn};

/// Gears smaller or larger than their teeth by this factor are in another unit: shafts and hubs make a
/// gear up to twice as large as its teeth, the nearest other unit (cm) differs by ten.
const MISFIT: f64 = 4.0;

/// Corners in ASCII STL files have six digits: between 10 and 100 mm, steps of this size, mm. Triangles
/// that are smaller may be flat, or cross their neighbours, and nobody will ever see it.
const FILE_PRECISION: f64 = 1e-4;

/// Meshes of more triangles in all take minutes; our own designs have some two hundred thousand.
const MANY_TRIANGLES: usize = 600_000;

/// What is checked, and where it came from.
struct Given {
    bodies: Vec<SolidBody>,
    pieces: Vec<(String, Mesh)>,
    origins: Vec<Origin>,
}

/// Where the mesh of a body came from.
#[derive(Debug, Serialize)]
struct Origin {
    body: &'static str,
    /// File, or why there is none.
    from: String,
}

/// The answer with `--json`.
#[derive(Serialize)]
struct Answer<'a> {
    design: &'a str,
    holds: bool,
    meshes: &'a [Origin],
    #[serde(flatten)]
    check: &'a Check,
}

/// Checks a design: exit code 0 when every claim holds, 1 when not.
///
/// # Errors
/// Designs and meshes that cannot be read; interruption.
pub fn run(cli: &Cli, args: &CheckArgs) -> Result<u8> {
    let (design, motion, file) = Stored::read(&args.design)?.with_motion()?;
    let given = given((&design, &motion), &file, &args.meshes)?;
    let triangles: usize = given.bodies.iter().map(|b| b.mesh.triangles.len()).sum();
    if triangles > MANY_TRIANGLES && !cli.quiet {
        warn(&format!(
            "{triangles} triangles take long to check; meshes of a tenth of that show the same"
        ));
    }
    let mut printer = Printer {
        volume_mm: args.printer,
        ..Printer::of(&design.settings.fit)
    };
    if let Some(tolerance) = args.tolerance {
        printer.tolerance_mm = tolerance;
    }
    let (found, seconds) = judge(
        cli,
        (&design, &motion),
        &given,
        (printer, Effort::scaled(args.effort)),
    )?;
    if cli.json {
        print_out(&json(&Answer {
            design: &design.name,
            holds: found.holds(),
            meshes: &given.origins,
            check: &found,
        })?)?;
    } else {
        for origin in &given.origins {
            say(cli, &format!("{:9} {}", origin.body, origin.from))?;
        }
        say(cli, &table(&found.claims))?;
        say(cli, &verdict(&found, seconds))?;
    }
    Ok(u8::from(!found.holds()))
}

/// The check of the design in `file` with the meshes beside it, for its report.
///
/// # Errors
/// As [`run`].
pub fn of(cli: &Cli, source: &Source, file: &Path) -> Result<Check> {
    let (design, motion) = (source.design, source.motion);
    let given = given((design, motion), file, &MeshArgs::default())?;
    Ok(judge(
        cli,
        (design, motion),
        &given,
        (Printer::of(&design.settings.fit), Effort::default()),
    )?
    .0)
}

/// The check, watched, and how many seconds it took.
fn judge(
    cli: &Cli,
    (design, motion): (&Design, &Motion),
    given: &Given,
    (printer, effort): (Printer, Effort),
) -> Result<(Check, f64)> {
    let watch = Watch::new(cli.quiet || cli.json);
    let input = CheckInput {
        design,
        motion,
        bodies: &given.bodies,
        pieces: &given.pieces,
        printer,
        effort,
    };
    let found = check(&input, &mut |what, done| watch.step(what, done));
    watch.finish();
    Ok((found?, watch.seconds()))
}

/// Every body: from the file given for it, else from the folder of the design, else built.
fn given((design, motion): (&Design, &Motion), file: &Path, args: &MeshArgs) -> Result<Given> {
    let folder = file.parent().unwrap_or(Path::new("."));
    let mechanism = Mechanism {
        motion,
        drive: design.settings.gear.drive(),
    };
    let mut names = vec![
        ("driver", Carrier::Driver, &args.driver),
        ("follower", Carrier::Follower, &args.follower),
        ("support", Carrier::Support, &args.support),
    ];
    if args.slider.is_some() || design.class == mpcgear::motion::Class::R3T1 {
        names.push(("slider", Carrier::Slider, &args.slider));
    }
    // Built at most once, and only where a file is missing.
    let mut built: Option<Result<Solids>> = None;
    let mut given = Given {
        bodies: Vec::new(),
        pieces: Vec::new(),
        origins: Vec::new(),
    };
    for (name, carrier, path) in names {
        let beside = folder.join("meshes").join(format!("{name}.stl"));
        let foreign = path.is_some();
        let path = path.clone().or_else(|| beside.is_file().then_some(beside));
        let from = match path {
            Some(path) => {
                let mut mesh = stl::read(&path)?;
                // A mesh that is no solid stays as it is, for the check to say so.
                if foreign && let Ok(solid) = Solid::new(&mesh, name) {
                    mesh = solid.smoothed(FILE_PRECISION).mesh();
                    slivers::remove(&mut mesh);
                }
                let body = mechanism.assembled(SolidBody {
                    name: name.into(),
                    carrier,
                    mesh,
                });
                in_millimetres(design, &body, &path)?;
                given.bodies.push(body);
                path.display().to_string()
            }
            None => match built.get_or_insert_with(|| Solids::build(design, motion)) {
                Ok(solids) => {
                    given
                        .bodies
                        .extend(solids.bodies.iter().filter(|b| b.name == name).cloned());
                    "built from the design".into()
                }
                Err(error) => format!("missing: {error}"),
            },
        };
        given.origins.push(Origin { body: name, from });
    }
    for path in stl_files(&folder.join("print")) {
        let name = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        given.pieces.push((name, stl::read(&path)?));
    }
    if given.pieces.is_empty()
        && let Ok(solids) = built.unwrap_or_else(|| Solids::build(design, motion))
    {
        let pieces = solids.pieces.into_iter();
        given.pieces = pieces.map(|p| (p.name, p.mesh)).collect();
    }
    unchanged(design, file)?;
    Ok(given)
}

/// Another run may exchange the whole folder between the first file that is read here and the last.
fn unchanged(design: &Design, file: &Path) -> Result<()> {
    if Stored::read(file)?.with_motion()?.0 == *design {
        return Ok(());
    }
    let what = "was replaced by another run while its folder was read";
    let hint = "try again when that run is done";
    Err(Error::input(
        file,
        vec![Problem::new("design.json", what, hint)],
    ))
}

/// A gear much smaller or larger than its own teeth was written in another unit.
fn in_millimetres(design: &Design, body: &SolidBody, path: &Path) -> Result<()> {
    let gear = match body.carrier {
        Carrier::Driver => Gear::Driver,
        Carrier::Follower => Gear::Follower,
        Carrier::Support | Carrier::Slider => return Ok(()),
    };
    let teeth = design.sub_gear_pairs.iter().flat_map(|pair| &pair.teeth);
    let contacts = Mesh {
        vertices: teeth
            .flat_map(|tooth| &tooth.stations)
            .map(|s| s.frame(gear).0.into())
            .collect(),
        triangles: Vec::new(),
    };
    let size = |mesh: &Mesh| {
        let (lo, hi) = mesh.bounds();
        (hi - lo).norm()
    };
    let (wanted, found) = (size(&contacts), size(&body.mesh));
    if wanted == 0.0 || (found > wanted / MISFIT && found < wanted * MISFIT) {
        return Ok(());
    }
    let what =
        format!("is {found:.3} across, but the teeth of the design are {wanted:.1} mm across");
    let hint = "export the part in millimetres; this looks like another unit or another part";
    Err(Error::input(path, vec![Problem::new("STL", what, hint)]))
}

/// The STL files of a folder by name; none where there is no folder.
fn stl_files(folder: &Path) -> Vec<PathBuf> {
    let items = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = items
        .map(|item| item.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("stl"))
        })
        .collect();
    files.sort();
    files
}

/// The claims in columns.
fn table(claims: &[Claim]) -> String {
    let head = ["claim", "found", "wanted", "worst at"].map(String::from);
    let rows: Vec<[String; 4]> = claims
        .iter()
        .map(|c| [&c.name, &c.figure, &c.limit, &c.place].map(Clone::clone))
        .collect();
    let width = |i: usize| {
        let cells = rows.iter().chain([&head]).map(|r| r[i].chars().count());
        // A long sentence in one row is no reason to push all others apart.
        cells.filter(|&n| n <= 48).max().unwrap_or(0)
    };
    let widths = [0, 1, 2].map(width);
    let line = |mark: &str, row: &[String; 4]| {
        let cells: Vec<String> = row
            .iter()
            .zip(widths)
            .map(|(cell, w)| format!("{cell:<w$}"))
            .collect();
        format!("{mark} {}  {}", cells.join("  "), row[3])
            .trim_end()
            .to_owned()
            + "\n"
    };
    let mut text = line("     ", &head);
    for (claim, row) in claims.iter().zip(&rows) {
        text += &line(if claim.holds { "holds" } else { "FAILS" }, row);
    }
    text
}

fn verdict(check: &Check, seconds: f64) -> String {
    let all = check.claims.len();
    let failed: Vec<&Claim> = check.claims.iter().filter(|c| !c.holds).collect();
    let mut text = match failed.len() {
        0 => format!("all {all} claims hold, {seconds:.1} s"),
        n => format!("{n} of {all} claims fail, {seconds:.1} s"),
    };
    for failure in &check.failures {
        text += &format!("\n  {} ({})", failure.failure, failure.place);
    }
    text
}
