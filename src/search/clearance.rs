//! Collision model of the search: teeth and ribs as chains of balls, tested through a distance field
//! of the driver's balls that the follower's balls are swept through. Coarse but quick: the proof on
//! the meshes comes later and has the last word.

use nalgebra::Vector3;

use super::swept::{Ball, Field, Fins, Sweep, Swept};
use crate::contact::Grid;
use crate::design::Gear;
use crate::envelope::{BallJoint, Envelope};
use crate::motion::{Motion, MotionState, Pose};
use crate::settings::Settings;
use crate::sub_gear::{Band, Flaw};

/// One sampled phase.
#[derive(Debug, Clone, Copy)]
struct Phase {
    phi: f64,
    /// Follower seen from the driver, and the other way round.
    follower_in_driver: Pose,
    driver_in_follower: Pose,
    /// Both gears seen from the joint centre.
    driver: Pose,
    follower: Pose,
}

/// What every band is tested against.
#[derive(Debug, Clone)]
pub struct Scene {
    envelope: Envelope,
    center_distance: f64,
    /// Phases of the turn, in an order that visits far ones first.
    phases: Vec<Phase>,
    /// Driver angle at mid contact of tooth 0, and the angle between teeth.
    first: f64,
    pitch: f64,
    bead_radius: f64,
    bead_depths: Vec<f64>,
    rib_radius: f64,
    gap: f64,
    stride: usize,
    cell: f64,
}

impl Scene {
    /// Tabulates `count` phases of the motion; `stride` thins the stations of a tooth.
    pub fn new(motion: &Motion, settings: &Settings, count: usize, stride: usize) -> Scene {
        let l = settings.gear.center_distance_mm;
        let envelope = Envelope::new(motion, settings);
        // Golden-ratio stride: any prefix of the list covers the turn evenly.
        let step = (1..count)
            .filter(|s| gcd(*s, count) == 1)
            .min_by_key(|s| (*s as f64 - 0.618 * count as f64).abs() as usize)
            .unwrap_or(1);
        let phases = (0..count)
            .map(|i| {
                let phi = ((i * step) % count) as f64 * std::f64::consts::TAU / count as f64;
                let mut driver = MotionState::driver(l, phi).pose;
                let mut follower = motion.state(phi).pose;
                let follower_in_driver = driver.inverse_mul(&follower);
                let driver_in_follower = follower.inverse_mul(&driver);
                driver.translation -= motion.joint_centre(phi);
                follower.translation -= motion.joint_centre(phi);
                Phase {
                    phi,
                    follower_in_driver,
                    driver_in_follower,
                    driver,
                    follower,
                }
            })
            .collect();
        let pitch = std::f64::consts::TAU / settings.gear.teeth as f64;
        let (t, r) = (
            settings.gear.tooth_thickness_mm,
            settings.gear.flank_radius_mm,
        );
        let bead_depths = if t > 2.0 * r + 1e-9 {
            vec![r, t - r]
        } else {
            vec![0.5 * t]
        };
        Scene {
            envelope,
            center_distance: l,
            phases,
            first: 0.5 * pitch,
            pitch,
            bead_radius: r,
            bead_depths,
            rib_radius: 0.5 * settings.spokes.thickness_mm,
            gap: settings.fit.safety_gap_mm,
            stride,
            cell: 0.02 * l,
        }
    }

    /// Room for hubs and joint.
    pub fn envelope(&self) -> &Envelope {
        &self.envelope
    }

    fn axis(&self, gear: Gear) -> Vector3<f64> {
        match gear {
            Gear::Driver => Vector3::new(-self.center_distance, 0.0, 0.0),
            Gear::Follower => Vector3::zeros(),
        }
    }

    fn hub_radius(&self, gear: Gear) -> f64 {
        match gear {
            Gear::Driver => self.envelope.driver_hub_radius,
            Gear::Follower => self.envelope.follower_hub_radius,
        }
    }

