//! Arguments of the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use mpcgear::load::Material;
use mpcgear::motion::Change;
use mpcgear::motion::fit::Tolerance;

/// Designs multi-point conjugation gears: one motor, one gear pair, any periodic 3D motion.
#[derive(Debug, Parser)]
#[command(
    version,
    about,
    after_help = "Exit codes: 0 all well, 1 a check failed, 2 bad input, 3 infeasible motion (draft written), 130 interrupted."
)]
pub struct Cli {
    /// Say nothing but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Results as JSON on standard output, errors as JSON on standard error.
    #[arg(long, global = true)]
    pub json: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Design the mechanism of a motion file, prove it and write everything.
    Design(DesignArgs),
    /// Write a commented starter motion file, or one of the examples.
    #[command(group = clap::ArgGroup::new("kind").required(true))]
    New {
        /// Class of the follower-support joint: 1R, 1R1T, 3R or 3R1T.
        #[arg(long, value_parser = parse_class, group = "kind")]
        class: Option<mpcgear::motion::Class>,
        /// Example to begin with instead.
        #[arg(long, value_parser = mpcgear::motion::examples::names(), group = "kind")]
        example: Option<String>,
        /// File to write; an existing file is left alone.
        file: PathBuf,
    },
    /// Render a design again in chosen formats.
    Export(ExportArgs),
    /// From a requirement to a shortlist: many designs, the best of them proved.
    Explore(ExploreArgs),
    /// One design of an exploration, into a folder named by what it is made from; skipped when it is there.
    Trial(TrialArgs),
    /// Prove a design again, from its file and meshes alone.
    Check(CheckArgs),
    /// Forces, torque, payload, stress, play and sensitivity of a design.
    Load {
        /// `design.json` or the folder with it.
        design: PathBuf,
        /// Payload instead of the motion file's: 800g, 0.8kg.
        #[arg(long, value_parser = parse_mass)]
        payload: Option<f64>,
        /// Print the table over the driver angle as CSV instead.
        #[arg(long, conflicts_with = "json")]
        csv: bool,
        /// Make so many gears at random within the tolerances instead: what share works, how play and hold
        /// spread.
        #[arg(long, value_name = "DRAWS", conflicts_with = "csv",
              value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        tolerances: Option<u32>,
        /// Seed of these draws.
        #[arg(long, default_value = "1", requires = "tolerances")]
        seed: u64,
    },
    /// The smallest gear that carries a payload.
    Size(SizeArgs),
    /// Write the report of a design again.
    Report {
        /// Output folder of `mpcgear design`.
        folder: PathBuf,
        /// Pictures (PNG) of the mechanism and of every plot into this folder, without a browser.
        #[arg(long)]
        png: Option<PathBuf>,
    },
    /// Several designs side by side, in one page.
    Compare {
        /// Output folders or `design.json` files.
        #[arg(required = true)]
        designs: Vec<PathBuf>,
        /// Page to write [default: compare.html], or folder with --with [default: involute].
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// One design that turns at a constant ratio beside a standard pair of spur gears instead: table and
        /// meshes of that pair in a folder.
        #[arg(long, value_enum)]
        with: Option<Standard>,
    },
    /// Look at a motion before anything is designed.
    #[command(subcommand)]
    Motion(MotionCommand),
    /// Table of many designs.
    Stats {
        /// Output folders, or folders of such folders.
        #[arg(required = true)]
        designs: Vec<PathBuf>,
        /// How it is written.
        #[arg(long, value_enum, default_value_t)]
        format: TableFormat,
    },
    /// Print the completions of a shell: `mpcgear completions bash > ~/.local/share/bash-completion/completions/mpcgear`.
    Completions {
        /// Which shell.
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Write the man pages, one for each command.
    Man {
        /// Folder to write them into; it must be there.
        folder: PathBuf,
    },
}

/// What to do with a motion.
#[derive(Debug, Subcommand)]
pub enum MotionCommand {
    /// How far it goes, how sharply it changes, which joint it needs.
    Show {
        /// Motion file (TOML).
        file: PathBuf,
        /// Print the motion over the driver angle as CSV instead.
        #[arg(long, conflicts_with = "json")]
        csv: bool,
    },
    /// From measured or hand-made poses to a smooth motion file.
    Fit(FitArgs),
}

/// Arguments of `motion fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Poses (CSV): phi_deg,x,y,z,qw,qx,qy,qz in mm.
    pub poses: PathBuf,
    /// How far the motion may be from the poses: 0.2mm,0.5deg.
    #[arg(long, value_name = "MM,DEG", value_parser = parse_pose_tolerance)]
    pub tolerance: Tolerance,
    /// Class of the motion instead of the simplest that does.
    #[arg(long, value_parser = parse_class)]
    pub class: Option<mpcgear::motion::Class>,
    /// Motion file to write, its poses beside it (.csv) [default: POSES_fitted.toml]; existing files are
    /// left alone.
    #[arg(short, long)]
    pub out: Option<PathBuf>,
}

