//! From teeth and layout to solids: [`layout`] measures what teeth and motion leave free and writes
//! the recipe, [`primitive`] and the sweep of the teeth turn it into meshes, [`assembly`] collects
//! bodies and print pieces.

pub mod assembly;
pub mod expression;
mod hub;
mod joints;
pub mod kernel;
pub mod landmarks;
pub mod layout;
pub mod measure;
pub mod mesh;
pub mod pieces;
pub mod primitive;
pub mod recipe;
pub mod rib;
pub mod section;
pub mod slivers;
mod support;
pub mod sweep;

pub use assembly::Solids;
pub use mesh::Mesh;
