//! A motion looked at before anything is designed: how far it tilts and slides, how fast it changes,
//! and which joint it needs.

use nalgebra::Vector3;
use serde::Serialize;

use super::checks::{SPACE_MM, SPACE_RAD, tilt};
use super::{Class, Cycle, Motion, MotionState, hub};

/// Phases looked at per period.
const PHASES: usize = 360;

/// Sharpness up to which gears are usually found, and above which they rarely are, as parts of the
/// pitch radius: 10 and 12 mm/rad² at the centre distance of 25 mm, where it was measured.
const USUAL: f64 = 10.0 / 12.5;
const RARE: f64 = 12.0 / 12.5;

/// Motion of the follower at one driver angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Driver angle, deg.
    pub phi_deg: f64,
    /// The followed point in Σ, mm.
    pub point_mm: [f64; 3],
    /// Angle of the follower's axis against z, deg.
    pub tilt_deg: f64,
    /// Turn about the follower's own axis, counted on beyond whole turns, deg.
    pub turn_deg: f64,
    /// Height of the joint's centre above O, mm.
    pub slide_mm: f64,
    /// Angular speed of the follower, in those of the driver.
    pub turn_speed: f64,
    /// Change of `slide_mm` per radian of the driver, mm/rad.
    pub slide_speed_mm_rad: f64,
    /// How fast the motion changes, as in [`Sharpness`], mm/rad².
    pub sharpness_mm_rad2: f64,
}

/// How fast the follower's twist changes, turns counted at its pitch radius L/2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sharpness {
    /// Largest |dω/dφ| L/2 + |dv/dφ| of a period, mm/rad².
    pub most_mm_rad2: f64,
    /// Where it is, deg.
    pub phi_deg: f64,
    /// Up to here gears are usually found, mm/rad².
    pub usual_mm_rad2: f64,
    /// Above this they rarely are, mm/rad².
    pub rare_mm_rad2: f64,
}

impl Sharpness {
    /// What that means for the search, in words.
    pub fn verdict(&self) -> &'static str {
        if self.most_mm_rad2 <= self.usual_mm_rad2 {
            "usually works"
        } else if self.most_mm_rad2 <= self.rare_mm_rad2 {
            "may work"
        } else {
            "rarely works"
        }
    }
}

/// What a motion is like.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// Class of joint that the motion was given with.
    pub class: Class,
    /// Least class whose motion space holds the motion as it was given, within the tolerance of the
    /// motion file.
    pub least_class: Class,
    /// Turns of the follower about its own axis per turn of the driver.
    pub net_turns: f64,
    /// Largest tilt of the follower's axis, deg.
    pub tilt_max_deg: f64,
    /// Farthest that the turn is from that of a uniform gear, which turns by −φ, deg.
    pub lead_max_deg: f64,
    /// Lowest and highest place of the joint's centre, mm.
    pub slide_mm: [f64; 2],
    /// Largest angular speed, in those of the driver.
    pub turn_speed_max: f64,
    /// Largest speed of the slide either way, mm/rad.
    pub slide_speed_max_mm_rad: f64,
    /// Length of the followed point's path, mm.
    pub path_mm: f64,
    /// Where and how much the motion changes fastest.
    pub sharpness: Sharpness,
    /// The motion over a whole turn, both ends included.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

/// Where the motion changes fastest, for a centre distance in mm.
pub fn sharpest(motion: &Motion, center_distance: f64) -> Sharpness {
    sharpest_of(motion.cycle(), center_distance, |phi| motion.state(phi))
}

/// The same of any motion that runs through `cycle`.
pub(super) fn sharpest_of(
    cycle: Cycle,
    center_distance: f64,
    state: impl Fn(f64) -> MotionState,
) -> Sharpness {
    let radius = center_distance / 2.0;
    let (phi, most) = cycle
        .phases(PHASES)
        .map(|phi| (phi, change(&state(phi), radius)))
        .fold((0.0, 0.0), |best, at| if at.1 > best.1 { at } else { best });
    Sharpness {
        most_mm_rad2: most,
        phi_deg: phi.to_degrees(),
        usual_mm_rad2: USUAL * radius,
        rare_mm_rad2: RARE * radius,
    }
}

/// |dω/dφ| of a pitch `radius` (mm) + |dv/dφ|, mm/rad².
fn change(state: &MotionState, radius: f64) -> f64 {
    state.omega_rate.norm() * radius + state.v_origin_rate.norm()
}

/// Looks at one period of `motion`: gears at `center_distance` mm, and the path of a `point` of the
/// follower's frame, mm.
pub fn survey(motion: &Motion, center_distance: f64, point: Vector3<f64>) -> Survey {
    let samples = samples(motion, point, center_distance / 2.0);
    let most = |get: &dyn Fn(&Sample) -> f64| samples.iter().map(get).fold(0.0, f64::max);
    let heights = || samples.iter().map(|s| s.slide_mm);
    let (first, last) = (samples[0], samples[samples.len() - 1]);
    let place = |s: &Sample| Vector3::from(s.point_mm);
    Survey {
        class: motion.class(),
        least_class: least_class(motion),
        net_turns: (last.turn_deg - first.turn_deg) / 360.0,
        tilt_max_deg: most(&|s| s.tilt_deg),
        lead_max_deg: most(&|s| (s.turn_deg + s.phi_deg).abs()),
        slide_mm: [
            heights().fold(f64::INFINITY, f64::min),
            heights().fold(f64::NEG_INFINITY, f64::max),
        ],
        turn_speed_max: most(&|s| s.turn_speed),
        slide_speed_max_mm_rad: most(&|s| s.slide_speed_mm_rad.abs()),
        path_mm: samples
            .windows(2)
            .map(|pair| (place(&pair[1]) - place(&pair[0])).norm())
            .sum(),
        sharpness: sharpest(motion, center_distance),
        samples,
    }
}

fn samples(motion: &Motion, point: Vector3<f64>, radius: f64) -> Vec<Sample> {
    let phase = |i: usize| motion.cycle().part(i, PHASES);
    let states: Vec<MotionState> = (0..=PHASES).map(|i| motion.state(phase(i))).collect();
    let turns = hub::unwrapped(states.iter().map(|s| s.pose.quaternion()));
    (0..=PHASES)
        .zip(&states)
        .zip(turns)
        .map(|((i, state), turn)| Sample {
            phi_deg: phase(i).to_degrees(),
            point_mm: state.pose.apply(point).into(),
            tilt_deg: tilt(state).to_degrees(),
            turn_deg: turn.to_degrees(),
            slide_mm: state.pose.translation.z,
            turn_speed: state.omega.norm(),
            slide_speed_mm_rad: state.velocity(state.pose.translation).z,
            sharpness_mm_rad2: change(state, radius),
        })
        .collect()
}

/// The first class whose motion space the motion stays in, in the frame it was given in.
fn least_class(motion: &Motion) -> Class {
    let poses = || {
        motion
            .cycle()
            .phases(PHASES)
            .map(|phi| motion.user_pose(phi))
    };
    let tilts = poses().any(|pose| pose.rotation.column(2).angle(&Vector3::z()) > SPACE_RAD);
    let slides = poses().any(|pose| pose.translation.z.abs() > SPACE_MM);
    match (tilts, slides) {
        (false, false) => Class::R1,
        (false, true) => Class::R1T1,
        (true, false) => Class::R3,
        (true, true) => Class::R3T1,
    }
}
