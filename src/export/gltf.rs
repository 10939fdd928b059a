//! `NAME.glb`: the bodies as coloured, named nodes that move through a whole cycle (binary glTF 2.0).
//!
//! Metres, seconds, y up, as the specification wants it: a root node turns Σ's z upwards.

use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::{File, Source, freecad, threemf};
use crate::motion::{Drive, Motion, Pose};
use crate::solid::assembly::{Carrier, SolidBody};
use crate::solid::{Mesh, Solids};
use crate::{Error, Result};

/// Poses of a period of the motion; players turn evenly between two of them.
const STEPS: usize = 180;

/// How long a turn of the driver takes, there and back where it goes there and back, s.
const SECONDS: f64 = 6.0;

/// Numbers of the specification: types of components, uses of a view, kinds of chunk.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const JSON_CHUNK: &[u8] = b"JSON";
const BINARY_CHUNK: &[u8] = b"BIN\0";

/// The mechanism as one file; `part` restricts it to one body.
///
/// # Errors
/// [`Error::Internal`] when the encoder fails or the file would be larger than the format allows.
pub fn file(source: &Source, solids: &Solids, part: Option<&str>) -> Result<File> {
    let mut scene = Scene::default();
    let bodies = solids.bodies.iter();
    for body in bodies.filter(|b| part.is_none_or(|part| part == b.name)) {
        scene.add(source, body);
    }
    let name = freecad::stem(source.design);
    Ok(File::new(format!("{name}.glb"), scene.into_bytes(source)?))
}

/// The phases shown, with their times in s.
fn course(motion: &Motion, drive: Drive) -> Vec<(f64, f64)> {
    let cycle = motion.cycle();
    let periods = if cycle.wraps() { drive.copies() } else { 1 };
    let steps = STEPS * periods;
    let there = (0..=steps).map(|i| cycle.start() + cycle.length() * i as f64 / STEPS as f64);
    let mut phases: Vec<f64> = there.collect();
    if !cycle.wraps() {
        phases.extend((0..steps).rev().map(|i| cycle.part(i, STEPS)));
    }
    let last = (phases.len() - 1) as f64;
    let time = |i: usize| SECONDS * i as f64 / last;
    phases
        .into_iter()
        .enumerate()
        .map(|(i, phi)| (phi, time(i)))
        .collect()
}

/// What the file has, as it is put together; the first node is the root.
#[derive(Default)]
struct Scene {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
}

