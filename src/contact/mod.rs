//! One tooth pair: the contact point and normal over its contact interval.

mod normal_first;
pub mod paper;
pub mod paper_band;
mod paper_finish;
mod plane;
pub mod spline;

pub use normal_first::{Contact, Grid, Node, ToothLaw, Trace, trace};
pub use paper_band::{BandStart, PaperBand};
