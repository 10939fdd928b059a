//! The output folder: complete, whole or not at all, and readable by others.

mod synthetic;

use std::collections::BTreeSet;
use std::fs;
use std::io::Read as _;
use std::path::Path;

use mpcgear::Error;
use mpcgear::disk::Folder;
use mpcgear::export::{self, File, Source, stl, tables};
use mpcgear::motion::Class;
use mpcgear::solid::Solids;

/// Files of the synthetic design of `class`, and its solids.
fn exported(class: Class) -> (Vec<File>, Solids) {
    let (mut design, motion) = synthetic::uniform(class);
    let solids = Solids::build(&design, &motion).expect("builds");
    design.recipe = solids.recipe.clone();
    let source = Source {
        design: &design,
        motion: &motion,
        solids: Some(&solids),
    };
    let files = export::files(&source, &tables::Summary::of(&design)).expect("exports");
    (files, solids)
}

fn contents<'a>(files: &'a [File], path: &str) -> &'a [u8] {
    let file = files.iter().find(|f| f.path == Path::new(path));
    &file.unwrap_or_else(|| panic!("{path} is missing")).bytes
}

#[test]
fn a_folder_has_everything_and_twice_the_same() {
    let (files, _) = exported(Class::R3T1);
    let names: BTreeSet<String> = files
        .iter()
        .map(|f| f.path.to_string_lossy().into_owned())
        .collect();
    for name in [
        "design.json",
        "summary.json",
        "poses.csv",
        "parts.md",
        "meshes/driver.stl",
        "meshes/follower.stl",
        "meshes/support.stl",
        "meshes/slider.stl",
        "meshes/assembly.3mf",
        "openscad/driver.scad",
        "openscad/follower.scad",
        "openscad/support.scad",
        "openscad/slider.scad",
        "openscad/assembly.scad",
        "openscad/customizer.scad",
        "print/driver.stl",
        "print/socket_cap.stl",
    ] {
        assert!(names.contains(name), "{name} is missing from {names:?}");
    }
    assert_eq!(names.len(), files.len(), "two files of one name");
    assert_eq!(files, exported(Class::R3T1).0, "not the same bytes again");
}

#[test]
fn summary_has_the_agreed_keys() {
    let (files, _) = exported(Class::R1);
    let text = String::from_utf8_lossy(contents(&files, "summary.json"));
    let keys: Vec<&str> = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix('"')?.split_once("\":"))
        .map(|(key, _)| key)
        .collect();
    assert_eq!(
        keys,
        [
            "name",
            "class",
            "k",
            "j",
            "driver_teeth",
            "contact_ratio",
            "feasible",
            "draft",
            "q_min",
            "q_mean",
            "q_star_min",
            "q_certified",
            "q_star_certified",
            "q_bound",
            "q_star_bound",
            "eta_min",
            "valid_time",
            "conjugation_residual_max",
            "overlap_max_mm3",
            "escapes",
            "wall_min_mm",
            "wall_seconds",
            "stages",
            "seed",
            "version",
            "choice_proved",
            "problems",
            "remedies",
            "remarks",
            "stopped"
        ]
    );
}

#[test]
fn poses_are_unit_quaternions_of_the_motion_without_sign_flips() {
    let (files, _) = exported(Class::R3);
    let mut reader = csv::Reader::from_reader(contents(&files, "poses.csv"));
    let header: Vec<String> = reader
        .headers()
        .expect("header")
        .iter()
        .map(String::from)
        .collect();
    assert_eq!(header, ["phi_deg", "x", "y", "z", "qw", "qx", "qy", "qz"]);
    let rows: Vec<Vec<f64>> = reader
        .deserialize()
        .map(|row| row.expect("numbers"))
        .collect();
    assert_eq!(rows.len(), 361);
    for (i, row) in rows.iter().enumerate() {
        assert!((row[0] - i as f64).abs() < 1e-9);
        // The synthetic motion turns by −φ about z: q = (cos φ/2, 0, 0, −sin φ/2).
        let half = (i as f64).to_radians() / 2.0;
        assert!((row[4] - half.cos()).abs() < 1e-8, "row {i}: {row:?}");
        assert!((row[7] + half.sin()).abs() < 1e-8, "row {i}: {row:?}");
    }
}

#[test]
fn stl_files_hold_the_meshes() {
    let (files, solids) = exported(Class::R1);
    for body in &solids.bodies {
        let bytes = contents(&files, &format!("meshes/{}.stl", body.name));
        let mesh = stl_io::read_stl(&mut std::io::Cursor::new(bytes)).expect("an STL file");
        assert_eq!(mesh.faces.len(), body.mesh.triangles.len());
        mesh.validate().expect("closed");
    }
    for piece in &solids.pieces {
        let (lo, _) = piece.mesh.bounds();
        assert!(lo.z.abs() < 1e-9, "{} does not lie on the bed", piece.name);
    }
}

