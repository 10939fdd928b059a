//! Exploring designs: what a trial is, how it is measured, what a study asks for.
//!
//! A *study* varies settings of a motion file and says what is wanted of the designs. A *trial* is one choice of
//! values, kept in a folder named by what went into it, so that nobody computes it twice. Here is what
//! needs no Python: [`study`] reads and checks the study file, [`trial`] names and records a
//! trial, [`measures`] are the figures that studies may ask for, [`plan`] spreads trials evenly for `--shard`.
//! Searching, spreading over machines and the report are in `python/mpcgear_explore`.

pub mod measures;
pub mod plan;
mod reader;
pub mod study;
pub mod trial;
