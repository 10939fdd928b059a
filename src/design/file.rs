//! `design.json`: the one reader that every command uses.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{Design, FORMAT, check};
use crate::motion::Motion;
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
        if head.format != u64::from(FORMAT) {
            let hint = "use the version of mpcgear that wrote it, or design again";
            let what = format!("is {}, this version reads {FORMAT}", head.format);
            return Err(refuse(Problem::new("format", what, hint).into()));
        }
        let mut text = serde_json::Deserializer::from_slice(bytes);
        let design: Design = serde_path_to_error::deserialize(&mut text).map_err(|e| {
            let (place, what) = (e.path().to_string(), e.into_inner().to_string());
            refuse(Problem::new(place, what, "").into())
        })?;
        let problems = check::problems(&design);
        if !problems.is_empty() {
            return Err(refuse(problems));
        }
        let motion = match Motion::new(design.class, &design.motion) {
            Err(Error::Input { problems, .. }) => return Err(refuse(problems)),
            other => other,
        };
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
