//! `export --to gltf` and `--to poses`: what a reader of the file makes of it is where the bodies are.

#![allow(clippy::unwrap_used)] // a failing unwrap is a failing test

mod synthetic;

use std::process::Command;

use mpcgear::design::Design;
use mpcgear::export::Source;
use mpcgear::export::format::{Format, render};
use mpcgear::motion::{Class, Motion};
use mpcgear::solid::Solids;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;

/// The parts of a binary glTF file, taken apart by the specification.
struct Glb {
    document: Value,
    binary: Vec<u8>,
}

fn word(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

impl Glb {
    fn parse(bytes: &[u8]) -> Glb {
        assert_eq!(&bytes[..4], b"glTF");
        assert_eq!(word(bytes, 4), 2, "version");
        assert_eq!(word(bytes, 8), bytes.len());
        let text = word(bytes, 12);
        assert_eq!(&bytes[16..20], b"JSON");
        let next = 20 + text;
        let length = word(bytes, next);
        assert_eq!(&bytes[next + 4..next + 8], b"BIN\0");
        assert_eq!(next + 8 + length, bytes.len());
        assert!(text.is_multiple_of(4) && length.is_multiple_of(4));
        let document: Value = serde_json::from_slice(&bytes[20..next]).unwrap();
        assert_eq!(document["buffers"][0]["byteLength"], length);
        Glb {
            document,
            binary: bytes[next + 8..].to_vec(),
        }
    }

    fn at(&self, path: &str) -> &Value {
        let found = self.document.pointer(path);
        found.unwrap_or_else(|| panic!("there is no {path}"))
    }

    fn list(&self, path: &str) -> &[Value] {
        self.at(path).as_array().unwrap()
    }

    /// The raw words of an accessor.
    fn words(&self, accessor: &Value) -> Vec<[u8; 4]> {
        let accessor = self.at(&format!("/accessors/{accessor}"));
        let parts = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            other => panic!("{other}"),
        };
        let view = self.at(&format!("/bufferViews/{}", accessor["bufferView"]));
        let number = |key: &str| view[key].as_u64().unwrap() as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        assert_eq!(number("byteLength"), 4 * parts * count);
        assert_eq!(number("byteOffset") % 4, 0);
        let bytes = &self.binary[number("byteOffset")..][..number("byteLength")];
        bytes.chunks(4).map(|w| w.try_into().unwrap()).collect()
    }

    fn floats(&self, accessor: &Value) -> Vec<f64> {
        let words = self.words(accessor).into_iter();
        words.map(|w| f64::from(f32::from_le_bytes(w))).collect()
    }

    fn vectors(&self, accessor: &Value) -> Vec<Vector3<f64>> {
        let floats = self.floats(accessor);
        floats.chunks(3).map(Vector3::from_column_slice).collect()
    }

    fn node(&self, name: &str) -> usize {
        let nodes = self.list("/nodes");
        nodes.iter().position(|n| n["name"] == name).unwrap()
    }

    /// Rotation and place of a node at key `key` of the animation, or at rest.
    fn pose(&self, node: usize, key: Option<usize>) -> (UnitQuaternion<f64>, Vector3<f64>) {
        let of = |path: &str, count: usize| -> Vec<f64> {
            let rest = &self.list("/nodes")[node][path];
            let channels = self.list("/animations/0/channels").iter();
            let channel = key.and_then(|key| {
                let mut channels =
                    channels.filter(|c| c["target"]["node"] == node && c["target"]["path"] == path);
                channels.next().map(|channel| (key, channel))
            });
            match channel {
                Some((key, channel)) => {
                    let sampler =
                        self.at(&format!("/animations/0/samplers/{}", channel["sampler"]));
                    self.floats(&sampler["output"])[key * count..][..count].to_vec()
                }
                None => rest.as_array().map_or(vec![0.0; count], |rest| {
                    rest.iter().map(|x| x.as_f64().unwrap()).collect()
                }),
            }
        };
        let q = of("rotation", 4);
        let q = UnitQuaternion::new_normalize(Quaternion::new(q[3], q[0], q[1], q[2]));
        (q, Vector3::from_vec(of("translation", 3)))
    }

    /// Vertices of a body in the scene, m, y up.
    fn placed(&self, name: &str, key: Option<usize>) -> Vec<Vector3<f64>> {
        let node = self.node(name);
        let mesh = &self.list("/nodes")[node]["mesh"];
        let mesh = self.at(&format!("/meshes/{mesh}/primitives/0/attributes/POSITION"));
        let (turn, place) = self.pose(node, key);
        let (root, _) = self.pose(0, None);
        let vertices = self.vectors(mesh).into_iter();
        vertices.map(|v| root * (turn * v + place)).collect()
    }
}

fn with_file(
    (design, motion): (Design, Motion),
    part: Option<&str>,
    look: impl FnOnce(&Glb, &Source),
) {
    let solids = Solids::build(&design, &motion).unwrap();
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let files = render(&source, Format::Gltf, part).unwrap();
    let [file] = &files[..] else {
        panic!("{} files", files.len())
    };
    assert_eq!(file.path.extension().unwrap(), "glb");
    look(&Glb::parse(&file.bytes), &source);
    valid(&file.bytes);
}

