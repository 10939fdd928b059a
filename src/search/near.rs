//! Where the teeth of a choice come nearest to each other, to hubs and to the joint: teeth as bars with
//! walls under them, like the balls of the collision model but without a field between. Each place
//! tells which points of which teeth meet there and in which direction they part, so that its gap can be
//! followed when the teeth change.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::clearance::{Phase, REACH, Scene};
use super::mates;
use super::tooth::Tooth;
use crate::design::Gear;
use crate::motion::Pose;

/// A point of a tooth or its rib.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub band: usize,
    pub tooth: usize,
    /// 0 the driver's, 1 the follower's.
    pub gear: usize,
    /// Of the bead's axis: layer, station and the share of the way to the next station.
    pub layer: usize,
    pub station: usize,
    pub along: f64,
    /// Distance from the gear's axis as a share of the bead's.
    pub share: f64,
    /// Change of the gap per mm of displacement, in the frame of the gear.
    pub way: Vector3<f64>,
}

/// A place where a gap is small.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// What is left above the gap wanted, mm.
    pub slack: f64,
    pub spots: Vec<Spot>,
}

/// A station of a tooth on one gear: its bead's points by layer and the rib's lower and upper end.
struct Spoke {
    beads: Vec<Vector3<f64>>,
    rib: Option<[Rung; 2]>,
    /// Of all its points, along z.
    low: f64,
    high: f64,
}

/// A point of a rib with its share of the bead's distance from the axis.
#[derive(Clone, Copy)]
struct Rung {
    at: Vector3<f64>,
    share: f64,
}

/// A tooth on one gear.
struct Body {
    spokes: Vec<Spoke>,
    /// Of all points, in the frame of the gear.
    low: Vector3<f64>,
    high: Vector3<f64>,
}

/// Teeth of all bands on one gear, by band and tooth.
type Bodies = Vec<Vec<Body>>;

impl Scene {
    /// All places whose slack is below `window` (mm): the nearest of each tooth, or pair of teeth, at
    /// each phase.
    pub(super) fn places(&self, bands: &[Vec<Tooth>], spacing: f64, window: f64) -> Vec<Place> {
        let gears = [Gear::Driver, Gear::Follower];
        let [driver, follower] = gears.map(|gear| -> Bodies {
            let band = |band: &Vec<Tooth>| self.bodies(band, gear);
            bands.iter().map(band).collect()
        });
        let count = bands.len();
        let mut places: Vec<Place> = self
            .phases()
            .par_iter()
            .flat_map_iter(|phase| self.between(phase, (&driver, &follower), window))
            .collect();
        places.par_extend((0..count).into_par_iter().flat_map_iter(|b| {
            let mut own = self.mates(b, &bands[b], window);
            own.extend(self.hubs(b, [&driver[b], &follower[b]], window));
            own.extend(self.joint(b, [&driver[b], &follower[b]], window));
            own.extend(self.neighbours(b, &bands[b], spacing, window));
            own
        }));
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        for (a, b) in pairs {
            places.extend(self.fins_apart((a, &bands[a]), (b, &bands[b]), window));
        }
        places
    }

    /// A band's teeth as they stand around `gear`.
    fn bodies(&self, band: &[Tooth], gear: Gear) -> Vec<Body> {
        let mut bodies: Vec<Body> = band.iter().map(|t| self.body(t, gear)).collect();
        for number in band.len()..self.copies(gear) * band.len() {
            let copy = bodies[number % band.len()].seen(&self.copy(number));
            bodies.push(copy);
        }
        bodies
    }

    /// On the bead of the tooth of a band that stands at `number` on a gear, in whose frame `way` is.
    fn spot(
        &self,
        (band, number, gear): (usize, usize, usize),
        station: usize,
        way: Vector3<f64>,
    ) -> Spot {
        let tooth = number % self.pairs();
        let way = match number == tooth {
            true => way,
            false => self.copy(number).rotation.transpose() * way,
        };
        Spot::on_bead((band, tooth, gear), station, way)
    }

