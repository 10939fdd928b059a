//! How stiff and how strong the teeth are, by linear finite elements on every tooth with its rib.
//!
//! A tooth is a grid of quadratic hexahedra along its sweep ([`tooth_grid`]), held where its rib meets the
//! hub. Contact anywhere along it gives a deflection and a stress at the root ([`tooth`]). Neighbouring teeth
//! and the hub's own give are left out.

mod bead;
pub mod block_cholesky;
mod clamp;
pub mod elastic_body;
pub mod elements;
pub mod tooth;
pub mod tooth_grid;

pub use clamp::Hub;
pub use tooth::{Teeth, ToothStrength};
