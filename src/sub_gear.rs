//! One sub-gear pair: the J tooth pairs of one contact, and what makes them fabricable by themselves.

use nalgebra::Vector3;

use crate::contact::{Contact, Grid, ToothLaw, Trace, trace};
use crate::design::Gear;

/// What the teeth of a band have in common; rad and mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sketch {
    /// Pressure angle α at mid contact.
    pub alpha: f64,
    /// Change of α over the contact.
    pub alpha_change: f64,
    /// Share of rolling: 1 tilts the normals so that the contact stays at the pitch point and moves
    /// along z only (helical teeth), 0 keeps them level (spur teeth, contact along a line of action).
    pub roll: f64,
    /// Change of β over the contact on top of what rolling asks for.
    pub beta_change: f64,
    /// Turning side: +1 or −1, the sign of n_y.
    pub side: f64,
    /// Axial coordinate at mid contact.
    pub z: f64,
    /// Axial travel of the contact.
    pub travel: f64,
    /// Offset of the contact from the pitch point along n at mid contact.
    pub offset: f64,
    /// Share of the follower's rise and fall that the locus takes part in: 0 keeps it level in Σ, where
    /// the driver's band is then flat, 1 keeps the follower's band flat.
    pub ride: f64,
    /// Share of the pitch point's wandering from tooth to tooth that the contact does not take part in,
    /// along n.
    pub stay: f64,
}

/// Design variables of a band: a sketch common to its teeth, and how four numbers of each tooth depart
/// from it.
#[derive(Debug, Clone, PartialEq)]
pub struct BandLaw {
    /// Common to the band.
    pub sketch: Sketch,
    /// Added to α, β (rad), offset and z (mm) of tooth j.
    pub shifts: Vec<[f64; OWN]>,
}

/// Numbers of a sketch that can be changed freely: all but the side.
pub const SKETCH: usize = 9;
/// Numbers of one tooth.
pub const OWN: usize = 4;

/// Changes of a sketch's free numbers ([`Sketch::free`]) and of a tooth's own that alter a band about
/// as much as each other; rad and mm, for a gear of L = 25 × `scale`.
pub fn natural_sizes(scale: f64) -> ([f64; SKETCH], [f64; OWN]) {
    let (along, offset) = (0.8 * scale, 0.3 * scale);
    (
        [0.1, 0.1, 0.1, 0.1, along, along, offset, 0.15, 0.15],
        [0.08, 0.08, offset, 0.4 * scale],
    )
}

impl Sketch {
    /// The numbers that can be changed freely: α, share of rolling, changes of α and β, z, travel, offset,
    /// ride and stay.
    pub fn free(&mut self) -> [&mut f64; SKETCH] {
        [
            &mut self.alpha,
            &mut self.roll,
            &mut self.alpha_change,
            &mut self.beta_change,
            &mut self.z,
            &mut self.travel,
            &mut self.offset,
            &mut self.ride,
            &mut self.stay,
        ]
    }
}

impl BandLaw {
    /// J teeth after one sketch.
    pub fn uniform(sketch: Sketch, teeth: usize) -> BandLaw {
        BandLaw {
            sketch,
            shifts: vec![[0.0; OWN]; teeth],
        }
    }

    /// Law of tooth `j`.
    pub fn at(&self, grid: &Grid, j: usize) -> ToothLaw {
        let s = &self.sketch;
        let [alpha, beta, offset, z] = self.shifts[j];
        let alpha = s.alpha + alpha;
        let nodes = &grid.teeth[j];
        let last = nodes.len() - 1;
        let middle_node = &nodes[last / 2];
        // Without a ride nothing is asked of the motion, so that round-off does not come in.
        let rise = |i: usize| match s.ride == 0.0 {
            true => 0.0,
            false => s.ride * nodes[i].rise(s.z, grid.pitch_radius),
        };
        let z = s.z + z + rise(last / 2);
        let travel = s.travel + rise(last) - rise(0);
        let (start, middle, end) = (-0.5, 0.0, 0.5);
        let rolling = |u: f64| {
            rolling_beta(
                grid,
                j,
                u,
                alpha + s.alpha_change * u,
                (s.side, z + travel * u, travel),
            )
        };
        let share = |tan: f64| (s.roll * tan).atan();
        let mut law = ToothLaw {
            alpha,
            beta: share(rolling(middle)) + beta,
            alpha_change: s.alpha_change,
            beta_change: share(rolling(end)) - share(rolling(start)) + s.beta_change,
            side: s.side,
            z,
            travel,
            offset: s.offset + offset,
        };
        if s.stay != 0.0 {
            let mut wandering = middle_node.pitch_point(z);
            wandering -= Vector3::new(-grid.pitch_radius, 0.0, z);
            law.offset -= s.stay * law.normal(middle).0.dot(&wandering);
        }
        law
    }

