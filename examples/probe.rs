#![allow(missing_docs)]
use mpcgear::{motion::*, pipeline, solid::Mesh};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t = std::time::Instant::now();
    let (file, motion) = MotionFile::read(a[1].as_ref()).unwrap();
    let mut last = String::new();
    let r = pipeline::run(&file, &motion, &mut |p| {
        if p.stage != last {
            last = p.stage.into();
            println!(
                "{:6.1}s {} {:?} cands {}",
                t.elapsed().as_secs_f64(),
                p.stage,
                p.best_q,
                p.candidates
            );
        }
        std::ops::ControlFlow::Continue(())
    });
    match r {
        Err(e) => println!("ERR {e}"),
        Ok(o) => {
            let q = o
                .design
                .closure
                .iter()
                .map(|s| s.q)
                .fold(f64::INFINITY, f64::min);
            println!(
                "{:6.1}s k {} q {q:.3} residual {:.1e} problems {:#?}",
                t.elapsed().as_secs_f64(),
                o.design.sub_gear_pairs.len(),
                o.residual,
                o.design.problems
            );
            if let Some(p) = &o.proof {
                println!(
                    "escapes {} of {} overlap {} wall {:?}",
                    p.escapes.len(),
                    p.displacements,
                    p.overlap_max_mm3(),
                    p.walls
                );
                for x in &p.pairs {
                    println!("  {:?}", x.bodies);
                }
            }
            for b in &o.solids.bodies {
                let m: Mesh = o.solids.placed(b, &o.design, &motion, 0.0);
                println!("{} {} tris {:?}", b.name, m.triangles.len(), m.bounds());
                if a.len() > 2 {
                    let mut out = vec![0u8; 80];
                    out.extend((m.triangles.len() as u32).to_le_bytes());
                    for t in &m.triangles {
                        out.extend([0u8; 12]);
                        for &i in t {
                            for x in m.vertices[i as usize] {
                                out.extend((x as f32).to_le_bytes());
                            }
                        }
                        out.extend([0u8; 2]);
                    }
                    std::fs::create_dir_all(&a[2]).unwrap();
                    std::fs::write(format!("{}/{}.stl", a[2], b.name), out).unwrap();
                }
            }
            if a.len() > 2 {
                std::fs::write(
                    format!("{}/design.json", a[2]),
                    serde_json::to_string(&o.design).unwrap(),
                )
                .unwrap();
            }
        }
    }
}
