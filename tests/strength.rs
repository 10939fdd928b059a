//! probe
use mpcgear::design::{Gear, Stored};
use mpcgear::load::Material;
use mpcgear::strength::tooth_grid::Tooth;
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
                let t = std::time::Instant::now();
                let s = [1, 2, 3].map(|f| ToothStrength::of(&tooth, Material::Pla, f));
                let all: Vec<_> = s.into_iter().flatten().collect();
                println!("{gear:?} {k} {j} {:.1?}", t.elapsed());
                for i in [0, 2, 4, 6, 8] {
                    let r = |f: usize| all[f].responses[i];
                    let t = |f: fn(&mpcgear::strength::tooth::Response) -> f64| [0,1,2].map(|i| (f(&r(i))*1000.0).round()/1000.0);
                    println!("   {:?} {:?} {:?}", t(|r| 1.0 / r.compliance), t(|r| r.stress), t(|r| r.tension_across_layers));
                }
            }
        }
    }
}
