//! Can it be put together: every step of the assembly, in the order of `parts.md`, needs a straight
//! way in past all that is already in place. Ways are proven, not sampled: over each stretch no two
//! triangles can come as close as touching.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::claim::{Claim, Spot};
use super::collide::{Affine, Drift, Placed, TOUCH};
use super::mechanism::Mechanism;
use super::overlap::Part;
use super::tree::Tree;
use crate::design::Design;
use crate::motion::{Class, Pose};
use crate::solid::assembly::Carrier;
use crate::solid::expression::Values;
use crate::solid::{Mesh, layout, primitive};
use crate::{Error, Result};

/// Driver angles at which a step that moves or passes teeth is tried.
const PHASES: usize = 36;

/// Faces that rest on each other are parted by this much before a piece moves, mm: a tenth of the
/// play that printed fits have, and far above rounding.
const SEAT: f64 = 0.02;

/// Stretches of the way are halved down to this length, mm; what is then in doubt blocks the way.
const SHORTEST: f64 = 0.002;

/// Places of a way where touching is looked for before it is proven free.
const LOOKS: u32 = 24;

/// Other ways lean by this angle from the intended one, rad.
const LEAN: f64 = 0.26;

/// One step: what comes in, past what, and in which direction it is meant to come in.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// As the claim calls it.
    name: &'static str,
    /// Bodies and pieces that move together.
    moving: &'static [&'static str],
    /// Bodies and pieces in place.
    placed: &'static [&'static str],
    /// Direction of the way in, Σ.
    along: [f64; 3],
    /// Whether the gears can be turned to find the way.
    turning: bool,
}

const DRIVER: Step = Step {
    name: "driver",
    moving: &["driver"],
    placed: &["base"],
    along: [0.0, 0.0, -1.0],
    turning: false,
};

const BRIDGE: Step = Step {
    name: "bridge",
    moving: &["bridge"],
    placed: &["base", "driver"],
    along: [0.0, 0.0, -1.0],
    turning: false,
};

const FOLLOWER: Step = Step {
    name: "follower",
    moving: &["follower"],
    placed: &["base", "driver", "bridge"],
    along: [-1.0, 0.0, 0.0],
    turning: true,
};

const PIN: Step = Step {
    name: "pin",
    moving: &["pin"],
    placed: &["base", "driver", "bridge", "follower"],
    along: [0.0, 0.0, 1.0],
    turning: false,
};

const PIN_CAP: Step = Step {
    name: "pin cap",
    moving: &["pin_cap"],
    placed: &["base", "driver", "bridge", "follower", "pin"],
    along: [0.0, 0.0, -1.0],
    turning: false,
};

/// The ball into the open half of a socket, and the cap over it.
const fn ball(name: &'static str, holder: &'static [&'static str]) -> Step {
    Step {
        name,
        moving: &["follower"],
        placed: holder,
        along: [1.0, 0.0, 0.0],
        turning: true,
    }
}

const fn socket_cap(placed: &'static [&'static str]) -> Step {
    Step {
        name: "socket cap",
        moving: &["socket_cap"],
        placed,
        along: [1.0, 0.0, 0.0],
        turning: true,
    }
}

const fn stand(moving: &'static [&'static str]) -> Step {
    Step {
        name: "stand with the follower",
        moving,
        placed: &["base", "driver", "bridge"],
        along: [-1.0, 0.0, 0.0],
        turning: true,
    }
}

const CARRIAGE: Step = Step {
    name: "slider carriage",
    moving: &["slider_carriage", "socket_cap", "follower"],
    placed: &["stand"],
    along: [0.0, 0.0, -1.0],
    turning: true,
};

/// The steps of `parts.md` for a class.
fn steps(class: Class) -> Vec<Step> {
    match class {
        Class::R1 => vec![DRIVER, BRIDGE, FOLLOWER, PIN, PIN_CAP],
        Class::R1T1 => vec![DRIVER, BRIDGE, FOLLOWER, PIN],
        Class::R3 => vec![
            DRIVER,
            BRIDGE,
            ball("follower's ball", &["stand"]),
            socket_cap(&["stand", "follower"]),
            stand(&["stand", "socket_cap", "follower"]),
        ],
        Class::R3T1 => vec![
            DRIVER,
            BRIDGE,
            ball("follower's ball", &["slider_carriage"]),
            socket_cap(&["slider_carriage", "follower"]),
            CARRIAGE,
            stand(&["stand", "slider_carriage", "socket_cap", "follower"]),
        ],
    }
}

/// A piece or body that takes part, in the frame of its carrier.
struct Item<'a> {
    name: &'a str,
    carrier: Carrier,
    tree: &'a Tree,
}

/// Why a way is closed: what is met, and how far before its place the moving part is then, mm.
struct Blocked<'a> {
    by: &'a str,
    before: f64,
}