    fn body(&self, tooth: &Tooth, gear: Gear) -> Body {
        let (axis, hub) = (self.axis(gear), self.hub_radius(gear));
        let layers = &tooth.beads[gear as usize];
        let spokes: Vec<Spoke> = (0..layers[0].len())
            .step_by(self.stride())
            .map(|i| {
                let bead = layers[0][i];
                let radius = (bead - axis).xy().norm();
                let top = radius - self.rib_spacing();
                let rung = |at: f64| {
                    let share = at / radius;
                    let mut point = axis + (bead - axis) * share;
                    point.z = bead.z;
                    Rung { at: point, share }
                };
                let rib = (top > hub).then(|| [rung(hub), rung(top)]);
                Spoke::new(layers.iter().map(|layer| layer[i]).collect(), rib)
            })
            .collect();
        Body::new(spokes)
    }

    /// Driver teeth and follower teeth of all bands at one phase, but for mates.
    fn between(
        &self,
        phase: &Phase,
        (driver, follower): (&Bodies, &Bodies),
        window: f64,
    ) -> Vec<Place> {
        let reach = 2.0 * self.radii().bead.max(self.radii().rib) + self.gap() + window;
        let back = phase.follower_in_driver.rotation.transpose();
        let spot = |of: (usize, usize, usize), s: Site, way| Spot {
            layer: s.layer,
            share: s.share,
            ..self.spot(of, s.spoke * self.stride(), way)
        };
        let mut places = Vec::new();
        for (b, k) in meshing(phase, Gear::Follower, follower.len()) {
            let seen = follower[b][k].seen(&phase.follower_in_driver);
            for (a, j) in meshing(phase, Gear::Driver, driver.len()) {
                if (a, j) == (b, phase.mates[k]) || !seen.may_reach(&driver[a][j], reach) {
                    continue;
                }
                let room = if a == b { self.room(f64::MAX) } else { 0.0 };
                let met = self.meetings(&driver[a][j], &seen, window + room);
                places.extend(met.into_iter().map(|meeting| Place {
                    slack: meeting.slack - room,
                    spots: vec![
                        spot((a, j, 0), meeting.sites[0], -meeting.way),
                        spot((b, k, 1), meeting.sites[1], back * meeting.way),
                    ],
                }));
            }
        }
        places
    }

    /// Where two teeth come near each other, with a slack below `window`: spokes of the one that are
    /// nearer than those beside them.
    fn meetings(&self, tooth: &Body, other: &Body, window: f64) -> Vec<Meeting> {
        let met =
            (0..tooth.spokes.len()).map(|i| self.meeting((i, &tooth.spokes[i]), other, window));
        let mut met: Vec<Option<Meeting>> = met.collect();
        let slacks: Vec<f64> = met
            .iter()
            .map(|m| m.as_ref().map_or(f64::INFINITY, |m| m.slack))
            .collect();
        mates::valleys(&slacks)
            .filter_map(|i| met[i].take())
            .collect()
    }

    /// Where a spoke is nearest to another tooth, if its slack is below `window`.
    fn meeting(&self, (i, s): (usize, &Spoke), other: &Body, window: f64) -> Option<Meeting> {
        let radii = self.radii();
        let mut nearest: Option<Meeting> = None;
        let mut least = window;
        let thickest = 2.0 * radii.bead.max(radii.rib) + self.gap();
        for (k, o) in other.spokes.iter().enumerate() {
            // Spokes are level in their gears, so most pairs are apart in height.
            if (o.low - s.high).max(s.low - o.high) - thickest >= least {
                continue;
            }
            let mut note = |p: Vector3<f64>, q: Vector3<f64>, radius: f64, sites: [Site; 2]| {
                let d = q - p;
                let distance = d.norm();
                let slack = distance - radius - self.gap();
                if slack < least && distance > 0.0 {
                    least = slack;
                    nearest = Some(Meeting {
                        slack,
                        way: d / distance,
                        sites,
                    });
                }
            };
            let site = |spoke: usize, layer: usize, share: f64| Site {
                spoke,
                layer,
                share,
            };
            for (x, p) in s.beads.iter().enumerate() {
                for (y, q) in o.beads.iter().enumerate() {
                    note(*p, *q, 2.0 * radii.bead, [site(i, x, 1.0), site(k, y, 1.0)]);
                }
                if let Some(rib) = &o.rib {
                    let (q, share) = foot(*p, rib);
                    note(
                        *p,
                        q,
                        radii.bead + radii.rib,
                        [site(i, x, 1.0), site(k, 0, share)],
                    );
                }
            }
            if let Some(rib) = &s.rib {
                for (y, q) in o.beads.iter().enumerate() {
                    let (p, share) = foot(*q, rib);
                    note(
                        p,
                        *q,
                        radii.bead + radii.rib,
                        [site(i, 0, share), site(k, y, 1.0)],
                    );
                }
                if let Some(other) = &o.rib {
                    let [(p, u), (q, v)] = feet(rib, other);
                    note(p, q, 2.0 * radii.rib, [site(i, 0, u), site(k, 0, v)]);
                }
            }
        }
        nearest
    }

