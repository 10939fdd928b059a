//! One tooth pair: the contact point and normal over its contact interval.

mod normal_first;

pub use normal_first::{Contact, Grid, Node, ToothLaw, Trace, trace};
