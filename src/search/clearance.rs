//! Collision model of the search: teeth and ribs as chains of balls, tested through a distance field
//! of the driver's balls that the follower's balls are swept through. Coarse but quick: the proof on
//! the meshes comes later and has the last word.

use nalgebra::Vector3;

use super::field::{Radii, ToothBalls, ToothField};
use super::mates::{Bead, Mates};
use super::swept::{Fins, Run, Sweep, Swept};
use crate::contact::Grid;
use crate::design::Gear;
use crate::envelope::Envelope;
use crate::motion::{Drive, Motion, Pose};
use crate::settings::{FlankRadius, Settings};
use crate::solid::sweep;
use crate::sub_gear::{Band, Flaw};

/// One sampled phase.
#[derive(Debug, Clone)]
pub(super) struct Phase {
    /// Teeth of driver and follower that can be near the mesh: within [`MESH_WINDOW`] of their contact.
    pub meshing: [Vec<bool>; 2],
    /// How far each tooth pair is before or after its contact, rad; 0 during it.
    pub apart: Vec<f64>,
    /// Number on the driver of the tooth that each of the follower's meets.
    pub mates: Vec<usize>,
    /// Follower seen from the driver, and the other way round.
    pub follower_in_driver: Pose,
    pub driver_in_follower: Pose,
    /// Both gears seen from the joint centre.
    pub driver: Pose,
    pub follower: Pose,
}

/// What every band is tested against.
#[derive(Debug, Clone)]
pub struct Scene {
    envelope: Envelope,
    drive: Drive,
    /// Tooth pairs of a band.
    pairs: usize,
    /// Whether the first tooth follows the last.
    wraps: bool,
    /// Mean speed at which the follower turns against the driver, per phase.
    turning: f64,
    /// Phases of the turn, in an order that visits far ones first.
    phases: Vec<Phase>,
    radii: Radii,
    bead_depths: Vec<f64>,
    gap: f64,
    stride: usize,
    cell: f64,
    /// For the corners of flanks that are made flat, mm.
    room: f64,
}

impl Scene {
    /// Tabulates `count` phases of the motion; `stride` thins the stations of a tooth.
    pub fn new(motion: &Motion, settings: &Settings, count: usize, stride: usize) -> Scene {
        let drive = settings.gear.drive();
        let l = drive.center_distance();
        let envelope = Envelope::new(motion, settings);
        // Golden-ratio stride: any prefix of the list covers the turn evenly.
        let step = (1..count)
            .filter(|s| gcd(*s, count) == 1)
            .min_by_key(|s| (*s as f64 - 0.618 * count as f64).abs() as usize)
            .unwrap_or(1);
        let cycle = motion.cycle();
        let teeth = cycle.pairs(settings.gear.tooth_pairs());
        let turning = motion.turning();
        // Tooth j is in mid contact in the middle of its share of the cycle.
        let pitch = cycle.length() / teeth as f64;
        let middle = |j: usize| cycle.start() + (j as f64 + 0.5) * pitch;
        let away = |phi: f64, j: usize, turns: usize| cycle.away(phi, middle(j), turns);
        let half = 0.5 * settings.gear.contact_ratio * pitch;
        let all: Vec<f64> = cycle.phases(count).collect();
        let phases = (0..count)
            .map(|i| {
                let phi = all[(i * step) % count];
                let mut driver = drive.state(phi).pose;
                let mut follower = motion.state(phi).pose;
                let follower_in_driver = driver.inverse_mul(&follower);
                let driver_in_follower = follower.inverse_mul(&driver);
                driver.translation -= motion.joint_centre(phi);
                follower.translation -= motion.joint_centre(phi);
                Phase {
                    meshing: [
                        (0..teeth * drive.copies())
                            .map(|j| drive.rate() * away(phi, j, drive.copies()) < MESH_WINDOW)
                            .collect(),
                        (0..teeth)
                            .map(|j| turning * away(phi, j, 1) < MESH_WINDOW)
                            .collect(),
                    ],
                    apart: (0..teeth)
                        .map(|j| (away(phi, j, 1) - half).max(0.0))
                        .collect(),
                    mates: (0..teeth)
                        .map(|j| j + teeth * drive.nearest(phi, middle(j)))
                        .collect(),
                    follower_in_driver,
                    driver_in_follower,
                    driver,
                    follower,
                }
            })
            .collect();
        let (t, r) = (
            settings.gear.tooth_thickness_mm,
            settings.gear.bead_radius(),
        );
        let bead_depths = if t > 2.0 * r + 1e-9 {
            vec![r, t - r]
        } else {
            vec![0.5 * t]
        };
        Scene {
            envelope,
            drive,
            pairs: teeth,
            wraps: cycle.wraps(),
            turning,
            phases,
            radii: Radii {
                bead: r,
                rib: 0.5 * settings.spokes.thickness_mm,
            },
            bead_depths,
            gap: settings.fit.safety_gap_mm,
            stride,
            cell: 0.02 * l,
            room: match settings.gear.flank_radius_mm {
                FlankRadius::Auto(_) => ROOM * l / 25.0,
                FlankRadius::Fixed(_) => 0.0,
            },
        }
    }

