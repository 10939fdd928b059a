//! What the teeth and the motion leave room for: the dimensions of hubs, joints and frame, found by
//! carrying sample points of every moving part through the whole period.

use nalgebra::Vector3;

use super::sweep;
use super::{rib, section};
use crate::design::{Design, Gear};
use crate::envelope::Envelope;
use crate::motion::{Class, Drive, Motion, Pose};
use crate::settings::Settings;

/// Phases at which moving parts are sampled.
const PHASES: usize = 360;
/// Axial distance between the outermost tooth and the end of its drum, mm.
const DRUM_MARGIN: f64 = 0.5;
/// Free height between the base plate and whatever moves above it, mm.
const FLOOR_GAP: f64 = 1.0;
/// Corners of the section polygon used as sample points.
const OUTLINE_SEGMENTS: u32 = 12;
/// Wall wanted around the bore of a drum on a pin, mm.
const BORE_WALL: f64 = 1.5;
/// Depth to which the mount's flange sinks into the drum below, mm: faces in one plane are what booleans
/// stumble over.
const MOUNT_SINK: f64 = 0.1;
/// Smallest mount that still has room for its screws, mm.
const SMALLEST_MOUNT: f64 = 5.0;
/// Points on the rim of a drum or flange.
const RIM_POINTS: u32 = 48;
/// Rims along the side of a drum or flange.
const RIM_LEVELS: u32 = 12;
/// Hub radii grow to at most these shares of L (9.5 and 8 mm at L = 25), the driver's to more where it has
/// more teeth.
const DRIVER_HUB_CAP: f64 = 0.38;
const FOLLOWER_HUB_CAP: f64 = 0.32;

/// Dimensions that follow from teeth and motion, mm; frames as the recipe's bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Measures {
    /// Least room for hubs and joints.
    pub envelope: Envelope,
    /// Driver drum radius: smallest, and the one that the follower leaves free.
    pub driver_hub: (f64, f64),
    /// Follower drum radius: smallest, and the one that the driver leaves free.
    pub follower_hub: (f64, f64),
    /// Upper face of the base plate, Σ.
    pub base_top: f64,
    /// Ends of the driver's drum, driver frame.
    pub driver_top: f64,
    /// How much further the driver's drum (and the bridge) may rise without meeting the follower.
    pub driver_top_free: f64,
    /// Radius that the bridge's eye may have without meeting the follower, mm, up to
    /// [`THICKEST_BRIDGE`]; the eye's own radius where the follower comes close.
    pub eye_free: f64,
    /// Lower and upper end of the follower's drums, follower frame.
    pub follower_ends: (f64, f64),
    /// Whether the follower has teeth above and below O.
    pub sides: (bool, bool),
    /// Lower face and radius of the end-effector mount.
    pub mount_bottom: f64,
    /// Radius of the mount's flange.
    pub mount_radius: f64,
    /// Largest distance of a driver tooth from the driver axis.
    pub driver_reach: f64,
    /// x behind which the follower's tower or guide may stand, Σ.
    pub follower_reach: f64,
    /// Half height of the socket's screw lugs.
    pub lug_half_height: f64,
}

/// Half height of the slider's carriage as a share of L.
pub const CARRIAGE_SHARE: f64 = 0.36;

/// Radius of the bearing eye in the bridge.
pub fn eye_radius(design: &Design) -> f64 {
    design.settings.hub.journal_radius_mm + design.settings.fit.joint_play_mm + EYE_WALL
}

/// Radius of the follower's pin: the setting, or less where the smallest drum would be left without
/// a wall around its bore.
pub fn pin_radius(settings: &Settings) -> f64 {
    let room = settings.hub.follower_radius_mm
        - settings.fit.joint_play_mm
        - settings.gear.minimum_wall_mm;
    settings.support.pin_radius_mm.min(room)
}

/// Wall around the upper journal, mm.
pub const EYE_WALL: f64 = 3.0;
/// Thickness of the bridge, mm.
pub const BRIDGE_THICKNESS: f64 = 7.0;
/// Thickness that the bridge may have where the follower leaves room, for the seat of a 608, mm.
pub const THICKEST_BRIDGE: f64 = 10.0;
/// The bridge's eye grows to at most this share of L (15 mm at L = 25).
const EYE_CAP: f64 = 0.6;
/// Thickness of the follower stand's foot, mm.
pub const FOOT_THICKNESS: f64 = 5.0;