/// Arguments of `design`.
#[derive(Debug, Args)]
pub struct DesignArgs {
    /// Motion file (TOML).
    pub file: PathBuf,
    /// Output folder.
    #[arg(short, long)]
    pub out: PathBuf,
    /// Seed instead of the file's.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Search effort instead of the file's; 1 is the default.
    #[arg(long)]
    pub effort: Option<f64>,
    /// End within this many seconds with the best so far: half for the search, the rest for bodies,
    /// proof and files.
    #[arg(long, value_name = "SECONDS")]
    pub max_time: Option<f64>,
    /// First look in a few seconds: bodies and figures of a choice that is neither polished nor proved.
    #[arg(long, conflicts_with = "method")]
    pub draft: bool,
    /// Progress as lines of JSON on standard error, for programs that show it.
    #[arg(long)]
    pub progress: bool,
    /// Parameterisation instead of the file's.
    #[arg(long, value_enum)]
    pub method: Option<Method>,
    /// A setting instead of the file's: gear.teeth=12. More than once for several.
    #[arg(long, value_name = "PATH=VALUE", value_parser = Change::parse)]
    pub set: Vec<Change>,
}

/// Arguments of `trial`.
#[derive(Debug, Args)]
pub struct TrialArgs {
    /// Motion file (TOML).
    pub file: PathBuf,
    /// A setting instead of the file's: gear.teeth=12. More than once for several.
    #[arg(long, value_name = "PATH=VALUE", value_parser = Change::parse)]
    pub set: Vec<Change>,
    /// Folder of trials; this one gets a folder in it that is named by what it is made from.
    #[arg(long, value_name = "FOLDER")]
    pub into: PathBuf,
    /// Bodies and figures of a first look, neither polished nor proved.
    #[arg(long)]
    pub draft: bool,
    /// After so long it is ended and recorded as one that cannot be computed.
    #[arg(long, value_name = "SECONDS", default_value = "1200", value_parser = parse_seconds)]
    pub timeout: f64,
    /// Memory that it may have, MB.
    #[arg(long, value_name = "MB", default_value = "2000")]
    pub memory_mb: u64,
    /// Threads that it may have; 0 is one a core.
    #[arg(long, default_value = "0")]
    pub threads: u64,
    /// Computes here, in this process, without looking at time.
    #[arg(long, hide = true)]
    pub unwatched: bool,
}

/// Arguments of `explore`.
#[derive(Debug, Args)]
pub struct ExploreArgs {
    /// Motion file (TOML).
    pub file: PathBuf,
    /// Study file (TOML): variables, objectives, constraints, budget.
    pub study: PathBuf,
    /// Folder of the study; an interrupted one is continued.
    #[arg(short, long)]
    pub out: PathBuf,
    /// Trials at the same time, here.
    #[arg(long, default_value_t = cores(), conflicts_with = "scheduler")]
    pub workers: usize,
    /// Dask scheduler whose workers to use instead: tcp://host:8786.
    #[arg(long, value_name = "ADDRESS")]
    pub scheduler: Option<String>,
    /// Show how far the study in this folder is, until it is done; computes nothing.
    #[arg(long, conflicts_with_all = ["shard", "scheduler"])]
    pub watch: bool,
    /// Compute only the drafts i, i + n, i + 2n … of an even spread, without Python; a later run without
    /// this takes them over.
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
}

/// Part `index` (from 0) of `count`.
#[derive(Debug, Clone, Copy)]
pub struct Shard {
    /// Which.
    pub index: u64,
    /// Of how many.
    pub count: u64,
}

/// How tooth pairs are parameterised.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Method {
    /// Normal first: conjugation exact by construction.
    Exact,
    /// The published B-spline formulation with penalties.
    Paper,
}

/// Arguments of `size`.
#[derive(Debug, Args)]
pub struct SizeArgs {
    /// Motion file.
    pub file: PathBuf,
    /// What the gear has to carry at the load point: 800g, 0.8kg.
    #[arg(long, value_parser = parse_mass)]
    pub payload: f64,
    /// Material of both gears instead of the motion file's: PLA, PETG, SLA, PA12, steel.
    #[arg(long, value_parser = parse_material)]
    pub material: Option<Material>,
    /// Largest elastic displacement of the load point under the payload: 0.5mm.
    #[arg(long, value_name = "MM", value_parser = parse_length)]
    pub max_deflection: Option<f64>,
    /// A setting instead of the file's: gear.teeth=12. More than once for several.
    #[arg(long, value_name = "PATH=VALUE", value_parser = Change::parse)]
    pub set: Vec<Change>,
}

/// Arguments of `check`. Bodies whose mesh is not given are read from `meshes/` beside the design, or
/// built where there is none.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// `design.json` or the folder with it.
    pub design: PathBuf,
    /// Meshes instead of those of the design.
    #[command(flatten)]
    pub meshes: MeshArgs,
    /// Room of the printer, mm.
    #[arg(long, value_name = "XxYxZ", value_parser = parse_volume, default_value = "220x220x250")]
    pub printer: [f64; 3],
    /// How far a printed surface may lie outside its place, mm, instead of the design's `surface_error_mm`.
    #[arg(long, value_name = "MM", value_parser = parse_tolerance)]
    pub tolerance: Option<f64>,
    /// How densely to look; 1 is the default.
    #[arg(long, value_parser = parse_share, default_value = "1")]
    pub effort: f64,
}

