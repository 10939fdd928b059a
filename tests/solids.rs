//! Solids of every class from synthetic designs: sound bodies that stay clear of each other.

mod synthetic;

use mpcgear::motion::Class;
use mpcgear::solid::Solids;
use mpcgear::solid::kernel::Solid;

/// Largest pairwise overlap over the period, mm³, with the pair and the phase in degrees.
fn overlaps(class: Class, phases: u32) -> Vec<String> {
    let (design, motion) = synthetic::uniform(class);
    let solids = Solids::build(&design, &motion).expect("builds");
    let mut found = Vec::new();
    for i in 0..phases {
        let phi = f64::from(i) * std::f64::consts::TAU / f64::from(phases);
        let placed: Vec<Solid> = solids
            .bodies
            .iter()
            .map(|b| Solid::new(&solids.placed(b, &design, &motion, phi), &b.name).expect("sound"))
            .collect();
        for a in 0..placed.len() {
            for b in a + 1..placed.len() {
                let volume = placed[a].intersection(&placed[b]).volume();
                if volume > 1e-9 {
                    let (a, b) = (&solids.bodies[a].name, &solids.bodies[b].name);
                    found.push(format!(
                        "{a}–{b} at {:.0}°: {volume:.4} mm³",
                        phi.to_degrees()
                    ));
                }
            }
        }
    }
    found
}

#[test]
fn bodies_of_1r_never_overlap() {
    assert_eq!(overlaps(Class::R1, 36), Vec::<String>::new());
}

#[test]
fn bodies_of_1r1t_never_overlap() {
    assert_eq!(overlaps(Class::R1T1, 36), Vec::<String>::new());
}

#[test]
fn bodies_of_3r_never_overlap() {
    assert_eq!(overlaps(Class::R3, 36), Vec::<String>::new());
}

#[test]
fn bodies_of_3r1t_never_overlap() {
    assert_eq!(overlaps(Class::R3T1, 36), Vec::<String>::new());
}