    /// Teeth and ribs of one gear of the band as balls; tips first, since they collide first.
    fn balls(&self, band: &Band, grid: &Grid, gear: Gear) -> Vec<Ball> {
        let axis = self.axis(gear);
        let hub = self.hub_radius(gear);
        let mut balls = Vec::new();
        for j in 0..band.teeth.len() {
            let tooth = j as u8;
            for &depth in &self.bead_depths {
                balls.extend(
                    band.bead_axis(grid, j, gear, depth, self.stride)
                        .into_iter()
                        .map(|centre| Ball {
                            centre,
                            radius: self.bead_radius,
                            tooth,
                        }),
                );
            }
            for bead in band.bead_axis(grid, j, gear, self.bead_depths[0], self.stride) {
                let outward = (bead - axis).component_mul(&Vector3::new(1.0, 1.0, 0.0));
                let radius = outward.norm();
                let spacing = 1.6 * self.rib_radius;
                let count = ((radius - hub) / spacing).ceil().max(0.0) as usize;
                for i in 1..=count {
                    let centre = bead - outward / radius * (i as f64 * spacing);
                    balls.push(Ball {
                        centre,
                        radius: self.rib_radius,
                        tooth,
                    });
                }
            }
        }
        balls
    }

    /// Tests the band against hubs, socket and itself and prepares it for tests against others.
    ///
    /// # Errors
    /// The first flaw found.
    pub fn prepare(&self, band: &Band, grid: &Grid) -> Result<Swept, Flaw> {
        let driver = self.balls(band, grid, Gear::Driver);
        let follower = self.balls(band, grid, Gear::Follower);
        self.clear_of_joint(&follower)?;
        self.clear_of_follower_hub(&driver)?;
        let sweep = self.sweep(&follower)?;
        let field = Field::new(&driver, self.cell, self.bead_radius + self.gap);
        if !sweep.clears(&field, self.gap, true) || !self.mates_clear(band, grid) {
            return Err(Flaw::Teeth);
        }
        let fins = [Gear::Driver, Gear::Follower].map(|gear| self.fins(band, grid, gear));
        Ok(Swept { field, sweep, fins })
    }

    fn fins(&self, band: &Band, grid: &Grid, gear: Gear) -> Fins {
        let axis = self.axis(gear);
        let middle = 0.5 * self.bead_depths.iter().sum::<f64>() / self.bead_depths.len() as f64
            + 0.5 * self.bead_depths[0];
        let beads = (0..band.teeth.len()).map(|j| {
            let bead = band.bead_axis(grid, j, gear, middle, self.stride);
            bead.iter().map(|p| p - axis).collect()
        });
        Fins::new(beads, self.center_distance)
    }

    /// Whether tooth `j` can be near the mesh at driver angle `phi`: within [`MESH_WINDOW`] of its
    /// contact.
    fn meshes(&self, j: u8, phi: f64) -> bool {
        let turn = std::f64::consts::TAU;
        let away = (phi - self.first - f64::from(j) * self.pitch).rem_euclid(turn);
        away.min(turn - away) < MESH_WINDOW
    }

    /// Driver balls against the follower's hub (an endless cylinder) and the socket ring, and within the
    /// driver's reach.
    fn clear_of_follower_hub(&self, driver: &[Ball]) -> Result<(), Flaw> {
        let (axis, reach) = (
            self.axis(Gear::Driver),
            REACH * self.center_distance - self.gap,
        );
        if driver
            .iter()
            .any(|b| (b.centre - axis).xy().norm() + b.radius > reach)
        {
            return Err(Flaw::Hub);
        }
        let hub = self.envelope.follower_hub_radius + self.gap;
        for phase in &self.phases {
            for ball in driver.iter().filter(|b| self.meshes(b.tooth, phase.phi)) {
                let q = phase.driver_in_follower.apply(ball.centre);
                let limit = hub + ball.radius;
                if q.x * q.x + q.y * q.y < limit * limit {
                    return Err(Flaw::Hub);
                }
                if let Some(joint) = &self.envelope.ball_joint
                    && joint_distance(joint, phase.driver.apply(ball.centre))
                        < ball.radius + self.gap
                {
                    return Err(Flaw::Joint);
                }
            }
        }
        Ok(())
    }