/// One claim per step of the assembly of `design`, whose gears are among `parts`.
pub(super) fn claims(design: &Design, parts: &[Part], mechanism: &Mechanism) -> Vec<Claim> {
    let items = pieces(design, mechanism).map(|pieces| {
        let gears = parts
            .iter()
            .filter(|p| matches!(p.body.carrier, Carrier::Driver | Carrier::Follower))
            .map(|p| Item {
                name: p.body.name.as_str(),
                carrier: p.body.carrier,
                tree: &p.tree,
            });
        (gears.collect::<Vec<_>>(), pieces)
    });
    steps(design.class)
        .iter()
        .map(|step| {
            let claim = Claim::new(
                format!("assembly of the {}", step.name),
                "there is a straight way in, past everything that is in place by then",
            );
            match &items {
                Ok((gears, pieces)) => {
                    let own: Vec<Item> = pieces
                        .iter()
                        .map(|(name, carrier, tree)| Item {
                            name,
                            carrier: *carrier,
                            tree,
                        })
                        .collect();
                    let all: Vec<&Item> = gears.iter().chain(&own).collect();
                    decide(claim, step, &all, mechanism)
                }
                Err(error) => claim.undecided(&error.to_string()),
            }
        })
        .collect()
}

/// The printed pieces of support and slider as the recipe has them, in place.
fn pieces(design: &Design, mechanism: &Mechanism) -> Result<Vec<(String, Carrier, Tree)>> {
    let recipe = match design.recipe.bodies.is_empty() {
        true => layout::recipe(design, mechanism.motion)?,
        false => design.recipe.clone(),
    };
    let values = Values::new(&recipe.parameters);
    let listed: Vec<_> = recipe
        .bodies
        .iter()
        .flat_map(|body| body.pieces.iter().map(|piece| (body.name.as_str(), piece)))
        .collect();
    listed
        .par_iter()
        .map(|(body, piece)| {
            let carrier = match *body {
                "slider" => Carrier::Slider,
                "support" => Carrier::Support,
                other => return Err(Error::Internal(format!("pieces of a `{other}`"))),
            };
            let solid = primitive::build(&piece.features, &values)?;
            let mesh: Mesh = solid.one_body(&piece.name)?;
            Ok((piece.name.clone(), carrier, Tree::new(&mesh)))
        })
        .collect()
}

/// Tries the intended way at every driver angle, then the others.
fn decide(claim: Claim, step: &Step, items: &[&Item], mechanism: &Mechanism) -> Claim {
    let pick = |names: &[&'static str]| -> std::result::Result<Vec<&Item>, &'static str> {
        let find = |name: &&'static str| items.iter().find(|i| i.name == *name).copied();
        names.iter().map(|n| find(n).ok_or(*n)).collect()
    };
    let (moving, placed) = match (pick(step.moving), pick(step.placed)) {
        (Ok(moving), Ok(placed)) => (moving, placed),
        (Err(name), _) | (_, Err(name)) => {
            return claim.undecided(&format!("there is no {name}"));
        }
    };
    if moving
        .iter()
        .chain(&placed)
        .any(|i| i.tree.nodes.is_empty())
    {
        return claim.undecided("a part has no surface");
    }
    let count = if step.turning { PHASES } else { 1 };
    let phases: Vec<f64> = mechanism.motion.cycle().phases(count).collect();
    let ways = ways(Vector3::from(step.along));
    let way = |phi: f64, along: Vector3<f64>| Way {
        moving: &moving,
        placed: &placed,
        mechanism,
        phi,
        back: -along,
    };
    let open = ways.iter().find_map(|&along| {
        let phi = phases
            .par_iter()
            .find_map_first(|&phi| way(phi, along).blocked().is_none().then_some(phi))?;
        Some((along, phi))
    });
    let limit = "a straight way in";
    match open {
        Some((along, phi)) => claim
            .say(true, format!("comes in along {}", words(along)), limit)
            .at(Spot::phase(phi).towards(along.as_slice())),
        None => {
            let first = way(0.0, ways[0]).blocked();
            let why = first.map_or(String::new(), |b| {
                format!(
                    "; along {} the {} is in the way {:.1} mm before the place",
                    words(ways[0]),
                    b.by,
                    b.before
                )
            });
            claim
                .say(
                    false,
                    format!("none of {} ways is free{why}", ways.len() * phases.len()),
                    limit,
                )
                .at(Spot::phase(0.0).towards(ways[0].as_slice()))
        }
    }
}

/// Directions of ways in: the intended one, leaning ones around it, then along the axes.
fn ways(intended: Vector3<f64>) -> Vec<Vector3<f64>> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let across: Vec<Vector3<f64>> = axes
        .into_iter()
        .filter(|a| a.dot(&intended).abs() < 0.5)
        .collect();
    let leaning = across
        .iter()
        .flat_map(|a| [*a, -a])
        .map(|a| intended * LEAN.cos() + a * LEAN.sin());
    let along_axes = axes.into_iter().flat_map(|a| [a, -a]);
    let mut ways = vec![intended];
    ways.extend(leaning);
    ways.extend(along_axes.filter(|a| (a - intended).norm() > 0.5));
    ways
}