    /// Each tooth against its mate.
    fn mates(&self, b: usize, band: &[Tooth], window: f64) -> Vec<Place> {
        let spot = |tooth: usize, gear: usize, (station, along, share), way| Spot {
            along,
            share,
            ..Spot::on_bead((b, tooth, gear), station, way)
        };
        let mut places = Vec::new();
        for (j, tooth) in band.iter().enumerate() {
            let pair = self.mate(tooth.beads.each_ref().map(|layers| layers[0].clone()));
            let near = |p: &&Phase| p.meshing[Gear::Follower as usize][j];
            for phase in self.phases().iter().filter(near) {
                let poses = self.mate_poses(phase, j);
                let room = self.room(phase.apart[j]);
                for mates::Meeting { slack, at, way } in
                    pair.meetings(poses.each_ref(), window + room)
                {
                    let back = poses[0].rotation.transpose();
                    places.push(Place {
                        slack: slack - room,
                        spots: vec![spot(j, 0, at[0], -way), spot(j, 1, at[1], back * way)],
                    });
                }
            }
        }
        places
    }

    /// Beads of each gear against the other gear's hub, and the driver's within its reach.
    fn hubs(&self, b: usize, bodies: [&Vec<Body>; 2], window: f64) -> Vec<Place> {
        let radius = self.radii().bead;
        let mut places = Vec::new();
        for gear in [Gear::Driver, Gear::Follower] {
            let other = match gear {
                Gear::Driver => Gear::Follower,
                Gear::Follower => Gear::Driver,
            };
            let (axis, hub) = (self.axis(other), self.hub_radius(other));
            let pose = |phase: &Phase| match gear {
                Gear::Driver => phase.driver_in_follower,
                Gear::Follower => phase.follower_in_driver,
            };
            let own = self.axis(gear);
            for (j, body) in bodies[gear as usize].iter().enumerate() {
                let near: Vec<Pose> = self
                    .phases()
                    .iter()
                    .filter(|p| p.meshing[gear as usize][j])
                    .map(pose)
                    .collect();
                for (i, spoke) in body.spokes.iter().enumerate() {
                    let bead = spoke.beads[0];
                    let mut nearest: Option<(f64, Vector3<f64>)> = None;
                    for pose in &near {
                        let level = (pose.apply(bead) - axis).component_mul(&LEVEL);
                        let away = level.norm();
                        if nearest.is_none_or(|n| away < n.0) && away > 0.0 {
                            nearest = Some((away, pose.rotation.transpose() * (level / away)));
                        }
                    }
                    let mut note = |slack: f64, way: Vector3<f64>| {
                        if slack < window {
                            let at = (b, j, gear as usize);
                            let spot = self.spot(at, i * self.stride(), way);
                            places.push(Place {
                                slack,
                                spots: vec![spot],
                            });
                        }
                    };
                    if let Some((away, way)) = nearest {
                        note(away - hub - self.gap() - radius, way);
                    }
                    if gear == Gear::Driver {
                        let level = (bead - own).component_mul(&LEVEL);
                        let away = level.norm();
                        let reach = REACH * self.center_distance() - self.gap() - radius;
                        note(reach - away, -level / away);
                    }
                }
            }
        }
        places
    }

