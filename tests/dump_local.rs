mod synthetic;
use mpcgear::motion::Class;
use mpcgear::solid::{Mesh, Solids};
use std::io::Write;
fn stl(path: String, mesh: &Mesh) {
    let mut out = vec![0u8; 80];
    out.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in &mesh.triangles {
        out.extend([0u8; 12]);
        for &i in t {
            for c in mesh.vertices[i as usize] {
                out.extend((c as f32).to_le_bytes());
            }
        }
        out.extend([0u8; 2]);
    }
    std::fs::File::create(path)
        .unwrap()
        .write_all(&out)
        .unwrap();
}
#[test]
fn dump() {
    for class in Class::ALL {
        let (design, motion) = synthetic::uniform(class);
        let start = std::time::Instant::now();
        let m = mpcgear::solid::measure::Measures::of(&design, &motion);
        println!("{class} measure {:?} {m:?}", start.elapsed());
        let start = std::time::Instant::now();
        match Solids::build(&design, &motion) {
            Err(e) => println!("{class}: {e}"),
            Ok(s) => {
                println!("{class} build {:?}", start.elapsed());
                let dir = format!("/tmp/solid/{class}");
                std::fs::create_dir_all(&dir).unwrap();
                for b in &s.bodies {
                    println!(
                        "  {} {} tris vol {:.0} {:?}",
                        b.name,
                        b.mesh.triangles.len(),
                        b.mesh.volume(),
                        b.mesh.bounds()
                    );
                    stl(format!("{dir}/{}.stl", b.name), &b.mesh);
                }
                for p in &s.pieces {
                    println!("  piece {} {:?}", p.name, p.mesh.bounds().1 * 2.0);
                    stl(format!("{dir}/print_{}.stl", p.name), &p.mesh);
                }
                std::fs::write(
                    format!("{dir}/recipe.json"),
                    serde_json::to_string_pretty(&s.recipe).unwrap(),
                )
                .unwrap();
            }
        }
    }
}