    /// All design variables in a row, as stored in `design.json`.
    pub fn to_parameters(&self) -> Vec<f64> {
        let s = self.sketch;
        let mut row = vec![
            s.alpha,
            s.alpha_change,
            s.roll,
            s.beta_change,
            s.side,
            s.z,
            s.travel,
            s.offset,
            s.ride,
            s.stay,
        ];
        row.extend(self.shifts.iter().flatten());
        row
    }
}

/// tan β of the normal that is perpendicular to the path of the pitch point over the gears at `u` of
/// tooth `j`, for pressure angle `alpha` and a locus at height `z` with axial travel.
fn rolling_beta(
    grid: &Grid,
    j: usize,
    u: f64,
    alpha: f64,
    (side, z, travel): (f64, f64, f64),
) -> f64 {
    let nodes = &grid.teeth[j];
    let last = nodes.len() - 1;
    let i = ((u + 0.5) * last as f64).round() as usize;
    let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
    let span = nodes[after].phi - nodes[before].phi;
    // A start value for the search, so a difference quotient of the tabulated pitch points is enough.
    let mut path = (nodes[after].pitch_point(z) - nodes[before].pitch_point(z)) / span;
    path.z = travel / (2.0 * grid.half_interval);
    let t = path - nodes[i].driver.velocity(nodes[i].pitch_point(z));
    -(alpha.sin() * t.x + side * alpha.cos() * t.y) / t.z
}

/// Contacts of all J teeth.
#[derive(Debug, Clone)]
pub struct Band {
    /// What it was traced from.
    pub law: BandLaw,
    /// Contacts of tooth j from start to end of its interval.
    pub teeth: Vec<Trace>,
}

/// Why a band is no good by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Flaw {
    /// The construction degenerates or leaves the gear.
    Degenerate,
    /// Teeth cross beside the contact: second-order gap below the margin.
    Gap,
    /// A tangent (nearly) vanishes: undercut.
    Cusp,
    /// The sweep folds over itself.
    Fold,
    /// Neighbouring teeth of one gear are closer than thickness plus gap.
    Spacing,
    /// The other gear's hub is in the way.
    Hub,
    /// Socket or arm is in the way.
    Joint,
    /// Driver and follower teeth of the band collide away from their contact.
    Teeth,
}

impl std::fmt::Display for Flaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Flaw::Degenerate => "leave the gear",
            Flaw::Gap => "cross beside the contact",
            Flaw::Cusp => "are undercut",
            Flaw::Fold => "fold over themselves",
            Flaw::Spacing => "have teeth too close to each other",
            Flaw::Hub => "hit the other gear's hub",
            Flaw::Joint => "hit the joint",
            Flaw::Teeth => "have teeth that collide",
        })
    }
}

/// Margins of a fabricable band, mm and mm/rad.
#[derive(Debug, Clone, Copy)]
pub struct Margins {
    /// Least second-order gap g, mm/rad².
    pub gap: f64,
    /// Least induced normal curvature in any direction, 1/mm.
    pub curvature: f64,
    /// Least |T¹|, |T²|, mm/rad.
    pub tangent: f64,
    /// Least distance between bead axes of neighbouring teeth.
    pub spacing: f64,
    /// Radius of the swept bead.
    pub bead_radius: f64,
    /// Radius of the flanks across the tooth.
    pub flank_radius: f64,
    /// Half the thickness of the ribs.
    pub rib: f64,
    /// Axes of driver and follower, and how near to them their ribs reach.
    pub feet: [(Vector3<f64>, f64); 2],
}

