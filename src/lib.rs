//! Multi-point conjugation gears: from a periodic rigid-body motion to a printable gear mechanism.
//!
//! One way through the house; every room needs only those before it:
//!
//! 1. [`motion`] reads what the user wants: poses M²(φ) of the follower with exact derivatives.
//! 2. [`contact`] makes one tooth pair from its contact normal: both flanks share point, normal and
//!    normal speed by construction. [`sub_gear`] puts J of them around the gears: one band.
//! 3. [`closure`] measures how well K contacts hold the follower: Q(φ) > 0 means in every direction.
//! 4. [`search`] draws bands, keeps those that can be made, and chooses and polishes K of them.
//! 5. [`synthesis`] traces the chosen bands finely: the [`design`], which is all that the rest needs
//!    and what `design.json` holds.
//! 6. [`solid`] builds hubs, joints, frame and teeth as meshes from the design's recipe.
//! 7. [`verify`] tries every claim on those meshes; [`load`] says what they bear.
//! 8. [`export`] writes files, [`disk`] puts them in place whole or not at all, [`stats`] compares.
//!    [`involute`] is the standard pair of spur gears that a mechanism at a constant ratio is compared with.
//! 9. [`explore`] says what a study of many designs is, and what one trial of it.
//!
//! [`pipeline`] walks the whole way and falls back to the next best choice where the meshes refuse the
//! best. mm, rad and N everywhere; nothing in the library prints.
//!
//! # A first design
//!
//! ```
//! use mpcgear::motion::MotionFile;
//! use mpcgear::synthesis::{self, Bands, Flanks};
//! use mpcgear::{design, search};
//! use std::ops::ControlFlow;
//! use std::path::Path;
//!
//! let text = r#"
//!     name = "quick return"
//!     class = "1R"
//!     [motion]
//!     kind = "formula"
//!     own_turn = "-phi + 0.1*sin(phi)"
//!     [search]
//!     effort = 0.02
//! "#;
//! let (file, motion) = MotionFile::parse(text, Path::new("quick.toml"), Path::new("."))?;
//! let watch = &mut |_: &search::Progress| ControlFlow::Continue(());
//! let found = search::run(&motion, &file.settings, watch)?;
//! let (bands, _) = found.choices[0].clone();
//! let design = synthesis::design(&file, &motion, &Bands::Exact(bands), Flanks::Flat)?;
//!
//! // Two contacts hold a follower that can only turn, at every angle, and the flanks are conjugate.
//! assert_eq!(design.sub_gear_pairs.len(), 2);
//! assert!(design.closure.iter().all(|sample| sample.q > 0.0));
//! assert!(synthesis::conjugation_residual(&design, &motion) < 1e-9);
//!
//! // What is written is what is read.
//! let text = design::file::text(&design)?;
//! let read = design::Stored::parse(text.as_bytes(), Path::new("design.json"))?;
//! assert_eq!(read.design, design);
//! # Ok::<(), mpcgear::Error>(())
//! ```
//!
//! [`pipeline::run`] does this with solids, proof and all, and [`export::files`] makes the output folder.

pub mod bound;
pub mod certified;
pub mod closure;
pub mod contact;
pub mod design;
pub mod disk;
pub mod envelope;
mod error;
pub mod escape;
pub mod explore;
pub mod export;
pub mod flank;
pub mod flare;
pub mod involute;
pub mod load;
pub mod motion;
pub mod pipeline;
mod ranking;
pub mod remedy;
pub mod search;
pub mod settings;
pub mod sizing;
pub mod solid;
pub mod stats;
pub mod strength;
pub mod sub_gear;
pub mod synthesis;
pub mod table;
pub mod verify;

pub use error::{Error, Problem, Problems, Result};
