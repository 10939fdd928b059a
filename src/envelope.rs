//! What hubs and joints need at least: shared by the search (keep-out regions of the teeth) and by
//! the solids (the dimensions themselves), so that both speak of the same mechanism.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::motion::Motion;
use crate::settings::Settings;

/// Extremes of the motion that the frame has to leave room for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Largest angle between the follower's hub axis and z, rad.
    pub tilt: f64,
    /// Lowest and highest joint centre, mm.
    pub lift: (f64, f64),
}

impl Reach {
    /// Samples the motion at 720 phases.
    pub fn of(motion: &Motion) -> Reach {
        let mut reach = Reach {
            tilt: 0.0,
            lift: (0.0, 0.0),
        };
        for phi in motion.cycle().phases(720) {
            let axis_z = motion.state(phi).pose.rotation[(2, 2)];
            reach.tilt = reach.tilt.max(axis_z.clamp(-1.0, 1.0).acos());
            let z = motion.joint_centre(phi).z;
            reach.lift = (reach.lift.0.min(z), reach.lift.1.max(z));
        }
        reach
    }
}

/// Ball and socket of the spherical classes, centred at the joint centre (mm, rad).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BallJoint {
    /// Radius of the follower's ball.
    pub ball_radius: f64,
    /// Radius of the follower's necks above and below the ball.
    pub neck_radius: f64,
    /// Half angle of the socket's openings, seen from the centre.
    pub opening: f64,
    /// Outer radius of the socket ring about z.
    pub ring_radius: f64,
    /// The ring fills |z| ≤ this.
    pub ring_half_height: f64,
    /// The arm from the ring towards +x fills |z| ≤ this.
    pub arm_half_height: f64,
    /// … and |y| ≤ this.
    pub arm_half_width: f64,
    /// The lugs for the socket's screws fill |x| ≤ this,
    pub lug_half_thickness: f64,
    /// … |y| ≤ this
    pub lug_reach: f64,
    /// … and at least |z| ≤ this.
    pub lug_half_height: f64,
    /// The follower's drums begin at |z| = this (follower frame).
    pub drum_start: f64,
}

impl BallJoint {
    /// Half the height of the socket with all that is on it, mm.
    pub fn half_height(&self) -> f64 {
        let heights = [
            self.ring_half_height,
            self.arm_half_height,
            self.lug_half_height,
        ];
        heights.into_iter().fold(0.0, f64::max)
    }

    /// Whether a point (relative to the joint centre) is nearer than `limit` to the socket.
    pub fn is_near(&self, p: Vector3<f64>, limit: f64) -> bool {
        p.z.abs() - self.half_height() < limit && self.distance(p) < limit
    }

    /// Distance of a point (relative to the joint centre) from ring, arm and lugs of the socket, negative
    /// inside, mm.
    pub fn distance(&self, p: Vector3<f64>) -> f64 {
        // Of an infinite block whose corner is at 0.
        let block = |d: [f64; 3]| {
            let inside = d[0].max(d[1]).max(d[2]);
            let outside = d.map(|d| d.max(0.0).powi(2)).iter().sum::<f64>();
            if inside <= 0.0 {
                inside
            } else {
                outside.sqrt()
            }
        };
        let over = |half_height: f64| p.z.abs() - half_height;
        let (x, y) = (p.x.abs(), p.y.abs());
        let within = f64::NEG_INFINITY;
        let ring = p.xy().norm() - self.ring_radius;
        let arm = (y - self.arm_half_width).max(-p.x);
        let lugs = [x - self.lug_half_thickness, y - self.lug_reach];
        block([ring, within, over(self.ring_half_height)])
            .min(block([arm, within, over(self.arm_half_height)]))
            .min(block([lugs[0], lugs[1], over(self.lug_half_height)]))
    }
}

/// Least room for hubs and joints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// Extremes of the motion.
    pub reach: Reach,
    /// Smallest radius of the driver's hub, about the driver axis.
    pub driver_hub_radius: f64,
    /// Smallest radius of the follower's hub, about the follower's z axis.
    pub follower_hub_radius: f64,
    /// Ball and socket; `None` for the pin of 1R and 1R1T.
    pub ball_joint: Option<BallJoint>,
}

/// Wall of the follower's hub around its pin, mm.
const PIN_WALL: f64 = 1.5;

/// Half the height of the arm that holds the socket, mm.
const ARM: f64 = 3.0;

/// Half width of the socket lugs beyond the ring: room for a screw head, mm.
pub const LUG_LENGTH: f64 = 7.0;

/// Half the thickness of the socket lugs, mm.
pub const LUG_HALF_THICKNESS: f64 = 5.0;

impl Envelope {
    /// Dimensions for `motion` under `settings`.
    pub fn new(motion: &Motion, settings: &Settings) -> Envelope {
        let reach = Reach::of(motion);
        let (support, fit, hub) = (&settings.support, &settings.fit, &settings.hub);
        let around_pin = support.pin_radius_mm + fit.joint_play_mm + PIN_WALL;
        let follower_hub_radius = if motion.class().is_spherical() {
            hub.follower_radius_mm
        } else {
            hub.follower_radius_mm.max(around_pin)
        };
        let ball_joint = motion.class().is_spherical().then(|| {
            let gap = fit.safety_gap_mm;
            let neck_angle = ((support.neck_radius_mm + gap) / support.ball_radius_mm)
                .min(1.0)
                .asin();
            let opening = neck_angle + reach.tilt;
            let ring_half_height = support.ball_radius_mm * opening.cos();
            let (sin, cos) = reach.tilt.sin_cos();
            let ring_radius = support.ball_radius_mm + fit.joint_play_mm + support.socket_wall_mm;
            BallJoint {
                ball_radius: support.ball_radius_mm,
                neck_radius: support.neck_radius_mm,
                opening,
                ring_radius,
                ring_half_height,
                arm_half_height: ring_half_height.min(ARM),
                arm_half_width: support.ball_radius_mm,
                lug_half_thickness: LUG_HALF_THICKNESS,
                lug_reach: ring_radius + LUG_LENGTH,
                lug_half_height: 0.5 * support.screw_hole_diameter_mm
                    + settings.gear.minimum_wall_mm,
                drum_start: (ring_half_height + gap + follower_hub_radius * sin) / cos,
            }
        });
        Envelope {
            reach,
            driver_hub_radius: hub.driver_radius_mm,
            follower_hub_radius,
            ball_joint,
        }
    }
}