impl Band {
    /// Traces all teeth of `law`.
    ///
    /// # Errors
    /// The first flaw of a tooth by itself.
    pub fn trace(grid: &Grid, law: BandLaw, margins: &Margins) -> Result<Band, Flaw> {
        let teeth = (0..grid.teeth.len())
            .map(|j| tooth(grid, j, &law.at(grid, j), margins))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Band { law, teeth })
    }

    /// A band whose teeth were traced elsewhere, `law` being what they started from.
    ///
    /// # Errors
    /// The first flaw of a tooth by itself.
    pub fn of(
        grid: &Grid,
        law: BandLaw,
        teeth: Vec<Trace>,
        margins: &Margins,
    ) -> Result<Band, Flaw> {
        for (j, tooth) in teeth.iter().enumerate() {
            examine(grid, j, tooth, margins)?;
        }
        Ok(Band { law, teeth })
    }

    /// Traces all teeth of `law`, raising the pressure angle of those that would cross their mates
    /// beside the contact: a steeper push parts the surfaces faster, at the price of less torque.
    ///
    /// # Errors
    /// The flaw of the first tooth that no pressure angle up to 70° mends.
    pub fn mend(grid: &Grid, mut law: BandLaw, margins: &Margins) -> Result<Band, Flaw> {
        let teeth = (0..grid.teeth.len())
            .map(|j| mended(grid, j, &mut law, margins))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Band { law, teeth })
    }

    /// What each tooth of `law` fails of by itself, mended as far as it goes.
    pub(crate) fn flaws(grid: &Grid, mut law: BandLaw, margins: &Margins) -> Vec<Option<Flaw>> {
        (0..grid.teeth.len())
            .map(|j| mended(grid, j, &mut law, margins).err())
            .collect()
    }

    /// Axis of the bead of tooth `j` in the frame of `gear`: the contact curve moved by the bead
    /// radius into the material; every `stride`-th contact.
    pub fn bead_axis(
        &self,
        grid: &Grid,
        j: usize,
        gear: Gear,
        bead_radius: f64,
        stride: usize,
    ) -> Vec<Vector3<f64>> {
        self.teeth[j]
            .iter()
            .enumerate()
            .step_by(stride)
            .map(|(i, c)| {
                let (p, n, _) = in_body(grid, j, i, c, gear);
                p + bead_radius * n
            })
            .collect()
    }
}

/// Traces tooth `j`, raising its pressure angle up to 70° while it would cross its mate.
fn mended(grid: &Grid, j: usize, law: &mut BandLaw, margins: &Margins) -> Result<Trace, Flaw> {
    loop {
        match tooth(grid, j, &law.at(grid, j), margins) {
            Err(Flaw::Gap) if law.at(grid, j).alpha < 70f64.to_radians() => {
                law.shifts[j][0] += 5f64.to_radians();
            }
            traced => return traced,
        }
    }
}

/// Traces one tooth and checks it: gap, cusp, fold.
fn tooth(grid: &Grid, j: usize, law: &ToothLaw, margins: &Margins) -> Result<Trace, Flaw> {
    let tooth = trace(grid, j, law).ok_or(Flaw::Degenerate)?;
    examine(grid, j, &tooth, margins)?;
    Ok(tooth)
}

/// Checks what a traced tooth must satisfy by itself.
fn examine(grid: &Grid, j: usize, tooth: &Trace, margins: &Margins) -> Result<(), Flaw> {
    let finite = |c: &Contact| c.gap.is_finite() && c.p.iter().all(|x| x.is_finite());
    if !tooth.iter().all(finite) {
        return Err(Flaw::Degenerate);
    }
    match slacks(grid, j, tooth, margins).find(|(_, slack)| !(*slack > 0.0)) {
        Some((flaw, _)) => Err(flaw),
        None => Ok(()),
    }
}