    /// Beads and ribs of both gears against socket ring and arm.
    fn joint(&self, b: usize, bodies: [&Vec<Body>; 2], window: f64) -> Vec<Place> {
        let Some(joint) = &self.envelope().ball_joint else {
            return Vec::new();
        };
        let radii = self.radii();
        let mut places = Vec::new();
        let tallest = joint.half_height() + self.gap() + radii.bead;
        let (sin, cos) = self.envelope().reach.tilt.sin_cos();
        for gear in [Gear::Driver, Gear::Follower] {
            for (j, body) in bodies[gear as usize].iter().enumerate() {
                for (i, spoke) in body.spokes.iter().enumerate() {
                    let bead = spoke.beads[0];
                    // As far from the plane of the joint as it ever needs to be.
                    let low = match gear {
                        Gear::Driver => bead.z.abs() < tallest + window,
                        Gear::Follower => {
                            bead.z.abs() * cos < tallest + window + bead.xy().norm() * sin
                        }
                    };
                    if !low {
                        continue;
                    }
                    let mut points = vec![(bead, 1.0, radii.bead)];
                    if let Some([foot, top]) = spoke.rib {
                        let steps = ((top.at - foot.at).norm() / self.rib_spacing())
                            .ceil()
                            .max(1.0);
                        points.extend((0..=steps as usize).map(|s| {
                            let f = s as f64 / steps;
                            let at = foot.at.lerp(&top.at, f);
                            (at, foot.share + f * (top.share - foot.share), radii.rib)
                        }));
                    }
                    let mut nearest: Option<(f64, f64, Vector3<f64>, &Pose)> = None;
                    for phase in self.phases() {
                        let pose = match gear {
                            Gear::Driver if !phase.meshing[0][j] => continue,
                            Gear::Driver => &phase.driver,
                            Gear::Follower => &phase.follower,
                        };
                        for &(point, share, radius) in &points {
                            let p = pose.apply(point);
                            let slack = joint.distance(p) - radius - self.gap();
                            if slack < nearest.map_or(window, |n| n.0) {
                                nearest = Some((slack, share, p, pose));
                            }
                        }
                    }
                    if let Some((slack, share, p, pose)) = nearest {
                        let way = Vector3::from_fn(|k, _| {
                            let mut d = Vector3::zeros();
                            d[k] = 1e-4;
                            (joint.distance(p + d) - joint.distance(p - d)) / 2e-4
                        });
                        let way = pose.rotation.transpose() * way;
                        let spot = Spot {
                            share,
                            ..self.spot((b, j, gear as usize), i * self.stride(), way)
                        };
                        places.push(Place {
                            slack,
                            spots: vec![spot],
                        });
                    }
                }
            }
        }
        places
    }

    /// Bead axes of neighbouring teeth of one gear.
    fn neighbours(&self, b: usize, band: &[Tooth], spacing: f64, window: f64) -> Vec<Place> {
        let mut places = Vec::new();
        for gear in 0..2 {
            for j in 0..band.len() - usize::from(!self.wraps()) {
                let next = (j + 1) % band.len();
                let [a, o] = [j, next].map(|t| &band[t].beads[gear][0]);
                // Behind the last tooth the next copy of the first one stands.
                let copy = match gear == 0 && next == 0 {
                    true => self.copy(band.len()),
                    false => self.copy(0),
                };
                for i in (0..a.len()).step_by(NEIGHBOURS) {
                    let nearest = (0..o.len()).step_by(NEIGHBOURS);
                    let nearest = nearest.min_by(|x, y| {
                        let d = |k: usize| (copy.apply(o[k]) - a[i]).norm_squared();
                        d(*x).total_cmp(&d(*y))
                    });
                    let Some(k) = nearest else { continue };
                    let d = copy.apply(o[k]) - a[i];
                    let slack = d.norm() - spacing;
                    if slack < window {
                        let way = d.normalize();
                        let spot = |tooth: usize, station: usize, way| {
                            Spot::on_bead((b, tooth, gear), station, way)
                        };
                        places.push(Place {
                            slack,
                            spots: vec![
                                spot(j, i, -way),
                                spot(next, k, copy.rotation.transpose() * way),
                            ],
                        });
                    }
                }
            }
        }
        places
    }

