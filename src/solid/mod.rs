//! From teeth and layout to solids.

pub mod mesh;
pub mod recipe;

pub use mesh::Mesh;
