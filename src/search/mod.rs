//! From a motion to K compatible sub-gear pairs.

pub mod candidates;
pub mod clearance;
pub mod polish;
pub mod select;