    /// Fins of two bands on the same gear, unrolled.
    fn fins_apart(
        &self,
        (a, first): (usize, &[Tooth]),
        (b, second): (usize, &[Tooth]),
        window: f64,
    ) -> Vec<Place> {
        let limit = self.fins_limit();
        let mut places = Vec::new();
        for gear in [Gear::Driver, Gear::Follower] {
            let radius = self.fin_radius(gear);
            let turn = std::f64::consts::TAU * radius / self.copies(gear) as f64;
            let axis = self.axis(gear);
            let unroll = |band: &[Tooth]| -> Vec<Vec<[f64; 2]>> {
                let line = |tooth: &Tooth| {
                    let stations = tooth.beads[gear as usize][0].iter().step_by(self.stride());
                    let at = |p: &Vector3<f64>| {
                        let p = p - axis;
                        [radius * p.y.atan2(p.x), p.z]
                    };
                    stations.map(at).collect()
                };
                band.iter().map(line).collect()
            };
            let (own, other) = (unroll(first), unroll(second));
            let heights = |line: &[[f64; 2]]| {
                line.iter().fold([f64::MAX, f64::MIN], |[low, high], p| {
                    [low.min(p[1]), high.max(p[1])]
                })
            };
            for (j, line) in own.iter().enumerate() {
                let [low, high] = heights(line);
                for (k, beside) in other.iter().enumerate() {
                    let [low_k, high_k] = heights(beside);
                    if low_k > high + limit + window || high_k < low - limit - window {
                        continue;
                    }
                    let mut nearest: Option<(f64, usize, usize, [f64; 2])> = None;
                    for (i, p) in line.iter().enumerate() {
                        for (m, q) in beside.iter().enumerate() {
                            let mut arc = q[0] - p[0];
                            arc -= turn * (arc / turn).round();
                            let z = q[1] - p[1];
                            let away = (arc * arc + z * z).sqrt();
                            if away < nearest.map_or(limit + window, |n| n.0) && away > 0.0 {
                                nearest = Some((away, i, m, [arc / away, z / away]));
                            }
                        }
                    }
                    let Some((away, i, m, [arc, z])) = nearest else {
                        continue;
                    };
                    let spot =
                        |band: usize, tooth: usize, teeth: &[Tooth], station: usize, sign: f64| {
                            let station = station * self.stride();
                            let p = teeth[tooth].beads[gear as usize][0][station] - axis;
                            let around =
                                Vector3::new(-p.y, p.x, 0.0) * (radius / p.xy().norm_squared());
                            let way = sign * (arc * around + z * Vector3::z());
                            Spot::on_bead((band, tooth, gear as usize), station, way)
                        };
                    places.push(Place {
                        slack: away - limit,
                        spots: vec![spot(a, j, first, i, -1.0), spot(b, k, second, m, 1.0)],
                    });
                }
            }
        }
        places
    }
}

impl Spot {
    /// At a station of the outermost bead axis of a band's tooth on one gear.
    fn on_bead(
        (band, tooth, gear): (usize, usize, usize),
        station: usize,
        way: Vector3<f64>,
    ) -> Spot {
        Spot {
            band,
            tooth,
            gear,
            layer: 0,
            station,
            along: 0.0,
            share: 1.0,
            way,
        }
    }

    /// Change of the gap when the tooth changes by `slope`.
    pub fn change(&self, slope: &Tooth) -> f64 {
        let line = &slope.beads[self.gear][self.layer];
        let mut by = line[self.station];
        if self.along > 0.0 {
            by = by.lerp(&line[self.station + 1], self.along);
        }
        self.share * (self.way.x * by.x + self.way.y * by.y) + self.way.z * by.z
    }
}