    /// Follower balls against socket ring and arm; only those nearest to the plane of the joint count.
    fn clear_of_joint(&self, follower: &[Ball]) -> Result<(), Flaw> {
        let Some(joint) = &self.envelope.ball_joint else {
            return Ok(());
        };
        let reach = joint.ring_half_height.max(joint.arm_half_height) + self.gap + self.bead_radius;
        let (sin, cos) = self.envelope.reach.tilt.sin_cos();
        let low: Vec<&Ball> = follower
            .iter()
            .filter(|b| b.centre.z.abs() * cos < reach + b.centre.x.hypot(b.centre.y) * sin)
            .collect();
        let hit = self.phases.iter().any(|phase| {
            low.iter().any(|b| {
                joint_distance(joint, phase.follower.apply(b.centre)) < b.radius + self.gap
            })
        });
        if hit { Err(Flaw::Joint) } else { Ok(()) }
    }

    /// Follower balls through the period, seen from the driver; those that come near it.
    fn sweep(&self, follower: &[Ball]) -> Result<Sweep, Flaw> {
        let axis = self.axis(Gear::Driver);
        let hub = self.envelope.driver_hub_radius + self.gap;
        let reach = REACH * self.center_distance;
        let mut sweep = Sweep::empty(self.center_distance);
        for phase in &self.phases {
            for ball in follower.iter().filter(|b| self.meshes(b.tooth, phase.phi)) {
                let q = phase.follower_in_driver.apply(ball.centre);
                let radius = (q.x - axis.x).hypot(q.y);
                if radius < hub + ball.radius {
                    return Err(Flaw::Hub);
                }
                if radius < reach + ball.radius {
                    sweep.push(q, ball);
                }
            }
        }
        sweep.trim();
        Ok(sweep)
    }

    /// Whether the beads of each tooth and its mate, as round bars along their axes, nowhere sink into
    /// each other by more than [`SINK`], at any phase near their contact.
    fn mates_clear(&self, band: &Band, grid: &Grid) -> bool {
        let radius = self.bead_depths[0];
        let limit = 2.0 * radius - SINK;
        (0..band.teeth.len()).all(|j| {
            let driver = band.bead_axis(grid, j, Gear::Driver, radius, 1);
            let follower = band.bead_axis(grid, j, Gear::Follower, radius, 1);
            let near = |phase: &&Phase| self.meshes(j as u8, phase.phi);
            self.phases.iter().filter(near).all(|phase| {
                let placed: Vec<_> = follower
                    .iter()
                    .map(|&c| phase.follower_in_driver.apply(c))
                    .collect();
                if closest(&driver, &placed) <= limit {
                    return false;
                }
                let back: Vec<_> = driver
                    .iter()
                    .map(|&c| phase.driver_in_follower.apply(c))
                    .collect();
                let reach = radius + self.rib_radius + RIB_GAP;
                beside_ribs(&driver, self.axis(Gear::Driver), &placed) > reach
                    && beside_ribs(&follower, self.axis(Gear::Follower), &back) > reach
            })
        })
    }

    /// Whether driver teeth of either band stay clear of follower teeth of the other, and the fins of
    /// both stand apart on their gears.
    pub fn compatible(&self, a: &Swept, b: &Swept) -> bool {
        let limit = self
            .bead_depths
            .last()
            .map_or(0.0, |d| d + self.bead_radius)
            + self.gap;
        a.compatible(b, self.gap, limit)
    }
}