    /// Room for hubs and joint.
    pub fn envelope(&self) -> &Envelope {
        &self.envelope
    }

    /// Phases of the turn, far ones first.
    pub(super) fn phases(&self) -> &[Phase] {
        &self.phases
    }

    /// Radii of beads and ribs, mm.
    pub(super) fn radii(&self) -> Radii {
        self.radii
    }

    /// Depths of the bead axes behind the contact, mm: one where the section is round.
    pub(super) fn bead_depths(&self) -> &[f64] {
        &self.bead_depths
    }

    /// Gap wanted between parts that must never touch, mm.
    pub(super) fn gap(&self) -> f64 {
        self.gap
    }

    /// Room that a tooth leaves to others of its band for flanks made flat, mm; to its mate as much as it is
    /// away from their contact, `apart` (rad).
    pub(super) fn room(&self, apart: f64) -> f64 {
        self.room * (apart / PASSED).min(1.0).powi(2)
    }

    /// Every so many stations of a tooth are looked at.
    pub(super) fn stride(&self) -> usize {
        self.stride
    }

    pub(super) fn center_distance(&self) -> f64 {
        self.drive.center_distance()
    }

    /// Tooth pairs of a band.
    pub(super) fn pairs(&self) -> usize {
        self.pairs
    }

    /// Whether the first tooth of a band follows the last.
    pub(super) fn wraps(&self) -> bool {
        self.wraps
    }

    /// How often each tooth of a band stands on `gear`.
    pub(super) fn copies(&self, gear: Gear) -> usize {
        sweep::copies(self.drive, gear)
    }

    /// Where tooth number `number` on the driver stands, seen from the one that it is a copy of.
    pub(super) fn copy(&self, number: usize) -> Pose {
        self.drive.copy(number / self.pairs)
    }

    /// Follower seen from the driver as tooth pair `j` meets there, and the other way round.
    pub(super) fn mate_poses(&self, phase: &Phase, j: usize) -> [Pose; 2] {
        let poses = [phase.follower_in_driver, phase.driver_in_follower];
        if phase.mates[j] < self.pairs {
            return poses;
        }
        let copy = self.copy(phase.mates[j]);
        [copy.inverse_mul(&poses[0]), poses[1].mul(&copy)]
    }

    /// Distance of balls along a rib, mm.
    pub(super) fn rib_spacing(&self) -> f64 {
        1.6 * self.radii.rib
    }

    /// Distance wanted between the middles of fins of two bands, mm.
    pub(super) fn fins_limit(&self) -> f64 {
        self.bead_depths.last().map_or(0.0, |d| d + self.radii.bead) + self.gap
    }

    /// Radius on which fins are unrolled, mm.
    pub(super) fn fin_radius(&self, gear: Gear) -> f64 {
        let share = match gear {
            Gear::Driver => 2.0 - self.drive.follower_share(self.turning),
            Gear::Follower => self.drive.follower_share(self.turning),
        };
        FIN_RADIUS * share * self.center_distance()
    }

    /// Of beads along these axes on driver and follower.
    pub(super) fn mate(&self, [driver, follower]: [Vec<Vector3<f64>>; 2]) -> Mates {
        Mates {
            driver: Bead::new(driver, self.axis(Gear::Driver)),
            follower: Bead::new(follower, self.axis(Gear::Follower)),
            radius: self.bead_depths[0],
            rib_radius: self.radii.rib,
        }
    }

    pub(super) fn axis(&self, gear: Gear) -> Vector3<f64> {
        match gear {
            Gear::Driver => self.drive.axis_point(),
            Gear::Follower => Vector3::zeros(),
        }
    }

    pub(super) fn hub_radius(&self, gear: Gear) -> f64 {
        match gear {
            Gear::Driver => self.envelope.driver_hub_radius,
            Gear::Follower => self.envelope.follower_hub_radius,
        }
    }

