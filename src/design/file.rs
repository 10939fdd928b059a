//! `design.json`: the one reader that every command uses, and the writer.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::lines::Lines;
use super::{Design, FORMAT, Station, check};
use crate::motion::{Drive, Motion};
use crate::solid::Solids;
use crate::{Error, Problem, Problems, Result};

/// Larger files are refused before they are read.
const MAX_BYTES: u64 = 200_000_000;

/// A design that was read, with its motion.
#[derive(Debug)]
pub struct Stored {
    /// The file it was in.
    pub file: PathBuf,
    /// The design.
    pub design: Design,
    /// Its motion; the drafts of motions that no gear can perform have none.
    motion: Result<Motion>,
}

/// The beginning of every format.
#[derive(Deserialize)]
struct Head {
    format: u64,
}

impl Stored {
    /// Reads a design from its file, or from the folder it is in.
    ///
    /// # Errors
    /// [`Error::Io`] for what cannot be read, [`Error::Input`] with every problem of a file that is
    /// no design, of another format, or has values out of range.
    pub fn read(path: &Path) -> Result<Stored> {
        let file = match path.is_dir() {
            true => path.join("design.json"),
            false => path.to_path_buf(),
        };
        Stored::parse(&read_bytes(&file)?, &file)
    }

    /// Reads a design from the bytes of `file`.
    ///
    /// # Errors
    /// As [`Stored::read`].
    pub fn parse(bytes: &[u8], file: &Path) -> Result<Stored> {
        let refuse = |problems: Problems| Error::input(file, problems);
        let broken = |what: String| {
            let hint = "give the design.json, or its folder, as `mpcgear design` wrote it";
            refuse(Problem::new("design.json", what, hint).into())
        };
        let head: Head =
            serde_json::from_slice(bytes).map_err(|e| broken(format!("is no design: {e}")))?;
        if !(1..=u64::from(FORMAT)).contains(&head.format) {
            let hint = "use the version of mpcgear that wrote it, or design again";
            let what = format!("is {}, this version reads 1 to {FORMAT}", head.format);
            return Err(refuse(Problem::new("format", what, hint).into()));
        }
        let mut text = serde_json::Deserializer::from_slice(bytes);
        let mut design: Design = serde_path_to_error::deserialize(&mut text).map_err(|e| {
            let (place, what) = (e.path().to_string(), e.into_inner().to_string());
            refuse(Problem::new(place, what, "").into())
        })?;
        let first = head.format == 1;
        let problems = check::problems(&design, first);
        if !problems.is_empty() {
            return Err(refuse(problems));
        }
        let motion = match Motion::new(design.class, &design.motion) {
            Err(Error::Input { problems, .. }) => return Err(refuse(problems)),
            other => other,
        };
        if first {
            design.format = FORMAT;
            design.stations_mut().for_each(add_velocities);
        } else if let Ok(motion) = &motion {
            let drive = design.settings.gear.drive();
            for stations in design.stations_mut() {
                place_on_gears(stations, drive, motion);
            }
            let problems = check::tangents(&design);
            if !problems.is_empty() {
                return Err(refuse(problems));
            }
        }
        Ok(Stored {
            file: file.into(),
            design,
            motion,
        })
    }

    /// The design with its motion, for everything that needs both.
    ///
    /// # Errors
    /// [`Error::Infeasible`] for the draft of a motion that no gear can perform.
    pub fn with_motion(self) -> Result<(Design, Motion, PathBuf)> {
        Ok((self.design, self.motion?, self.file))
    }
}

/// The bodies of a design that was read from `file`.
///
/// # Errors
/// As [`Solids::build`]; a recipe that does not come out as solids is an [`Error::Input`] of the file.
pub fn solids(design: &Design, motion: &Motion, file: &Path) -> Result<Solids> {
    Solids::build(design, motion).map_err(|error| match error {
        Error::Internal(what) if !design.recipe.bodies.is_empty() => {
            let hint = "the recipe in the file does not build a part; design again";
            Error::input(file, vec![Problem::new("recipe", what, hint)])
        }
        other => other,
    })
}

