//! probe
use mpcgear::design::{Gear, Stored};
use mpcgear::load::Material;
use mpcgear::strength::tooth_grid::{Tooth, ToothGrid};
use mpcgear::strength::{Hub, Teeth, ToothStrength};
use std::path::Path;

#[test]
fn probe() {
    for name in ["trefoil", "wobble_lift_3r1t", "pick_and_place_3r"] {
        let path = format!("/tmp/o_{name}/design.json");
        let (design, _, _) = Stored::read(Path::new(&path)).unwrap().with_motion().unwrap();
        let t = std::time::Instant::now();
        let teeth = Teeth::of(&design, [Material::Pla; 2]);
        println!("{name} {:?} {}", t.elapsed(), teeth.is_some());
        for gear in [Gear::Driver, Gear::Follower] {
            for (k, j) in [(0, 0), (1, 3), (3, 7)] {
                let pair = &design.sub_gear_pairs[k];
                let tooth = Tooth::new(&pair.teeth[j], gear, design.section_of(pair), Hub::of(&design, gear)).unwrap();
                for fineness in [1, 2, 3] {
                    let t = std::time::Instant::now();
                    let Some(s) = ToothStrength::of(&tooth, Material::Pla, fineness) else {
                        println!("{gear:?} {k} {j} {fineness} none: grid {}", ToothGrid::new(&tooth, fineness).is_some());
                        continue;
                    };
                    println!(
                        "{gear:?} {k} {j} {fineness} {:.1?} k {:.1?} s {:.2?} z {:.2?}",
                        t.elapsed(),
                        s.responses.iter().map(|r| 1.0 / r.compliance).collect::<Vec<_>>(),
                        s.responses.iter().map(|r| r.stress).collect::<Vec<_>>(),
                        s.responses.iter().map(|r| r.tension_across_layers).collect::<Vec<_>>()
                    );
                }
            }
        }
    }
}