/// Follower poses over the period and the points carried along.
struct Sampler<'a> {
    drive: Drive,
    gap: f64,
    states: Vec<(Pose, Pose, f64)>,
    design: &'a Design,
}

impl<'a> Sampler<'a> {
    fn new(design: &'a Design, motion: &Motion) -> Sampler<'a> {
        let drive = design.settings.gear.drive();
        let states = motion
            .cycle()
            .phases(PHASES)
            .map(|phi| {
                (
                    drive.state(phi).pose,
                    motion.state(phi).pose,
                    motion.joint_centre(phi).z,
                )
            })
            .collect();
        Sampler {
            drive,
            gap: design.settings.fit.safety_gap_mm,
            states,
            design,
        }
    }

    /// Section and rib corners along every tooth of a gear, in its frame.
    fn tooth_points(&self, gear: Gear) -> Vec<Vector3<f64>> {
        let axis = sweep::axis_point(gear, self.drive.center_distance());
        let section = &self.design.section;
        let outline = section::polygon(section, OUTLINE_SEGMENTS);
        let mut points = Vec::new();
        for tooth in sweep::standing(self.design, gear, sweep::MAX_STATIONS) {
            let frames = &tooth.frames;
            for (i, frame) in frames.iter().enumerate() {
                if i % 3 == 0 || i + 1 == frames.len() {
                    points.extend(outline.iter().map(|&c| frame.place(c)));
                    let [_, inner, across] = rib::line(frame, section, axis, 1.0);
                    let [left, right] = tooth.flare.map(|flare| 0.5 * section.rib + flare);
                    points.extend([inner - right * across, inner + left * across]);
                }
            }
        }
        points
    }

    /// Follower points carried through the period, in Σ.
    fn carried<'b>(
        &'b self,
        points: &'b [Vector3<f64>],
    ) -> impl Iterator<Item = Vector3<f64>> + 'b {
        self.states
            .iter()
            .flat_map(move |(_, pose, _)| points.iter().map(move |&q| pose.apply(q)))
    }

    fn axis_distance(&self, p: Vector3<f64>) -> f64 {
        (p.x + self.drive.center_distance()).hypot(p.y)
    }
}

fn rim(radius: f64, z: f64) -> impl Iterator<Item = Vector3<f64>> {
    (0..RIM_POINTS).map(move |i| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(RIM_POINTS);
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
    })
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |acc, v| match acc {
        None => Some((v, v)),
        Some((lo, hi)) => Some((lo.min(v), hi.max(v))),
    })
}

