//! Multi-point conjugation gears: from a periodic rigid-body motion to a printable gear mechanism.
//!
//! One way through the house: [`motion`] → [`contact`] → [`sub_gear`] → [`search`] → [`design`] →
//! [`solid`] → [`verify`] → [`export`].

pub mod closure;
pub mod contact;
pub mod design;
pub mod disk;
pub mod envelope;
mod error;
pub mod export;
pub mod load;
pub mod motion;
pub mod pipeline;
pub mod search;
pub mod settings;
pub mod solid;
pub mod stats;
pub mod sub_gear;
pub mod synthesis;
pub mod table;
pub mod verify;

pub use error::{Error, Problem, Problems, Result};