/// What stands in the gears' frames, from what stands in Σ.
fn place_on_gears(stations: &mut [Station], drive: Drive, motion: &Motion) {
    for s in stations {
        let driver = drive.state(s.phi);
        *s = Station::new(s.contact(), &driver, &motion.state(s.phi));
    }
}

/// Format 1 has no velocities: the derivative of the polynomial through the seven nearest stations.
fn add_velocities(stations: &mut [Station]) {
    const WINDOW: usize = 7;
    let count = stations.len();
    let v: Vec<Vector3<f64>> = (0..count)
        .map(|i| {
            let first = i.saturating_sub(WINDOW / 2);
            let first = first.min(count.saturating_sub(WINDOW));
            let near = &stations[first..count.min(first + WINDOW)];
            derivative(near, i - first)
        })
        .collect();
    for (station, v) in stations.iter_mut().zip(v) {
        station.v = v.into();
    }
}

/// dp/dφ at station `i` of the polynomial through all `stations` (barycentric form).
fn derivative(stations: &[Station], i: usize) -> Vector3<f64> {
    let x = |k: usize| stations[k].phi;
    let others = |k: usize| (0..stations.len()).filter(move |&m| m != k);
    let weight = |k: usize| others(k).map(|m| x(k) - x(m)).product::<f64>().recip();
    let p = |k: usize| Vector3::from(stations[k].p);
    others(i)
        .map(|k| (p(k) - p(i)) * (weight(k) / weight(i) / (x(i) - x(k))))
        .sum()
}

/// A design as it is written.
#[derive(Serialize)]
struct Written<'a> {
    #[serde(flatten)]
    design: &'a Design,
    /// For programs that do not evaluate the motion: of every tooth j, at the φ of its stations, rows
    /// of φ, the follower's position and quaternion (x, y, z, w). The reader does not need them.
    poses: Vec<Vec<[f64; 8]>>,
}

/// Decimals of the poses, far below what a tooth can show.
const POSE_DECIMALS: i32 = 12;

/// The text of `design.json`.
///
/// # Errors
/// Those of the design's motion; [`Error::Internal`] when the encoder fails.
pub fn text(design: &Design) -> Result<String> {
    let pose = |motion: &Motion, phi: f64| {
        let pose = motion.state(phi).pose;
        let q = pose.quaternion();
        let t = pose.translation;
        let scale = 10f64.powi(POSE_DECIMALS);
        let round = |x: f64| (x * scale).round() / scale + 0.0;
        let [x, y, z, i, j, k, w] = [t.x, t.y, t.z, q.i, q.j, q.k, q.w].map(round);
        [phi, x, y, z, i, j, k, w]
    };
    let poses = match design.sub_gear_pairs.first() {
        None => Vec::new(),
        Some(pair) => {
            let motion = Motion::new(design.class, &design.motion)?;
            let rows = |stations: &[Station]| {
                let phis = stations.iter().map(|s| s.phi);
                phis.map(|phi| pose(&motion, phi)).collect()
            };
            pair.teeth.iter().map(|t| rows(&t.stations)).collect()
        }
    };
    let mut bytes = Vec::new();
    let mut to = serde_json::Serializer::with_formatter(&mut bytes, Lines::default());
    Written { design, poses }
        .serialize(&mut to)
        .map_err(|e| Error::Internal(format!("design.json: {e}")))?;
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(|e| Error::Internal(format!("design.json: {e}")))
}

/// The bytes of a regular file of bounded size.
fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let refuse = |what: String, hint: &str| {
        Err(Error::input(
            path,
            vec![Problem::new("design.json", what, hint)],
        ))
    };
    // Asked before it is opened: opening a pipe waits for its writer.
    let about = std::fs::metadata(path).map_err(Error::io(path))?;
    if !about.is_file() {
        return refuse(
            "is not a regular file".into(),
            "give a design.json or its folder",
        );
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(Error::io(path))?;
    if about.len() <= MAX_BYTES {
        // One byte more tells a file that has grown since.
        file.take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(Error::io(path))?;
    }
    if about.len().max(bytes.len() as u64) > MAX_BYTES {
        let limit = MAX_BYTES / 1_000_000;
        let what = format!("has more than the allowed {limit} MB");
        return refuse(what, "the largest designs have some 20 MB");
    }
    Ok(bytes)
}
