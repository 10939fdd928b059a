//! Files made from a design.

mod compact;
pub mod curves;
pub mod figures;
pub mod picture;
pub mod report;
