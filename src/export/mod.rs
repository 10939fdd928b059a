//! From solids to files.

pub mod freecad;