    /// Teeth and ribs of one gear of the band as balls.
    fn balls(&self, band: &Band, grid: &Grid, gear: Gear) -> Vec<ToothBalls> {
        let axis = self.axis(gear);
        let hub = self.hub_radius(gear);
        let tooth = |j: usize| {
            let bead = |depth: f64| band.bead_axis(grid, j, gear, depth, self.stride);
            let mut balls = ToothBalls::default();
            for (i, &depth) in self.bead_depths.iter().enumerate() {
                let bead = bead(depth);
                if i == 0 {
                    balls.ribs = self.rib(&bead, axis, hub);
                }
                balls.beads.extend(bead);
            }
            balls
        };
        let own: Vec<ToothBalls> = (0..band.teeth.len()).map(tooth).collect();
        let mut all = own.clone();
        for copy in 1..self.copies(gear) {
            let pose = self.drive.copy(copy);
            all.extend(own.iter().map(|tooth| tooth.moved(&pose)));
        }
        all
    }

    /// Rib from a bead down to the hub.
    fn rib(&self, bead: &[Vector3<f64>], axis: Vector3<f64>, hub: f64) -> Vec<Vector3<f64>> {
        let spacing = self.rib_spacing();
        let mut rib = Vec::with_capacity(8 * bead.len());
        for bead in bead {
            let outward = (bead - axis).component_mul(&Vector3::new(1.0, 1.0, 0.0));
            let radius = outward.norm();
            let count = ((radius - hub) / spacing).ceil().max(0.0) as usize;
            let step = outward * (spacing / radius);
            rib.extend((1..=count).map(|i| bead - step * i as f64));
        }
        rib
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
        let (sweep, runs) = self.sweep(&follower)?;
        if !self.mates_clear(band, grid) {
            return Err(Flaw::Teeth);
        }
        let need = self.radii.bead + self.gap;
        let field = ToothField::new(&driver, self.radii, (self.cell, need));
        if !sweep.clears_own(&field, &runs, self.gap) {
            return Err(Flaw::Teeth);
        }
        Ok(Swept {
            field: field.into_field(),
            sweep,
            fins: [Gear::Driver, Gear::Follower].map(|gear| self.fins(band, grid, gear)),
        })
    }

    /// Whether no tooth sinks into its mate or the mate's rib, see [`Mates`].
    fn mates_clear(&self, band: &Band, grid: &Grid) -> bool {
        let radius = self.bead_depths[0];
        (0..band.teeth.len()).all(|j| {
            let gears = [Gear::Driver, Gear::Follower];
            let mates = self.mate(gears.map(|gear| band.bead_axis(grid, j, gear, radius, 1)));
            let near = |phase: &&Phase| phase.meshing[Gear::Follower as usize][j];
            self.phases.iter().filter(near).all(|phase| {
                let [follower, driver] = self.mate_poses(phase, j);
                mates.clear(&follower, &driver)
            })
        })
    }

    fn fins(&self, band: &Band, grid: &Grid, gear: Gear) -> Fins {
        let axis = self.axis(gear);
        let middle = 0.5 * self.bead_depths.iter().sum::<f64>() / self.bead_depths.len() as f64
            + 0.5 * self.bead_depths[0];
        let beads = (0..band.teeth.len()).map(|j| {
            let bead = band.bead_axis(grid, j, gear, middle, self.stride);
            bead.iter().map(|p| p - axis).collect()
        });
        Fins::new(beads, self.fin_radius(gear), self.copies(gear))
    }

    /// Driver balls against the follower's hub (an endless cylinder) and the socket ring, and within the
    /// driver's reach.
    fn clear_of_follower_hub(&self, driver: &[ToothBalls]) -> Result<(), Flaw> {
        let (axis, reach) = (
            self.axis(Gear::Driver),
            REACH * self.center_distance() - self.gap,
        );
        let outside = |balls: &[Vector3<f64>], radius: f64| {
            let limit = (reach - radius).max(0.0).powi(2);
            balls.iter().any(|c| (c - axis).xy().norm_squared() > limit)
        };
        if driver.iter().any(|tooth| {
            outside(&tooth.beads, self.radii.bead) || outside(&tooth.ribs, self.radii.rib)
        }) {
            return Err(Flaw::Hub);
        }
        let hub = self.envelope.follower_hub_radius + self.gap;
        for phase in &self.phases {
            for (centre, radius) in self.meshing(driver, phase) {
                let q = phase.driver_in_follower.apply(centre);
                if q.xy().norm_squared() < (hub + radius).powi(2) {
                    return Err(Flaw::Hub);
                }
                if let Some(joint) = &self.envelope.ball_joint
                    && joint.is_near(phase.driver.apply(centre), radius + self.gap)
                {
                    return Err(Flaw::Joint);
                }
            }
        }
        Ok(())
    }

