//! The publication's three known ways to fail, recognised by where bodies overlap.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::claim::{Claim, Spot};
use super::mechanism::Mechanism;
use super::overlap::{PairProof, Place};
use crate::design::{Design, Gear};
use crate::solid::assembly::Carrier;

/// Points farther than this from every contact curve are not on a tooth but on its spoke or hub, mm.
const TOOTH_REACH: f64 = 3.0;

/// A known way to fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Failure {
    /// The motion's range is so large that the follower needs the room of its support.
    FollowerMeetsSupport,
    /// Strongly curved motion twists the follower's teeth into their own mates or their spokes.
    TwistedTeeth,
    /// Teeth are so long that they hit teeth that are not their mates.
    WrongMates,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Failure::FollowerMeetsSupport => {
                "the motion range is so large that follower and support need the same room: \
                 reduce the range, or widen the frame (center distance, reach)"
            }
            Failure::TwistedTeeth => {
                "the motion turns so sharply that the follower's teeth are twisted into the driver's \
                 teeth or spokes: smooth the motion there, or slow it down"
            }
            Failure::WrongMates => {
                "teeth are so long that they hit teeth that are not their mates: use more, shorter \
                 teeth, a smaller contact ratio, or equal tooth numbers on both gears"
            }
        })
    }
}

/// A recognised failure and where it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recognised {
    /// Which one.
    pub failure: Failure,
    /// Phase and point.
    pub place: Place,
    /// Sub-gear pair and tooth of the driver nearest to it, from 0.
    pub driver_tooth: Option<(usize, usize)>,
    /// Sub-gear pair and tooth of the follower nearest to it, from 0.
    pub follower_tooth: Option<(usize, usize)>,
}

/// The claim that a recognised failure refutes.
pub(super) fn claim(found: &Recognised) -> Claim {
    let name = |tooth: Option<(usize, usize)>| {
        tooth.map_or("no tooth".into(), |(k, j)| {
            format!("pair {} tooth {}", k + 1, j + 1)
        })
    };
    let (driver, follower) = (found.driver_tooth, found.follower_tooth);
    Claim::new("known failure", &found.failure.to_string())
        .say(
            false,
            format!("driver: {}, follower: {}", name(driver), name(follower)),
            "none of the known failures",
        )
        .at(Spot::from(found.place).on(driver.or(follower)))
}

/// Names the failure behind each pair of bodies that overlaps.
pub(super) fn recognise(
    design: &Design,
    mechanism: &Mechanism,
    pairs: &[PairProof],
) -> Vec<Recognised> {
    pairs
        .iter()
        .filter_map(|pair| {
            let place = pair.overlap_at?;
            let has = |name: &str| pair.bodies.iter().any(|b| b == name);
            let tooth = |gear: Gear, carrier: Carrier| {
                let p = mechanism
                    .pose(carrier, place.phi)
                    .inverse_apply(Vector3::from(place.at));
                nearest_tooth(design, gear, p)
            };
            let driver_tooth = tooth(Gear::Driver, Carrier::Driver).filter(|_| has("driver"));
            let follower_tooth =
                tooth(Gear::Follower, Carrier::Follower).filter(|_| has("follower"));
            let failure = match (has("driver"), has("follower")) {
                (false, true) => Failure::FollowerMeetsSupport,
                (true, true) => match (driver_tooth, follower_tooth) {
                    (Some(a), Some(b)) if a != b => Failure::WrongMates,
                    _ => Failure::TwistedTeeth,
                },
                _ => return None,
            };
            Some(Recognised {
                failure,
                place,
                driver_tooth,
                follower_tooth,
            })
        })
        .collect()
}

/// Sub-gear pair and tooth whose contact curve on `gear` comes nearest to `p` (body frame).
pub(super) fn nearest_tooth(
    design: &Design,
    gear: Gear,
    p: Vector3<f64>,
) -> Option<(usize, usize)> {
    let mut best = (TOOTH_REACH, None);
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            for s in &tooth.stations {
                let distance = (s.frame(gear).0 - p).norm();
                if distance < best.0 {
                    best = (distance, Some((k, j)));
                }
            }
        }
    }
    best.1
}