impl Scene {
    /// A body: its mesh about a point that its rotation leaves alone, so that the way between two poses is
    /// a turn about it.
    fn add(&mut self, source: &Source, body: &SolidBody) {
        let drive = source.design.settings.gear.drive();
        let centre = match body.carrier {
            Carrier::Driver => drive.axis_point(),
            _ => Vector3::zeros(),
        };
        let index = self.meshes.len();
        self.materials.push(json!({
            "name": body.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": linear(threemf::colour(&body.name)),
                "metallicFactor": 0.0,
                "roughnessFactor": 0.6,
            },
        }));
        let positions = self.positions(&body.mesh, centre);
        let indices = self.indices(&body.mesh);
        self.meshes.push(json!({
            "name": body.name,
            "primitives": [{
                "attributes": { "POSITION": positions }, "indices": indices, "material": index,
            }],
        }));
        let at = |phi: f64| -> Pose { body.carrier.pose(source.motion, drive, phi) };
        let course = course(source.motion, drive);
        let mut rotations: Vec<[f64; 4]> = Vec::new();
        for (phi, _) in &course {
            rotations.push(continued(at(*phi).quaternion(), rotations.last()));
        }
        let metres = |phi: f64| -> [f64; 3] { (1e-3 * at(phi).apply(centre)).into() };
        let places: Vec<[f64; 3]> = course.iter().map(|(phi, _)| metres(*phi)).collect();
        let rotation = continued(at(0.0).quaternion(), None).map(single);
        let translation = metres(0.0).map(single);
        self.nodes.push(json!({
            "name": body.name, "mesh": index, "rotation": rotation, "translation": translation,
        }));
        let node = self.nodes.len();
        let times: Vec<[f64; 1]> = course.iter().map(|(_, time)| [*time]).collect();
        if matches!(body.carrier, Carrier::Driver | Carrier::Follower) {
            self.channel((node, "rotation"), &times, ("VEC4", &rotations));
        }
        if matches!(body.carrier, Carrier::Follower | Carrier::Slider) {
            self.channel((node, "translation"), &times, ("VEC3", &places));
        }
    }

    fn channel<const N: usize>(
        &mut self,
        (node, path): (usize, &str),
        times: &[[f64; 1]],
        (kind, values): (&str, &[[f64; N]]),
    ) {
        let input = self.floats(times, "SCALAR", None);
        let output = self.floats(values, kind, None);
        let sampler = self.samplers.len();
        let interpolation = "LINEAR";
        self.samplers
            .push(json!({ "input": input, "output": output, "interpolation": interpolation }));
        self.channels
            .push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }

    fn positions(&mut self, mesh: &Mesh, centre: Vector3<f64>) -> usize {
        let place = |v: &[f64; 3]| -> [f64; 3] { (1e-3 * (Vector3::from(*v) - centre)).into() };
        let places: Vec<[f64; 3]> = mesh.vertices.iter().map(place).collect();
        self.floats(&places, "VEC3", Some(VERTICES))
    }

    fn indices(&mut self, mesh: &Mesh) -> usize {
        let numbers = mesh.triangles.iter().flatten();
        let bytes = numbers.flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(bytes, Some(INDICES));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "type": "SCALAR",
            "count": 3 * mesh.triangles.len(),
        }));
        self.accessors.len() - 1
    }

    /// Rows of numbers in single precision, with their bounds.
    fn floats<const N: usize>(
        &mut self,
        rows: &[[f64; N]],
        kind: &str,
        used: Option<u32>,
    ) -> usize {
        let rows: Vec<[f32; N]> = rows.iter().map(|row| row.map(single)).collect();
        let bound = |choose: fn(f32, f32) -> f32| -> Vec<f32> {
            let columns = 0..N;
            let column = |i: usize| rows.iter().map(move |row| row[i]).reduce(choose);
            columns.filter_map(column).collect()
        };
        let (low, high) = (bound(f32::min), bound(f32::max));
        let bytes = rows.iter().flatten().flat_map(|x| x.to_le_bytes());
        let view = self.view(bytes.collect(), used);
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "type": kind,
            "count": rows.len(), "min": low, "max": high,
        }));
        self.accessors.len() - 1
    }

    /// Bytes of numbers of four bytes each, so that all views begin where such numbers may.
    fn view(&mut self, bytes: Vec<u8>, used: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len(),
        });
        if let Some(used) = used {
            view["target"] = used.into();
        }
        self.binary.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn into_bytes(self, source: &Source) -> Result<Vec<u8>> {
        let children: Vec<usize> = (1..=self.nodes.len()).collect();
        // A quarter turn back about x: z of Σ becomes y.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let upright = [-half, 0.0, 0.0, half].map(single);
        let root = json!({
            "name": source.design.name, "children": children,
            "rotation": upright,
        });
        let nodes: Vec<Value> = [root].into_iter().chain(self.nodes).collect();
        let mut document = json!({
            "asset": { "version": "2.0", "generator": super::maker(source.design) },
            "scene": 0,
            "scenes": [{ "name": source.design.name, "nodes": [0] }],
            "nodes": nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary.len() }],
        });
        if !self.channels.is_empty() {
            document["animations"] = json!([{
                "name": "cycle", "channels": self.channels, "samplers": self.samplers,
            }]);
        }
        let text = serde_json::to_vec(&document).map_err(|e| internal(&e.to_string()))?;
        container(&[(JSON_CHUNK, text, b' '), (BINARY_CHUNK, self.binary, 0)])
    }
}

/// The chunks, each padded to a multiple of four bytes, behind the head of the file.
fn container(chunks: &[(&[u8], Vec<u8>, u8)]) -> Result<Vec<u8>> {
    let size = |bytes: usize| u32::try_from(bytes).map_err(|_| internal("more than 4 GB"));
    let mut body = Vec::new();
    for (kind, bytes, filling) in chunks {
        let length = bytes.len().next_multiple_of(4);
        body.extend(size(length)?.to_le_bytes());
        body.extend(*kind);
        body.extend(bytes);
        body.extend(std::iter::repeat_n(*filling, length - bytes.len()));
    }
    let mut file = b"glTF".to_vec();
    file.extend(2u32.to_le_bytes());
    file.extend(size(12 + body.len())?.to_le_bytes());
    file.extend(body);
    Ok(file)
}

fn internal(what: &str) -> Error {
    Error::Internal(format!("glTF: {what}"))
}

/// (x, y, z, w) on the side of the one before.
fn continued(q: UnitQuaternion<f64>, before: Option<&[f64; 4]>) -> [f64; 4] {
    let q: [f64; 4] = q.coords.into();
    let along = |b: &[f64; 4]| b.iter().zip(q).map(|(a, b)| a * b).sum::<f64>();
    match before.map(along) {
        Some(along) if along < 0.0 => q.map(|x| -x),
        _ => q,
    }
}

/// In single precision, without a negative zero.
fn single(x: f64) -> f32 {
    x as f32 + 0.0
}

/// A colour `#RRGGBB` as linear light with full opacity.
fn linear(colour: &str) -> [f32; 4] {
    let channel = |at: usize| {
        let digits = colour.get(at..at + 2).unwrap_or("80");
        let value = f64::from(u8::from_str_radix(digits, 16).unwrap_or(128)) / 255.0;
        single(match value <= 0.04045 {
            true => value / 12.92,
            false => ((value + 0.055) / 1.055).powf(2.4),
        })
    };
    [channel(1), channel(3), channel(5), 1.0]
}