/// Distance of `points` from the middle surface of the rib under `bead`, a wall of level lines from the
/// bead towards the gear's axis; only what lies between bead and axis counts, the bead is tested by
/// itself.
fn beside_ribs(bead: &[Vector3<f64>], axis: Vector3<f64>, points: &[Vector3<f64>]) -> f64 {
    let mut nearest = f64::INFINITY;
    for pair in bead.windows(2) {
        let (a, b) = (pair[0] - axis, pair[1] - axis);
        let (low, high) = (a.z.min(b.z), a.z.max(b.z));
        for point in points {
            let p = point - axis;
            if p.z < low || p.z > high || high - low < 1e-9 {
                continue;
            }
            let f = (p.z - a.z) / (b.z - a.z);
            let edge = a.lerp(&b, f);
            let (r, edge_r) = (p.xy().norm(), edge.xy().norm());
            if r >= edge_r {
                continue;
            }
            // Across the wall: level distance from the line, less where the wall leans.
            let across = (edge.x * p.y - edge.y * p.x) / edge_r;
            let turn = (a.x * b.y - a.y * b.x) / (a.xy().norm() * b.xy().norm());
            let lean = turn * r / (b.z - a.z);
            nearest = nearest.min(across.abs() / lean.hypot(1.0));
        }
    }
    nearest
}

/// Distance of two chains of points taken as polylines: the nearest pair of points, refined on the
/// segments around it.
fn closest(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let mut nearest = (f64::INFINITY, 0, 0);
    for (i, p) in a.iter().enumerate() {
        for (k, q) in b.iter().enumerate() {
            let d = (p - q).norm_squared();
            if d < nearest.0 {
                nearest = (d, i, k);
            }
        }
    }
    let (mut best, i, k) = nearest;
    for s in i.saturating_sub(1)..(i + 1).min(a.len() - 1) {
        for t in k.saturating_sub(1)..(k + 1).min(b.len() - 1) {
            best = best.min(segments([a[s], a[s + 1]], [b[t], b[t + 1]]));
        }
    }
    best.sqrt()
}

/// Squared distance of two segments, by alternating projection from their middles: exact enough for
/// nearly parallel pieces of a bead, and never below the true distance.
fn segments([a0, a1]: [Vector3<f64>; 2], [b0, b1]: [Vector3<f64>; 2]) -> f64 {
    let project = |p: Vector3<f64>, o: Vector3<f64>, e: Vector3<f64>| {
        let d = e - o;
        o + d * ((p - o).dot(&d) / d.norm_squared()).clamp(0.0, 1.0)
    };
    let mut p = (a0 + a1) * 0.5;
    let mut q = project(p, b0, b1);
    for _ in 0..6 {
        p = project(q, a0, a1);
        q = project(p, b0, b1);
    }
    (p - q).norm_squared()
}

/// Depth to which beads may seem to sink into each other between sampled phases, mm: a fraction of
/// the default clearance.
const SINK: f64 = 0.01;

/// Least gap between a bead and its mate's rib, mm.
const RIB_GAP: f64 = 0.06;

/// Driver teeth end within this share of L from their axis; what of the follower stays outside needs
/// no test.
const REACH: f64 = 0.84;

/// Teeth further than this from their contact are behind their gear, rad.
const MESH_WINDOW: f64 = 1.3;

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Distance of a point (relative to the joint centre) from socket ring and arm.
fn joint_distance(joint: &BallJoint, p: Vector3<f64>) -> f64 {
    let outside = |dx: f64, dz: f64| dx.max(0.0).hypot(dz.max(0.0)) + dx.max(dz).min(0.0);
    let ring = outside(
        p.x.hypot(p.y) - joint.ring_radius,
        p.z.abs() - joint.ring_half_height,
    );
    let across = (p.y.abs() - joint.arm_half_width).max(-p.x);
    let arm = outside(across, p.z.abs() - joint.arm_half_height);
    ring.min(arm)
}