impl Measures {
    /// Measures the teeth and the motion of `design`. Where the teeth leave less than the smallest
    /// hub or flange free, the smallest one is taken: the overlap is the proof's to report.
    pub fn of(design: &Design, motion: &Motion) -> Measures {
        let sampler = Sampler::new(design, motion);
        let (settings, class, gap) = (&design.settings, design.class, sampler.gap);
        let envelope = Envelope::new(motion, settings);
        let joint = envelope.ball_joint;
        let driver_teeth = sampler.tooth_points(Gear::Driver);
        let follower_teeth = sampler.tooth_points(Gear::Follower);

        let driver_z = range(driver_teeth.iter().map(|p| p.z)).unwrap_or((0.0, 0.0));
        let driver_reach = driver_teeth
            .iter()
            .map(|&p| sampler.axis_distance(p))
            .fold(envelope.driver_hub_radius, f64::max);

        // Drums of the follower: along its teeth, on either side of a ball.
        let start = joint.map_or(0.0, |j| j.drum_start);
        let follower_z = range(follower_teeth.iter().map(|p| p.z)).unwrap_or((0.0, 0.0));
        let sides = (follower_z.1 > 0.0, follower_z.0 < 0.0);
        let shortest = start + 3.0;
        let follower_ends = match joint {
            None => (follower_z.0 - DRUM_MARGIN, follower_z.1 + DRUM_MARGIN),
            Some(_) => (
                (follower_z.0 - DRUM_MARGIN).min(-shortest),
                (follower_z.1 + DRUM_MARGIN).max(shortest),
            ),
        };
        let drum_rims = |radius: f64| -> Vec<Vector3<f64>> {
            let mut heights = vec![follower_ends.1];
            match joint {
                Some(_) if sides.1 => heights.extend([start, -start, follower_ends.0]),
                Some(_) => heights.push(start),
                None => heights.push(follower_ends.0),
            }
            heights.into_iter().flat_map(|z| rim(radius, z)).collect()
        };

        let free = sampler
            .states
            .iter()
            .flat_map(|(driver, follower, _)| {
                let relative = follower.inverse_mul(driver);
                driver_teeth.iter().map(move |&p| relative.apply(p))
            })
            .filter(|q| q.z > follower_ends.0 - gap && q.z < follower_ends.1 + gap)
            .map(|q| q.xy().norm() - gap)
            .fold(FOLLOWER_HUB_CAP * sampler.drive.center_distance(), f64::min);
        let least = envelope.follower_hub_radius;
        let mut grown = free.max(least);
        let meets_driver = |radius: f64| {
            sampler
                .carried(&drum_rims(radius))
                .any(|p| sampler.axis_distance(p) < envelope.driver_hub_radius + gap)
        };
        while grown > least && meets_driver(grown) {
            grown = (grown - 0.25).max(least);
        }
        // A drum on a pin needs a wall around its bore, whatever the settings say.
        let bore = pin_radius(settings) + settings.fit.joint_play_mm;
        let follower_hub = match joint {
            None => (least.max(bore + BORE_WALL).min(grown), grown),
            Some(_) => (least, grown),
        };

        // Everything of the follower but the mount, through the period.
        let mut moving = follower_teeth;
        moving.extend(drum_rims(grown));
        let cloud: Vec<Vector3<f64>> = sampler.carried(&moving).collect();

        let play = settings.fit.joint_play_mm;
        let follower_floor = match class {
            Class::R1 => follower_ends.0 - play,
            _ => cloud.iter().map(|p| p.z).fold(f64::INFINITY, f64::min) - FLOOR_GAP,
        };
        let mut base_top = follower_floor.min(driver_z.0 - DRUM_MARGIN - play);
        let lift = envelope.reach.lift;
        let carriage = CARRIAGE_SHARE * sampler.drive.center_distance();
        if let Some(joint) = &joint {
            let hanging = match class {
                Class::R3T1 => carriage - lift.0,
                _ => joint.ball_radius.max(joint.ring_half_height),
            };
            base_top = base_top.min(-hanging - FOOT_THICKNESS - gap);
        }

        // Bridge: above the driver and above whatever of the follower passes over the driver axis.
        let eye = eye_radius(design);
        let over_axis: Vec<f64> = cloud
            .iter()
            .filter(|&&p| sampler.axis_distance(p) < eye + gap)
            .map(|p| p.z)
            .collect();
        let driver_top = over_axis
            .iter()
            .map(|z| z + gap)
            .fold(driver_z.1 + DRUM_MARGIN, f64::max);
        let driver_top_free = if over_axis.is_empty() { 10.0 } else { 0.0 };

        let ring = joint.map_or(0.0, |j| j.ring_radius);
        let driver_free = cloud
            .iter()
            .map(|&p| sampler.axis_distance(p) - gap)
            .fold(
                DRIVER_HUB_CAP
                    * (2.0 - sampler.drive.follower_share(motion.turning()))
                    * sampler.drive.center_distance(),
                f64::min,
            )
            .min(sampler.drive.center_distance() - ring - gap);
        let driver_hub = (
            envelope.driver_hub_radius,
            driver_free.max(envelope.driver_hub_radius),
        );

        // Mount: on top of the drum, or higher or smaller until it is clear of driver and bridge.
        let obstacles = Obstacles {
            teeth: driver_teeth
                .iter()
                .map(|&p| (p.z, sampler.axis_distance(p)))
                .collect(),
            drum: (driver_hub.1, driver_top),
            bridge: (eye, driver_top + BRIDGE_THICKNESS + play + gap),
            shaft: settings.hub.journal_radius_mm,
        };
        let (mount_bottom, mount_radius) = obstacles.mount(
            &sampler,
            follower_ends.1 - MOUNT_SINK,
            settings.hub.mount_thickness_mm,
        );

        // Eye of the bridge: drums and mount are sampled along their sides, too.
        let mut beside: Vec<Vector3<f64>> = Vec::new();
        for i in 0..=RIM_LEVELS {
            let u = f64::from(i) / f64::from(RIM_LEVELS);
            let drum = follower_ends.1 * u + (1.0 - u) * start.max(follower_ends.0);
            beside.extend(rim(grown, drum));
            beside.extend(rim(
                mount_radius,
                mount_bottom + u * settings.hub.mount_thickness_mm,
            ));
        }
        let levels = (driver_top - gap)..=(driver_top + play + THICKEST_BRIDGE + gap);
        let eye_free = sampler
            .carried(&beside)
            .chain(cloud.iter().copied())
            .filter(|p| levels.contains(&p.z))
            .map(|p| sampler.axis_distance(p) - gap)
            .fold(EYE_CAP * sampler.drive.center_distance(), f64::min)
            .max(eye);

        // Tower or guide of the follower's joint.
        let tower_top = match class {
            Class::R3T1 => carriage + lift.1 + 2.0,
            _ => joint.map_or(0.0, |j| j.arm_half_height),
        };
        let half_width = 12.0 * sampler.drive.center_distance() / 25.0;
        let follower_reach = cloud
            .iter()
            .filter(|p| p.z < tower_top + gap && p.y.abs() < half_width + gap)
            .map(|p| p.x)
            .fold(ring + 2.0, f64::max)
            + gap
            + 0.3;

        let lug_half_height = joint.map_or(0.0, |j| {
            let centres = sampler
                .states
                .iter()
                .flat_map(|s| std::iter::repeat_n(s.2, moving.len()));
            cloud
                .iter()
                .zip(centres)
                .filter(|(p, _)| {
                    p.x.abs() < j.lug_half_thickness + gap && p.y.abs() < j.lug_reach + gap
                })
                .map(|(p, centre)| (p.z - centre).abs() - gap)
                .fold(j.arm_half_height, f64::min)
                .max(j.lug_half_height)
        });

        Measures {
            envelope,
            driver_hub,
            follower_hub,
            base_top,
            driver_top,
            driver_top_free,
            eye_free,
            follower_ends,
            sides,
            mount_bottom,
            mount_radius,
            driver_reach,
            follower_reach,
            lug_half_height,
        }
    }
}