/// Where a tooth and another meet.
struct Meeting {
    slack: f64,
    /// From the one to the other.
    way: Vector3<f64>,
    sites: [Site; 2],
}

/// A point of a body.
#[derive(Clone, Copy)]
struct Site {
    spoke: usize,
    layer: usize,
    share: f64,
}

impl Body {
    fn new(spokes: Vec<Spoke>) -> Body {
        let mut low = spokes[0].beads[0];
        let mut high = low;
        for spoke in &spokes {
            let rib = spoke.rib.iter().flatten().map(|r| &r.at);
            for p in spoke.beads.iter().chain(rib) {
                (low, high) = (low.inf(p), high.sup(p));
            }
        }
        Body { spokes, low, high }
    }

    /// The tooth as seen from the other gear.
    fn seen(&self, pose: &Pose) -> Body {
        let rung = |r: Rung| Rung {
            at: pose.apply(r.at),
            ..r
        };
        let spoke = |s: &Spoke| {
            let beads = s.beads.iter().map(|p| pose.apply(*p)).collect();
            Spoke::new(beads, s.rib.map(|rib| rib.map(rung)))
        };
        Body::new(self.spokes.iter().map(spoke).collect())
    }

    fn may_reach(&self, other: &Body, reach: f64) -> bool {
        (0..3).all(|k| self.low[k] < other.high[k] + reach && self.high[k] > other.low[k] - reach)
    }
}

impl Spoke {
    fn new(beads: Vec<Vector3<f64>>, rib: Option<[Rung; 2]>) -> Spoke {
        let heights = beads.iter().map(|p| p.z);
        let all = heights.chain(rib.iter().flatten().map(|r| r.at.z));
        let (low, high) = all.fold((f64::MAX, f64::MIN), |(low, high), z| {
            (low.min(z), high.max(z))
        });
        Spoke {
            beads,
            rib,
            low,
            high,
        }
    }
}

/// Band and number of those teeth of a gear with so many `bands` that can be near the mesh.
fn meshing(phase: &Phase, gear: Gear, bands: usize) -> impl Iterator<Item = (usize, usize)> {
    let meshing = &phase.meshing[gear as usize];
    let teeth = (0..meshing.len()).filter(|&j| meshing[j]);
    (0..bands).flat_map(move |b| teeth.clone().map(move |j| (b, j)))
}

/// Point of a rib that is nearest to `p`, with its share.
fn foot(p: Vector3<f64>, [a, b]: &[Rung; 2]) -> (Vector3<f64>, f64) {
    let d = b.at - a.at;
    let f = ((p - a.at).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    (a.at + d * f, a.share + f * (b.share - a.share))
}

/// Nearest points of two ribs, with their shares.
fn feet(one: &[Rung; 2], other: &[Rung; 2]) -> [(Vector3<f64>, f64); 2] {
    let (d, e) = (one[1].at - one[0].at, other[1].at - other[0].at);
    let r = one[0].at - other[0].at;
    let (aa, bb, ab) = (d.norm_squared(), e.norm_squared(), d.dot(&e));
    let (c, f) = (d.dot(&r), e.dot(&r));
    let across = aa * bb - ab * ab;
    let mut s = match across > 1e-9 * aa * bb {
        true => ((ab * f - c * bb) / across).clamp(0.0, 1.0),
        false => 0.5,
    };
    let mut t = (ab * s + f) / bb;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((ab * t - c) / aa).clamp(0.0, 1.0);
    }
    let at = |rib: &[Rung; 2], f: f64| {
        let share = rib[0].share + f * (rib[1].share - rib[0].share);
        (rib[0].at.lerp(&rib[1].at, f), share)
    };
    [at(one, s), at(other, t)]
}

const LEVEL: Vector3<f64> = Vector3::new(1.0, 1.0, 0.0);

