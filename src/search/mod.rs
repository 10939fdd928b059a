//! From a motion to K compatible sub-gear pairs.

pub mod candidates;
pub mod clearance;
mod paper;
pub mod polish;
pub mod select;
pub mod slsqp;