/// Khronos' own validator, which the setup of the tests brings.
fn valid(bytes: &[u8]) {
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/target/node");
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    let script = "const fs = require('fs');
        require('gltf-validator').validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))
            .then(report => console.log(JSON.stringify(report.issues)))";
    let output = Command::new("node")
        .env("NODE_PATH", format!("{here}/node_modules"))
        .args(["-e", script])
        .arg(file.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "sh .ci/setup --tests installs it: {said}"
    );
    let issues: Value = serde_json::from_slice(&output.stdout).unwrap();
    for kind in ["numErrors", "numWarnings"] {
        assert_eq!(issues[kind], 0, "{issues}");
    }
}

#[test]
fn bodies_are_named_coloured_and_in_metres_with_y_up() {
    with_file(synthetic::uniform(Class::R3T1), None, |glb, source| {
        let names = ["driver", "follower", "support", "slider"];
        for name in names {
            let node = glb.node(name);
            assert!(glb.list("/nodes/0/children").contains(&node.into()));
            let materials = glb.list("/materials").iter();
            assert_eq!(materials.filter(|m| m["name"] == name).count(), 1);
        }
        assert_eq!(glb.list("/meshes").len(), names.len());
        for body in &source.solids.unwrap().bodies {
            let expected = source.placed(body);
            let found = glb.placed(&body.name, None);
            assert_eq!(found.len(), expected.vertices.len());
            for (a, [x, y, z]) in found.iter().zip(&expected.vertices) {
                let b = Vector3::new(*x, *z, -*y) * 1e-3;
                assert!((a - b).norm() < 1e-8, "{}: {a} {b}", body.name);
            }
            let mesh = glb.node(&body.name) - 1;
            let indices = glb.words(glb.at(&format!("/meshes/{mesh}/primitives/0/indices")));
            let flat = indices.iter().map(|w| u32::from_le_bytes(*w));
            assert!(flat.eq(body.mesh.triangles.iter().flatten().copied()));
        }
    });
}

#[test]
fn the_animation_goes_through_the_whole_cycle() {
    for (design, steps) in [
        (synthetic::example("wobble_lift_3r1t"), 180),
        (synthetic::unequal(Class::R1), 360),
    ] {
        with_file(design, None, |glb, source| {
            let drive = source.design.settings.gear.drive();
            for key in [0, 50, 133, steps] {
                let phi = std::f64::consts::TAU * key as f64 / 180.0;
                for body in &source.solids.unwrap().bodies {
                    let pose = body.carrier.pose(source.motion, drive, phi);
                    let found = glb.placed(&body.name, Some(key));
                    for (a, v) in found.iter().zip(&body.mesh.vertices).step_by(97) {
                        let b = pose.apply(Vector3::from(*v)) * 1e-3;
                        let b = Vector3::new(b.x, b.z, -b.y);
                        assert!((a - b).norm() < 3e-8, "{} at key {key}: {a} {b}", body.name);
                    }
                }
            }
            let times = glb.floats(glb.at("/animations/0/samplers/0/input"));
            assert_eq!(times.len(), steps + 1);
            assert!(times.windows(2).all(|pair| pair[1] > pair[0]));
        });
    }
}

#[test]
fn a_driver_that_goes_there_comes_back() {
    with_file(synthetic::example("flapping_wing_3r"), None, |glb, _| {
        for name in ["driver", "follower"] {
            let there = glb.placed(name, Some(40));
            assert!((there[7] - glb.placed(name, Some(0))[7]).norm() > 1e-4);
            assert_eq!(there, glb.placed(name, Some(360 - 40)));
        }
    });
}

#[test]
fn one_body_alone_may_be_had() {
    with_file(synthetic::uniform(Class::R1), Some("follower"), |glb, _| {
        assert_eq!(glb.list("/meshes").len(), 1);
        assert_eq!(glb.list("/nodes/0/children"), [1]);
    });
}

#[test]
fn all_poses_are_those_of_both_gears() {
    let (design, motion) = synthetic::unequal(Class::R1);
    let solids = Solids::build(&design, &motion).unwrap();
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let files = render(&source, Format::Poses, None).unwrap();
    assert_eq!(files[0].path.to_str(), Some("all_poses.csv"));
    let mut reader = csv::Reader::from_reader(&files[0].bytes[..]);
    let names = reader.headers().unwrap().clone();
    assert_eq!(names.len(), 16);
    assert!(
        names
            .iter()
            .all(|n| n.contains("_deg") || n.contains("_mm") || n.contains("_q"))
    );
    let rows: Vec<Vec<f64>> = reader.deserialize().map(Result::unwrap).collect();
    // Two periods of the motion are a turn of a driver with twice as many teeth.
    assert_eq!(rows.len(), 721);
    let drive = design.settings.gear.drive();
    for row in rows.iter().step_by(60) {
        assert!((row[1] - row[0] / 2.0).abs() < 1e-8);
        let phi = row[0].to_radians();
        for (at, pose) in [(2, drive.state(phi).pose), (9, motion.state(phi).pose)] {
            let place = Vector3::from_column_slice(&row[at..at + 3]);
            assert!((place - pose.translation).norm() < 1e-8);
            let [w, x, y, z] = [3, 4, 5, 6].map(|i| row[at + i]);
            let q = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            assert!(q.angle_to(&pose.quaternion()) < 1e-7);
        }
    }
    let turned_on = |i: usize| rows.windows(2).all(|r| (r[1][i] - r[0][i]).abs() < 0.02);
    assert!((5..9).chain(12..16).all(turned_on), "signs jump");
}