/// Stations between those at which neighbouring teeth are compared.
const NEIGHBOURS: usize = 3;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::motion::MotionFile;
    use crate::search::candidates::Workshop;
    use crate::search::tooth::{self, Bounds, VARIABLES};
    use crate::sub_gear::{BandLaw, OWN, SKETCH};

    const WOBBLE: &str = r#"
        name = "wobble"
        class = "3R"
        [motion]
        kind = "formula"
        own_turn = "-phi"
        axis = ["0.12*cos(phi)", "0.08*sin(2*phi)", "1"]
    "#;

    /// The first `count` usable bands, whether they go together or not.
    fn bands(workshop: &Workshop, count: usize) -> Vec<BandLaw> {
        let mut laws = Vec::new();
        for first in (0..).step_by(64) {
            let (usable, _) = workshop.sample(1, (first, 64), &[]);
            laws.extend(usable.into_iter().map(|c| c.law));
            if laws.len() >= count {
                break;
            }
        }
        laws.truncate(count);
        laws
    }

    #[test]
    fn gaps_follow_the_design_variables() {
        let (file, motion) =
            MotionFile::parse(WOBBLE, Path::new("wobble.toml"), Path::new(".")).unwrap();
        let workshop = Workshop::new(&motion, &file.settings);
        let laws = bands(&workshop, 3);
        let bounds = Bounds::of(&workshop, &laws[0]);
        let teeth = |laws: &[BandLaw]| -> Vec<Vec<Tooth>> {
            let band = |law| tooth::teeth(&workshop, law, bounds).unwrap();
            laws.iter().map(band).collect()
        };
        let here = teeth(&laws);
        let slope = |b: usize, j: usize| here[b][j].slopes(&workshop, j, &laws[b], bounds).unwrap();
        let slopes: Vec<Vec<Vec<Tooth>>> = (0..laws.len())
            .map(|b| (0..here[b].len()).map(|j| slope(b, j)).collect())
            .collect();
        // All variables of all bands move at once.
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let count = SKETCH + OWN * here[0].len();
        let step = 1e-4;
        let moves: Vec<Vec<f64>> = laws
            .iter()
            .map(|_| {
                (0..count)
                    .map(|_| step * rng.random_range(-1.0..1.0))
                    .collect()
            })
            .collect();
        let moved: Vec<BandLaw> = laws
            .iter()
            .zip(&moves)
            .map(|(law, moves)| tooth::moved(&workshop, law, moves))
            .collect();
        let before = workshop.places(&here, 4.0);
        let after = workshop.places(&teeth(&moved), 4.1);
        let same = |a: &Spot, b: &Spot| {
            (a.band, a.tooth, a.gear, a.layer, a.station)
                == (b.band, b.tooth, b.gear, b.layer, b.station)
        };
        let mut kinds = std::collections::BTreeSet::new();
        let (mut followed, mut all) = (0, 0);
        for place in &before {
            let change = |spot: &Spot| -> f64 {
                let by = |v: usize| {
                    let own = if v < SKETCH { 0 } else { OWN * spot.tooth };
                    moves[spot.band][own + v]
                };
                let slopes = &slopes[spot.band][spot.tooth];
                (0..VARIABLES)
                    .map(|v| by(v) * spot.change(&slopes[v]))
                    .sum()
            };
            let expected = place.slack + place.spots.iter().map(change).sum::<f64>();
            // The same spots may meet at several phases.
            let near = after.iter().filter(|other| {
                other.spots.len() == place.spots.len()
                    && other
                        .spots
                        .iter()
                        .zip(&place.spots)
                        .all(|(a, b)| same(a, b))
            });
            let error = near
                .map(|other| (other.slack - expected).abs())
                .fold(f64::INFINITY, f64::min);
            all += 1;
            if error < 0.02 * step {
                followed += 1;
                let kind = (
                    place.spots.len(),
                    place.spots.iter().map(|s| s.gear).sum::<usize>(),
                );
                kinds.insert(kind);
            }
        }
        // Where another spot takes over there is nothing to compare.
        assert!(all > 500, "{all} places");
        assert!(
            followed as f64 > 0.9 * all as f64,
            "{followed} of {all} gaps"
        );
        // Single spots and pairs, on either gear and between them.
        let wanted = [(1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        assert!(wanted.iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
    }
}