#[test]
fn the_3mf_file_has_one_named_coloured_object_per_body_in_millimetres() {
    let (files, solids) = exported(Class::R3T1);
    let bytes = contents(&files, "meshes/assembly.3mf").to_vec();
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(bytes)).expect("a zip file");
    let mut text = |name: &str| {
        let mut text = String::new();
        let mut entry = zip.by_name(name).expect("part of the package");
        entry.read_to_string(&mut text).expect("text");
        text
    };
    assert!(text("[Content_Types].xml").contains("3dmanufacturing-3dmodel+xml"));
    assert!(text("_rels/.rels").contains("/3D/3dmodel.model"));
    let model = text("3D/3dmodel.model");
    assert!(model.contains(r#"unit="millimeter""#));
    assert_eq!(model.matches("<item ").count(), solids.bodies.len());
    for body in &solids.bodies {
        let head = format!(r#"type="model" name="{}""#, body.name);
        assert_eq!(model.matches(&head).count(), 1);
    }
    let triangles: usize = solids.bodies.iter().map(|b| b.mesh.triangles.len()).sum();
    assert_eq!(model.matches("<triangle ").count(), triangles);
}

fn files(names: &[&str]) -> Vec<File> {
    names
        .iter()
        .map(|name| File::new(*name, name.as_bytes()))
        .collect()
}

fn listing(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect()
}

/// Writes a design folder as one run does.
fn publish(folder: &Path, files: &[File]) -> mpcgear::Result<()> {
    Folder::claim(folder)?.publish(files)
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| name.to_string()).collect()
}

#[test]
fn a_new_folder_appears_with_its_parents_and_leaves_nothing_beside() {
    let place = tempfile::tempdir().expect("a folder");
    let out = place.path().join("a/b");
    drop(Folder::claim(&out).expect("writable"));
    assert!(!out.exists(), "checking must not make the folder");
    publish(&out, &files(&["design.json", "meshes/driver.stl"])).expect("writes");
    assert_eq!(listing(place.path()), set(&["a"]));
    assert_eq!(listing(&place.path().join("a")), set(&["b"]));
    assert_eq!(listing(&out), set(&["design.json", "meshes"]));
    assert_eq!(listing(&out.join("meshes")), set(&["driver.stl"]));
}

#[test]
fn a_second_run_replaces_its_own_files_and_keeps_the_users() {
    let place = tempfile::tempdir().expect("a folder");
    let out = place.path();
    publish(
        out,
        &files(&["design.json", "meshes/slider.stl", "parts.md"]),
    )
    .expect("writes");
    fs::write(out.join("notes.txt"), "mine").expect("writes");
    publish(out, &files(&["design.json", "meshes/driver.stl"])).expect("writes");
    assert_eq!(listing(out), set(&["design.json", "meshes", "notes.txt"]));
    assert_eq!(listing(&out.join("meshes")), set(&["driver.stl"]));
    assert_eq!(fs::read(out.join("notes.txt")).expect("kept"), b"mine");
}

#[test]
fn a_failed_run_leaves_the_old_design_as_it_was() {
    let place = tempfile::tempdir().expect("a folder");
    let out = place.path();
    publish(out, &files(&["design.json", "meshes/driver.stl"])).expect("writes");
    // A path through a file cannot be written.
    let broken = files(&["design.json", "meshes", "meshes/driver.stl"]);
    let error = publish(out, &broken).expect_err("cannot be written");
    assert_eq!(error.exit_code(), 2);
    assert_eq!(listing(out), set(&["design.json", "meshes"]));
    assert_eq!(listing(&out.join("meshes")), set(&["driver.stl"]));
}

#[test]
fn folders_that_cannot_be_written_are_refused_before_the_work() {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("file");
    fs::write(&file, "x").expect("writes");
    for bad in [file.clone(), file.join("below"), "/proc/nowhere/out".into()] {
        let error = Folder::claim(&bad).expect_err("not writable");
        assert!(matches!(error, Error::Io { .. }), "{error}");
        assert_eq!(error.exit_code(), 2);
        assert!(
            error.to_string().contains(&*bad.to_string_lossy()),
            "{error}"
        );
    }
}

#[test]
fn somebody_elses_folder_is_refused() {
    let place = tempfile::tempdir().expect("a folder");
    fs::create_dir(place.path().join("print")).expect("makes");
    let error = Folder::claim(place.path()).expect_err("not ours");
    assert!(error.to_string().contains("print"), "{error}");
    publish(place.path(), &files(&["design.json"])).expect_err("not ours");
    assert_eq!(listing(place.path()), set(&["print"]));
}

#[test]
fn degenerate_triangles_do_not_spoil_an_stl_file() {
    let mesh = mpcgear::solid::Mesh {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1e-12, 0.0]],
        triangles: vec![[0, 1, 2], [0, 1, 1]],
    };
    let bytes = stl::binary(&mesh).expect("encodes");
    assert_eq!(bytes.len(), 84 + 2 * 50);
    for triangle in bytes[84..].chunks(50) {
        let number = |f: &[u8]| f32::from_le_bytes([f[0], f[1], f[2], f[3]]);
        let numbers: Vec<f32> = triangle[..48].chunks(4).map(number).collect();
        assert!(numbers.iter().all(|x| x.is_finite()), "{numbers:?}");
        // Readers take the zero normal as "work it out"; anything else has to be a direction.
        let length = numbers[..3].iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!(length == 0.0 || (length - 1.0).abs() < 1e-5, "{numbers:?}");
    }
}
