//! The publication's three known ways to fail, recognised by where bodies overlap.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::claim::{Claim, Spot};
use super::mechanism::Mechanism;
use super::overlap::{PairProof, Place};
use crate::design::{Design, Gear};
use crate::solid::assembly::Carrier;
use crate::solid::sweep;

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

/// Sub-gear pair and tooth whose contact curve on `gear`, or a copy of it, comes nearest to `p` (body frame).
pub(super) fn nearest_tooth(
    design: &Design,
    gear: Gear,
    p: Vector3<f64>,
) -> Option<(usize, usize)> {
    let drive = design.settings.gear.drive();
    let mut best = (TOOTH_REACH, None);
    let places: Vec<_> = (0..sweep::copies(drive, gear))
        .map(|copy| drive.copy(copy).inverse_apply(p))
        .collect();
    for (k, pair) in design.sub_gear_pairs.iter().enumerate() {
        for (j, tooth) in pair.teeth.iter().enumerate() {
            for s in &tooth.stations {
                let away = places.iter().map(|p| (s.frame(gear).0 - p).norm());
                let distance = away.fold(f64::INFINITY, f64::min);
                if distance < best.0 {
                    best = (distance, Some((k, j)));
                }
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{FORMAT, Section, Station, SubGearPair, ToothPair};
    use crate::motion::{Class, Drive, Motion, MotionSource};

    /// Two sub-gear pairs of two teeth, all parallel to z: pair 1 below O, pair 2 above.
    fn design() -> Design {
        let station = |at: [f64; 3]| Station {
            phi: 0.0,
            p: at,
            n: [1.0, 0.0, 0.0],
            v: [0.0, 0.0, 1.0],
            p1: at,
            n1: [-1.0, 0.0, 0.0],
            t1: [0.0, 0.0, 1.0],
            p2: at,
            n2: [1.0, 0.0, 0.0],
            t2: [0.0, 0.0, 1.0],
        };
        let tooth = |y: f64, z: f64| ToothPair {
            phi_start: 0.0,
            phi_end: 0.1,
            control_points: Vec::new(),
            fit_error: 0.0,
            flare: Default::default(),
            stations: (0..9)
                .map(|i| station([-12.5, y, z + f64::from(i)]))
                .collect(),
        };
        let pair = |z: f64| SubGearPair {
            flank_radius: None,
            parameters: Vec::new(),
            teeth: vec![tooth(0.0, z), tooth(8.0, z)],
        };
        Design {
            format: FORMAT,
            generator: "test".into(),
            name: "test".into(),
            class: Class::R1,
            settings: Default::default(),
            motion: MotionSource::Uniform {},
            sub_gear_pairs: vec![pair(-20.0), pair(10.0)],
            section: Section {
                thickness: 1.8,
                flank_radius: 0.9,
                tip: 0.9,
                root: 0.6,
                clearance: 0.1,
                rib: 1.4,
            },
            recipe: Default::default(),
            closure: Vec::new(),
            problems: Vec::new(),
        }
    }

    fn recognised(design: &Design, bodies: [&str; 2], at: [f64; 3]) -> Option<Recognised> {
        let motion = Motion::new(Class::R1, &MotionSource::Uniform {}).unwrap();
        let mechanism = Mechanism {
            motion: &motion,
            drive: Drive::new(25.0, 1),
        };
        let place = Place { phi: 0.0, at };
        let pair = PairProof {
            bodies: bodies.map(String::from),
            gap_mm: 0.0,
            gap_at: place,
            colliding_steps: 1,
            overlap_mm3: Some(1.0),
            overlap_at: Some(place),
            doubts: vec![place],
        };
        recognise(design, &mechanism, &[pair]).pop()
    }

    #[test]
    fn the_three_known_failures_are_told_apart() {
        let gears = ["driver", "follower"];
        let mut design = design();
        let mates = recognised(&design, gears, [-12.0, 0.5, 12.0]).unwrap();
        assert_eq!(mates.failure, Failure::TwistedTeeth);
        assert_eq!(mates.driver_tooth, Some((1, 0)));
        assert_eq!(mates.follower_tooth, Some((1, 0)));
        // On the follower's tooth, but far from every tooth of the driver: its spoke or hub.
        for s in &mut design.sub_gear_pairs[1].teeth[1].stations {
            s.p1[0] -= 5.0;
        }
        let spoke = recognised(&design, gears, [-12.0, 8.0, 12.0]).unwrap();
        assert_eq!(spoke.failure, Failure::TwistedTeeth);
        assert_eq!(
            (spoke.driver_tooth, spoke.follower_tooth),
            (None, Some((1, 1)))
        );
        // A driver tooth of pair 1 that reaches up to the follower's pair 2.
        for (s, z) in design.sub_gear_pairs[0].teeth[1]
            .stations
            .iter_mut()
            .zip(6..)
        {
            s.p1[2] = f64::from(z);
        }
        let long = recognised(&design, gears, [-12.4, 7.9, 12.0]).unwrap();
        assert_eq!(long.failure, Failure::WrongMates);
        assert_eq!(
            (long.driver_tooth, long.follower_tooth),
            (Some((0, 1)), Some((1, 1)))
        );
        let support = recognised(&design, ["follower", "support"], [12.5, 0.0, 0.0]).unwrap();
        assert_eq!(support.failure, Failure::FollowerMeetsSupport);
        assert!(recognised(&design, ["driver", "support"], [-30.0, 0.0, 0.0]).is_none());
    }
}
