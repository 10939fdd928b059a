//! The hub that a rib is clamped to.

use nalgebra::Vector3;

use crate::design::{Design, Gear};
use crate::solid::{layout, sweep};

/// The drum or drums around a gear's axis, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hub {
    /// A point of the axis, which is parallel to z.
    pub axis: Vector3<f64>,
    /// Radius of the drum.
    pub radius: f64,
    /// Radius at which ribs end, inside the drum.
    pub foot: f64,
    /// Beside a ball: height above (and below) the joint at which the drum begins, and its radius there; from
    /// there it grows by 45° ([`crate::solid::layout`]).
    collar: Option<(f64, f64)>,
}

impl Hub {
    /// The hub of `gear`, as the recipe has it; of a design without recipe the smallest.
    pub fn of(design: &Design, gear: Gear) -> Hub {
        let named = |name: &str, otherwise: f64| {
            let mut rows = design.recipe.parameters.iter();
            rows.find(|row| row.name == name)
                .map_or(otherwise, |row| row.value)
        };
        let settings = &design.settings;
        let (radius, collar) = match gear {
            Gear::Driver => (
                named("driver_hub_radius", settings.hub.driver_radius_mm),
                None,
            ),
            Gear::Follower => {
                let least = settings.hub.follower_radius_mm;
                let collar = (
                    named("drum_start", 0.0),
                    named("follower_collar_radius", least),
                );
                (
                    named("follower_hub_radius", least),
                    design.class.is_spherical().then_some(collar),
                )
            }
        };
        Hub {
            axis: sweep::axis_point(gear, settings.gear.center_distance_mm),
            radius,
            foot: layout::rib_foot(design, gear),
            collar,
        }
    }

    /// Its radius at the height `z`; `None` beside the joint, where there is no hub.
    pub fn radius_at(&self, z: f64) -> Option<f64> {
        match self.collar {
            None => Some(self.radius),
            Some((start, _)) if z.abs() < start => None,
            Some((start, collar)) => Some(self.radius.min(collar + z.abs() - start)),
        }
    }
}
