//! Files made from a design.

pub mod chart;
mod compact;
pub mod compare;
pub mod curves;
pub mod figures;
pub mod picture;
pub mod report;