/// Meshes to check instead of those of the design.
#[derive(Debug, Default, Args)]
pub struct MeshArgs {
    /// STL of the driver to check instead, ASCII or binary, assembled at φ = 0, mm.
    #[arg(long, value_name = "STL")]
    pub driver: Option<PathBuf>,
    /// The same for the follower.
    #[arg(long, value_name = "STL")]
    pub follower: Option<PathBuf>,
    /// The same for the support.
    #[arg(long, value_name = "STL")]
    pub support: Option<PathBuf>,
    /// The same for the slider of a 3R1T mechanism.
    #[arg(long, value_name = "STL")]
    pub slider: Option<PathBuf>,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// `design.json` or the folder with it.
    #[arg(required_unless_present = "list")]
    pub design: Option<PathBuf>,
    /// Formats, separated by commas.
    #[arg(long, value_delimiter = ',', required_unless_present = "list")]
    pub to: Vec<String>,
    /// Output folder, or `-` for a single file on standard output.
    #[arg(short, long, required_unless_present = "list")]
    pub out: Option<PathBuf>,
    /// Only this body: driver, follower, support, slider.
    #[arg(long)]
    pub part: Option<String>,
    /// List the formats.
    #[arg(long)]
    pub list: bool,
}

/// What a design can be compared with.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Standard {
    /// Spur gears with involute teeth.
    Involute,
}

/// How a table is written.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum TableFormat {
    /// Aligned columns.
    #[default]
    Text,
    /// Comma separated.
    Csv,
    /// Markdown.
    Markdown,
}

fn parse_class(text: &str) -> Result<mpcgear::motion::Class, String> {
    mpcgear::motion::Class::ALL
        .into_iter()
        .find(|class| class.to_string().eq_ignore_ascii_case(text))
        .ok_or_else(|| format!("`{text}` is none of 1R, 1R1T, 3R, 3R1T"))
}

/// Mass in grams.
fn parse_mass(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.strip_suffix("kg") {
        Some(number) => (number, 1000.0),
        None => (text.strip_suffix('g').unwrap_or(text), 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value * factor),
        _ => Err(format!("`{text}` is not a mass; write 800g or 0.8kg")),
    }
}

/// A material by its name, in any case.
fn parse_material(text: &str) -> Result<Material, String> {
    let is_named = |m: &&Material| m.to_string().eq_ignore_ascii_case(text);
    let names = Material::ALL.map(|m| m.to_string()).join(", ");
    let found = Material::ALL.iter().find(is_named).copied();
    found.ok_or_else(|| format!("`{text}` is no material; there are {names}"))
}

/// A length larger than 0, `0.5mm`, mm.
fn parse_length(text: &str) -> Result<f64, String> {
    match text.trim_end_matches("mm").trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("`{text}` is not a length; write 0.5mm")),
    }
}

/// A length and an angle larger than 0, `0.2mm,0.5deg`.
fn parse_pose_tolerance(text: &str) -> Result<Tolerance, String> {
    let part = |text: &str, unit: &str| -> Option<f64> {
        let number = text.trim().strip_suffix(unit)?.trim().parse().ok()?;
        (f64::is_finite(number) && number > 0.0).then_some(number)
    };
    let parts = text.split_once(',');
    parts
        .and_then(|(mm, deg)| {
            Some(Tolerance {
                mm: part(mm, "mm")?,
                deg: part(deg, "deg")?,
            })
        })
        .ok_or_else(|| format!("`{text}` is not a length and an angle; write 0.2mm,0.5deg"))
}

/// Three lengths in mm, `220x220x250`.
fn parse_volume(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split('x').map(|n| n.trim().parse().ok()).collect();
    numbers
        .and_then(|numbers| <[f64; 3]>::try_from(numbers).ok())
        .filter(|size| size.iter().all(|x| x.is_finite() && *x > 0.0))
        .ok_or_else(|| format!("`{text}` is not a size; write 220x220x250"))
}

/// A length of at least 0, mm.
fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err(format!("`{text}` is not a tolerance from 0 to 1 mm")),
    }
}

/// A factor, larger than 0 and at most 100.
fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 100.0 => Ok(value),
        _ => Err(format!("`{text}` is not a factor above 0 and up to 100")),
    }
}

/// A time above 0 and up to a year, s.
fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 3.2e7 => Ok(value),
        _ => Err(format!("`{text}` is not a time above 0, in seconds")),
    }
}

/// `i/n`, i from 0 to n − 1.
fn parse_shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((index, count)) if index < count => Ok(Shard { index, count }),
        _ => Err(format!(
            "`{text}` is not a part; write 0/4, 1/4, 2/4 or 3/4"
        )),
    }
}

/// Cores of this machine.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