/// How far a traced tooth is from each limit that it has to keep by itself, with what it would fail of:
/// positive where it is kept; of about the size of mm.
pub(crate) fn slacks<'a>(
    grid: &'a Grid,
    j: usize,
    tooth: &'a Trace,
    margins: &'a Margins,
) -> impl Iterator<Item = (Flaw, f64)> + 'a {
    let contacts = tooth.iter().flat_map(|c| {
        let curvature = c.induced_curvature(margins.flank_radius) - margins.curvature;
        [
            (Flaw::Gap, c.gap - margins.gap),
            (Flaw::Gap, curvature * CURVATURE),
            (Flaw::Cusp, c.t1.norm() - margins.tangent),
            (Flaw::Cusp, c.t2.norm() - margins.tangent),
        ]
    });
    let sweeps = [Gear::Driver, Gear::Follower]
        .into_iter()
        .flat_map(move |gear| advances(grid, j, tooth, (gear, margins)))
        .map(|advance| (Flaw::Fold, advance));
    contacts.chain(sweeps)
}

/// Induced curvature in the scale of the other slacks: mm² by which 1/mm is multiplied.
const CURVATURE: f64 = 5.0;

/// Contact point, normal into the material and tangent of station `i` of tooth `j` in the frame of
/// `gear`.
pub fn in_body(
    grid: &Grid,
    j: usize,
    i: usize,
    c: &Contact,
    gear: Gear,
) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let node = &grid.teeth[j][2 * i];
    match gear {
        Gear::Driver => {
            let rt = node.driver.pose.rotation.transpose();
            (node.driver.pose.inverse_apply(c.p), -(rt * c.n), rt * c.t1)
        }
        Gear::Follower => {
            let rt = node.follower.pose.rotation.transpose();
            (node.follower.pose.inverse_apply(c.p), rt * c.n, rt * c.t2)
        }
    }
}

/// How well tooth and rib advance when they are swept, from station to station: of what the contact point
/// advances the least share that a point of the bead or of the rib's foot does, above that below
/// which it counts as folded; negative where the contact itself turns back.
fn advances(
    grid: &Grid,
    j: usize,
    tooth: &Trace,
    (gear, margins): (Gear, &Margins),
) -> impl Iterator<Item = f64> {
    let (radius, half) = (margins.bead_radius, margins.rib);
    let (axis, foot) = margins.feet[gear as usize];
    let section = move |i: usize| {
        let (p, n, t) = in_body(grid, j, i, &tooth[i], gear);
        let t = t.normalize();
        let b = t.cross(&n);
        let c = p + radius * n;
        let outward = (c - axis).component_mul(&Vector3::new(1.0, 1.0, 0.0));
        let away = outward.norm();
        let inner = c - outward * (1.0 - (foot / away).min(SHORTEST_RIB));
        let side = half * t.cross(&outward).normalize();
        (
            t,
            [p, c, c + radius * n, c + radius * b],
            [inner + side, inner - side],
        )
    };
    // Ribs end before their teeth do.
    let inset = tooth.len() / 8;
    let ribbed = inset..tooth.len() - inset;
    let mut before = section(0);
    (1..tooth.len()).map(move |i| {
        let here = section(i);
        let t = before.0 + here.0;
        let [contact, middle, behind, above] =
            std::array::from_fn(|k| (here.1[k] - before.1[k]).dot(&t));
        // Linear over the section, so the least on the bead's circle follows from three points.
        let slope = (behind - middle).powi(2) + (above - middle).powi(2);
        let mut slack = (middle - slope.sqrt()) / contact - FOLDED;
        if ribbed.contains(&(i - 1)) && ribbed.contains(&i) {
            let foot = (0..2).map(|k| (here.2[k] - before.2[k]).dot(&t));
            slack = slack.min(foot.fold(f64::INFINITY, f64::min) / contact - FOLDED);
        }
        before = here;
        if contact > 0.0 { slack } else { -1.0 }
    })
}

/// Share of the contact's advance below which a bead or a rib counts as folded: rings that lie closer
/// together meet at edges too sharp to print.
const FOLDED: f64 = 0.3;

/// Where a bead comes closer to the axis than its rib's foot, the foot moves in to this share of the
/// bead's distance.
pub const SHORTEST_RIB: f64 = 0.8;
