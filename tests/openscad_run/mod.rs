//! Runs OpenSCAD headless and looks at what it really did: its exit code proves nothing.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use mpcgear::solid::Mesh;

/// Whether OpenSCAD is there; says so loudly if not, and fails where it is required.
pub fn installed() -> bool {
    let found = Command::new("openscad").arg("--version").output().is_ok();
    let required = std::env::var("MPCGEAR_REQUIRE_CAD").is_ok_and(|v| v == "1");
    assert!(found || !required, "openscad is required but not installed");
    if !found {
        eprintln!("NOT TESTED: openscad is not installed (apt-get install openscad)");
    }
    found
}

/// One script to be run, with parameter overrides.
pub struct Run {
    script: PathBuf,
    arguments: Vec<String>,
}

/// What a run left.
pub struct Outcome {
    /// Name of the run, for messages.
    name: String,
    /// Exit code 0.
    success: bool,
    /// All that OpenSCAD said.
    log: String,
    /// The mesh it wrote.
    mesh: Option<Mesh>,
}

impl Run {
    /// The script as it is.
    pub fn new(script: &Path) -> Run {
        Run {
            script: script.into(),
            arguments: Vec::new(),
        }
    }

    #[allow(dead_code)] // not every test file overrides
    /// Sets a parameter to an OpenSCAD literal.
    pub fn set(mut self, name: &str, value: &str) -> Run {
        self.arguments
            .extend(["-D".into(), format!("{name}={value}")]);
        self
    }

    /// Renders to STL; `label` names the file beside the script.
    pub fn stl(self, label: &str) -> Outcome {
        let stl = self.script.with_extension(format!("{label}.stl"));
        let _ = std::fs::remove_file(&stl);
        let output = Command::new("openscad")
            .args(["--hardwarnings", "--export-format", "binstl", "-o"])
            .arg(&stl)
            .args(&self.arguments)
            .arg(&self.script)
            .output()
            .expect("openscad runs");
        Outcome {
            name: format!("{} {}", self.script.display(), self.arguments.join(" ")),
            success: output.status.success(),
            log: String::from_utf8_lossy(&output.stderr).into_owned(),
            mesh: std::fs::read(&stl).ok().map(|bytes| read(&bytes)),
        }
    }
}

impl Outcome {
    /// The mesh, after checking log and file: no complaint, one simple closed piece.
    pub fn one_closed_body(self) -> Mesh {
        let (name, log) = (&self.name, &self.log);
        assert!(self.success, "{name}: failed\n{log}");
        let bad = ["ERROR", "WARNING", "EXPORT-WARNING", "TRACE"];
        let complaints: Vec<&str> = log
            .lines()
            .filter(|line| bad.iter().any(|b| line.starts_with(b)))
            .collect();
        assert!(complaints.is_empty(), "{name}: {complaints:?}");
        assert!(has(log, "Simple:", "yes"), "{name}: not simple\n{log}");
        assert!(has(log, "Volumes:", "2"), "{name}: not one piece\n{log}");
        let mesh = self.mesh.expect("a file was written");
        let faults = faults(&mesh);
        assert!(faults.is_empty(), "{name}: {faults:?}");
        mesh
    }

    /// The message of a run that has to be refused.
    #[allow(dead_code)] // not every test file refuses
    pub fn refusal(self) -> String {
        assert!(
            !self.success,
            "{}: was not refused\n{}",
            self.name, self.log
        );
        self.log
    }
}

fn has(log: &str, key: &str, value: &str) -> bool {
    log.lines()
        .filter_map(|line| line.trim().strip_prefix(key))
        .any(|rest| rest.trim() == value)
}

/// Binary STL to an indexed mesh; corners at the same place become one.
fn read(bytes: &[u8]) -> Mesh {
    let stl = stl_io::read_stl(&mut std::io::Cursor::new(bytes)).expect("an STL file");
    Mesh {
        vertices: stl
            .vertices
            .iter()
            .map(|v| [v[0], v[1], v[2]].map(f64::from))
            .collect(),
        triangles: stl
            .faces
            .iter()
            .map(|f| f.vertices.map(|i| i as u32))
            .collect(),
    }
}

/// What is wrong with a mesh that should be one closed, oriented body.
pub fn faults(mesh: &Mesh) -> Vec<String> {
    let mut faults = Vec::new();
    // Triangles that lost an edge in the rounding to f32 hold nothing together.
    let triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .copied()
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for [a, b, c] in &triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_default() += 1;
        }
    }
    let open = edges
        .iter()
        .filter(|((a, b), count)| edges.get(&(*b, *a)) != Some(count))
        .count();
    if open > 0 {
        faults.push(format!("{open} edges without a partner"));
    }
    let bodies = components(mesh.vertices.len(), &triangles);
    if bodies != 1 {
        faults.push(format!("{bodies} pieces"));
    }
    if mesh.volume() <= 0.0 {
        faults.push("inside out".into());
    }
    faults
}

/// Number of connected surfaces.
fn components(vertices: usize, triangles: &[[u32; 3]]) -> usize {
    let mut parent: Vec<usize> = (0..vertices).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    for t in triangles {
        for pair in [(t[0], t[1]), (t[1], t[2])] {
            let (a, b) = (
                root(&mut parent, pair.0 as usize),
                root(&mut parent, pair.1 as usize),
            );
            parent[a] = b;
        }
    }
    let used: std::collections::HashSet<usize> = triangles
        .iter()
        .flatten()
        .map(|&i| root(&mut parent, i as usize))
        .collect();
    used.len()
}