/// What stands around the driver axis: all of it round, so that heights and radii say everything.
struct Obstacles {
    /// (height, distance from the driver axis) of the driver's tooth points.
    teeth: Vec<(f64, f64)>,
    /// Radius and top of the drum.
    drum: (f64, f64),
    /// Radius of the bridge's eye, which stands on the drum, and its top with the gap above.
    bridge: (f64, f64),
    /// Radius of the shaft above.
    shaft: f64,
}

impl Obstacles {
    /// Largest radius of anything around the driver axis at height `z`.
    fn radius(&self, z: f64) -> f64 {
        let solid = if z > self.bridge.1 {
            self.shaft
        } else if z > self.drum.1 {
            self.bridge.0
        } else {
            self.drum.0
        };
        self.teeth
            .iter()
            .filter(|(height, _)| (height - z).abs() < 1.0)
            .fold(solid, |radius, tooth| radius.max(tooth.1))
    }

    /// Lowest place at or above `bottom` where the full flange fits, or the place where the largest
    /// flange fits: its lower face and radius in the follower frame.
    fn mount(&self, sampler: &Sampler, bottom: f64, thickness: f64) -> (f64, f64) {
        const STEP: f64 = 0.5;
        let floor = bottom - 40.0;
        let table: Vec<f64> = (0..400)
            .map(|i| self.radius(floor + STEP * f64::from(i)))
            .collect();
        let at = |z: f64| {
            let index = ((z - floor) / STEP).clamp(0.0, 399.0);
            table[index.floor() as usize].max(table[index.ceil() as usize])
        };
        let wanted = sampler.design.settings.hub.mount_radius_mm;
        let smallest = sampler
            .design
            .settings
            .hub
            .follower_radius_mm
            .max(SMALLEST_MOUNT);
        let least = wanted.min(smallest);
        let clear = |radius: f64, z: f64| {
            let points: Vec<Vector3<f64>> = [z, z + 0.5 * thickness, z + thickness]
                .into_iter()
                .flat_map(|z| rim(radius, z))
                .collect();
            sampler
                .carried(&points)
                .all(|p| sampler.axis_distance(p) >= at(p.z) + sampler.gap)
        };
        let mut radius = wanted;
        while radius > least {
            for step in 0..24 {
                let z = bottom + STEP * f64::from(step);
                if clear(radius, z) {
                    return (z, radius);
                }
            }
            radius -= STEP;
        }
        (bottom, least)
    }
}
