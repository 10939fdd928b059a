//! Are the bodies sound and do they stay apart: claims from the proof on the meshes.

use nalgebra::Vector3;

use super::claim::{Bound, Claim, Spot};
use super::failure::nearest_tooth;
use super::overlap::{self, OverlapSettings, Part, Place};
use super::{Mechanism, Proof};
use crate::design::{Design, Gear};
use crate::solid::assembly::Carrier;

/// Claims about each mesh by itself.
pub(super) fn mesh_claims(proof: &Proof) -> Vec<Claim> {
    let mesh = Claim::new("closed meshes", "every body is one closed, clean surface");
    let mut claims = vec![match proof.mesh_problems.first() {
        None => mesh.say(true, "no defects", "no defects"),
        Some(first) => mesh
            .say(false, first.to_string(), "no defects")
            .at(Spot::point(first.at)),
    }];
    for (body, wall) in &proof.walls {
        let claim = Claim::new(
            format!("walls of the {body}"),
            "nothing is too thin to print",
        );
        claims.push(match wall {
            Some(w) => claim
                .decide(w.thickness_mm, "mm", Bound::AtLeast(proof.minimum_wall_mm))
                .at(Spot::point(w.at)),
            None => claim.say(
                true,
                format!("> {:.2} mm", 1.25 * proof.minimum_wall_mm),
                &format!("≥ {} mm", proof.minimum_wall_mm),
            ),
        });
    }
    claims
}

/// Two claims a pair: apart, and apart when grown. Where the `proof` for grown parts fails, the parts
/// as drawn are walked again and take its place.
pub(super) fn overlap_claims(
    proof: &mut Proof,
    parts: &[Part],
    design: &Design,
    mechanism: &Mechanism,
) -> Vec<Claim> {
    let grown_by = proof.grown_by_mm;
    let mut claims = Vec::new();
    for pair in &mut proof.pairs {
        let [a, b] = pair.bodies.clone();
        let grown = pair.clone();
        // Parts that meet as drawn do so grown or not.
        if !grown.holds() && grown.colliding_steps == 0 && grown_by > 0.0 {
            let find = |name: &str| parts.iter().find(|p| p.body.name == name);
            if let (Some(first), Some(second)) = (find(&a), find(&b)) {
                let plain = OverlapSettings {
                    steps: proof.steps,
                    floor: 0.0,
                };
                *pair = overlap::apart((first, second), mechanism, &plain);
            }
        }
        let figure = match (pair.overlap_at, pair.doubts.len()) {
            (Some(_), _) => format!(
                "{} shared in {} steps of the turn",
                pair.overlap_mm3
                    .map_or("unmeasured volume".into(), |v| format!("{v:.4} mm³")),
                pair.colliding_steps
            ),
            (None, 0) => format!("{:.4} mm smallest gap", pair.gap_mm),
            (None, n) => format!("undecided in {n} steps of the turn"),
        };
        let spot = |place: Place| spot(design, mechanism, [&a, &b], place);
        let worst = pair.overlap_at.or(pair.doubts.first().copied());
        claims.push(
            Claim::new(
                format!("{a} and {b} stay apart"),
                "the parts never meet, at any angle, turning either way",
            )
            .say(pair.holds(), figure, "0 mm³, proven for every φ")
            .measured(pair.gap_mm, "mm", 0.0)
            .at(spot(worst.unwrap_or(pair.gap_at))),
        );
        let worst = grown.doubts.first().copied();
        claims.push(
            Claim::new(
                format!("{a} and {b} stay apart as printed"),
                "the same with every surface grown by the printer's tolerance",
            )
            .say(
                grown.holds(),
                format!("{:.4} mm smallest gap", grown.gap_mm),
                &format!("> {:.3} mm, proven for every φ", 2.0 * grown_by),
            )
            .measured(grown.gap_mm, "mm", 2.0 * grown_by)
            .at(spot(worst.unwrap_or(grown.gap_at))),
        );
    }
    claims
}

/// A place with the tooth it is on: the driver's if that body is one of the two, else the follower's.
fn spot(design: &Design, mechanism: &Mechanism, bodies: [&str; 2], place: Place) -> Spot {
    let tooth = [
        ("driver", Gear::Driver, Carrier::Driver),
        ("follower", Gear::Follower, Carrier::Follower),
    ]
    .into_iter()
    .filter(|(name, ..)| bodies.contains(name))
    .find_map(|(_, gear, carrier)| {
        let pose = mechanism.pose(carrier, place.phi);
        nearest_tooth(design, gear, pose.inverse_apply(Vector3::from(place.at)))
    });
    Spot::from(place).on(tooth)
}