/// "−x", or the direction in numbers.
fn words(along: Vector3<f64>) -> String {
    let axis = along.iamax();
    if along[axis].abs() < 0.999 {
        return format!("({:.2}, {:.2}, {:.2})", along.x, along.y, along.z);
    }
    let sign = if along[axis] < 0.0 { "−" } else { "+" };
    format!("{sign}{}", ["x", "y", "z"][axis])
}

/// A straight way out of place, which is the way in backwards.
struct Way<'a> {
    moving: &'a [&'a Item<'a>],
    placed: &'a [&'a Item<'a>],
    mechanism: &'a Mechanism<'a>,
    phi: f64,
    /// Direction out, Σ.
    back: Vector3<f64>,
}

impl<'a> Way<'a> {
    /// What is in the way; `None` is proven free.
    fn blocked(&self) -> Option<Blocked<'a>> {
        // Faces may slide along each other: they are parted to either side of the way, or not at all.
        let lifts = [0.0, SEAT, -SEAT].map(|s| Vector3::z() * s);
        let mut first = None;
        for lift in lifts {
            match self.blocked_at(lift) {
                None => return None,
                Some(blocked) => first = first.or(Some(blocked)),
            }
        }
        first
    }

    fn blocked_at(&self, lift: Vector3<f64>) -> Option<Blocked<'a>> {
        let pairs: Vec<(&Item, &'a Item<'a>)> = self
            .moving
            .iter()
            .flat_map(|&m| self.placed.iter().map(move |&p| (m, p)))
            .collect();
        let look = |(m, p): (&Item, &'a Item<'a>)| {
            let length = self.length(m, p)?;
            (0..=LOOKS).find_map(|i| {
                let s = SEAT + length * (f64::from(i) / f64::from(LOOKS)).powi(2);
                let at = Placed::new(p.tree, m.tree, self.seen(m, p, lift + self.back * s));
                let touches = at.touch();
                touches.then_some(Blocked {
                    by: p.name,
                    before: s,
                })
            })
        };
        if let Some(blocked) = pairs.iter().find_map(|&pair| look(pair)) {
            return Some(blocked);
        }
        pairs.iter().find_map(|&(m, p)| self.doubtful(m, p, lift))
    }

    /// The first stretch of the way on which two bodies cannot be proven apart.
    fn doubtful(&self, m: &Item, p: &'a Item<'a>, lift: Vector3<f64>) -> Option<Blocked<'a>> {
        let half = 0.5 * self.length(m, p)?;
        let frame = self.mechanism.pose(p.carrier, self.phi);
        let still = Affine {
            constant: Vector3::zeros(),
            matrix: Matrix3::zeros(),
        };
        let drift = Drift {
            velocity: Affine {
                constant: frame.rotation.transpose() * self.back,
                ..still
            },
            acceleration: still,
            remainder: (0.0, 0.0),
        };
        let mut work = vec![(SEAT + half, half)];
        while let Some((s, half)) = work.pop() {
            let at = Placed::new(p.tree, m.tree, self.seen(m, p, lift + self.back * s));
            if at.doubtful((&drift, half, TOUCH), 1).is_empty() {
                continue;
            }
            if half < SHORTEST {
                return Some(Blocked {
                    by: p.name,
                    before: s,
                });
            }
            let half = 0.5 * half;
            work.extend([(s + half, half), (s - half, half)]);
        }
        None
    }

    /// The moving body, displaced by `by` (Σ), seen from the one in place.
    fn seen(&self, m: &Item, p: &Item, by: Vector3<f64>) -> Pose {
        let mut pose = self.mechanism.pose(m.carrier, self.phi);
        pose.translation += by;
        self.mechanism.pose(p.carrier, self.phi).inverse_mul(&pose)
    }

    /// How far it is until one body has left the other behind, mm; `None` where a body is empty.
    fn length(&self, m: &Item, p: &Item) -> Option<f64> {
        let reach = |item: &Item, sign: f64| {
            let pose = self.mechanism.pose(item.carrier, self.phi);
            let root = item.tree.nodes.first()?;
            let centre = self.back.dot(&pose.apply(root.centre));
            let extent = (pose.rotation.transpose() * self.back)
                .abs()
                .dot(&root.half);
            Some(centre + sign * extent)
        };
        Some((reach(p, 1.0)? - reach(m, -1.0)?).max(0.0) + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::pieces;

    #[test]
    fn every_printed_piece_comes_in_once_or_is_what_all_stands_on() {
        for class in [Class::R1, Class::R1T1, Class::R3, Class::R3T1] {
            let mut printed: Vec<String> =
                pieces::support(class).into_iter().map(|p| p.name).collect();
            if class == Class::R3T1 {
                printed.extend(pieces::slider().into_iter().map(|p| p.name));
            }
            let steps = steps(class);
            for name in &printed {
                let comes = steps.iter().any(|s| s.moving.contains(&name.as_str()));
                let stands = steps.iter().any(|s| s.placed.contains(&name.as_str()));
                assert!(comes || stands, "{class}: {name}");
                assert_eq!(comes, name != "base", "{class}: {name}");
            }
            assert!(steps.iter().any(|s| s.moving.contains(&"driver")));
            assert!(steps.iter().any(|s| s.moving.contains(&"follower")));
        }
    }
}