    /// Balls, centre and radius, of the driver's teeth that can be near the mesh.
    fn meshing<'a>(
        &self,
        teeth: &'a [ToothBalls],
        phase: &'a Phase,
    ) -> impl Iterator<Item = (Vector3<f64>, f64)> + use<'a> {
        let Radii { bead, rib } = self.radii;
        let meshing = &phase.meshing[Gear::Driver as usize];
        let near = teeth.iter().zip(meshing).filter(|(_, near)| **near);
        near.flat_map(move |(tooth, _)| {
            let beads = tooth.beads.iter().map(move |&c| (c, bead));
            beads.chain(tooth.ribs.iter().map(move |&c| (c, rib)))
        })
    }

    /// Follower balls against socket ring and arm; only those nearest to the plane of the joint count.
    fn clear_of_joint(&self, follower: &[ToothBalls]) -> Result<(), Flaw> {
        let Some(joint) = &self.envelope.ball_joint else {
            return Ok(());
        };
        let reach = joint.half_height() + self.gap + self.radii.bead;
        let (sin, cos) = self.envelope.reach.tilt.sin_cos();
        let low = |c: &&Vector3<f64>| c.z.abs() * cos < reach + c.xy().norm() * sin;
        let of = |get: fn(&ToothBalls) -> &Vec<Vector3<f64>>| -> Vec<Vector3<f64>> {
            let all = follower.iter().flat_map(get);
            all.filter(low).copied().collect()
        };
        let lists = [
            (of(|t| &t.beads), self.radii.bead),
            (of(|t| &t.ribs), self.radii.rib),
        ];
        let hit = self.phases.iter().any(|phase| {
            lists.iter().any(|(low, radius)| {
                low.iter()
                    .any(|&c| joint.is_near(phase.follower.apply(c), radius + self.gap))
            })
        });
        if hit { Err(Flaw::Joint) } else { Ok(()) }
    }

    /// Follower balls through the period, seen from the driver; those that come near it.
    fn sweep(&self, follower: &[ToothBalls]) -> Result<(Sweep, Vec<Run>), Flaw> {
        let axis = self.axis(Gear::Driver);
        let hub = self.envelope.driver_hub_radius + self.gap;
        let reach = REACH * self.center_distance();
        let mut sweep = Sweep::empty(self.center_distance(), self.radii);
        let mut runs = Vec::new();
        for phase in &self.phases {
            for (j, tooth) in follower.iter().enumerate() {
                if !phase.meshing[Gear::Follower as usize][j] {
                    continue;
                }
                for (balls, radius, push) in [
                    (
                        &tooth.beads,
                        self.radii.bead,
                        Sweep::push_bead as fn(&mut Sweep, _),
                    ),
                    (&tooth.ribs, self.radii.rib, Sweep::push_rib),
                ] {
                    let (least, most) = ((hub + radius).powi(2), (reach + radius).powi(2));
                    for &centre in balls {
                        let q = phase.follower_in_driver.apply(centre);
                        let squared = (q.x - axis.x).powi(2) + q.y * q.y;
                        if squared < least {
                            return Err(Flaw::Hub);
                        }
                        if squared < most {
                            push(&mut sweep, q);
                        }
                    }
                }
                runs.push(sweep.run(phase.mates[j] as u8));
            }
        }
        sweep.trim();
        Ok((sweep, runs))
    }

    /// Whether driver teeth of either band stay clear of follower teeth of the other, and the fins of
    /// both stand apart on their gears.
    pub fn compatible(&self, a: &Swept, b: &Swept) -> bool {
        a.compatible(b, self.gap, self.fins_limit())
    }
}

/// Driver teeth end within this share of L from their axis; what of the follower stays outside needs
/// no test.
pub(super) const REACH: f64 = 0.84;

/// Radius on which fins are unrolled, as a share of the centre distance, where both gears have as many
/// teeth: half way up a fin.
const FIN_RADIUS: f64 = 0.36;

/// Corners of flat flanks stand out so far over a round bead, mm at L = 25.
const ROOM: f64 = 0.2;

/// So far from their contact a tooth and its mate have passed each other, rad.
const PASSED: f64 = 0.4;

/// Teeth further than this from their contact are behind their gear, rad.
const MESH_WINDOW: f64 = 1.3;

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
