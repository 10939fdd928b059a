//! 3MF: all bodies in one file, named and coloured (3MF core specification 1.3).
//!
//! Written here rather than by a crate: the ones that write 3MF put colours into an element that
//! the core specification does not know.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::Source;
use crate::motion::Pose;
use crate::solid::assembly::SolidBody;
use crate::solid::{Mesh, Solids};
use crate::{Error, Result};

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
 <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
 <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;

const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
 <Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;

/// Display colour of a body, `#RRGGBB`.
pub fn colour(body: &str) -> &'static str {
    match body {
        "driver" => "#D9822B",
        "follower" => "#3B7DB8",
        "slider" => "#6BA368",
        _ => "#B8BCC2",
    }
}

/// The mechanism at φ = 0 as one 3MF file with an object per body, in mm; `part` restricts it to
/// one body.
///
/// # Errors
/// [`Error::Internal`] when the archive cannot be written.
pub fn assembly(source: &Source, solids: &Solids, part: Option<&str>) -> Result<Vec<u8>> {
    let bodies: Vec<&SolidBody> = solids
        .bodies
        .iter()
        .filter(|b| part.is_none_or(|part| part == b.name))
        .collect();
    let model = model(source, &bodies).map_err(|e| Error::Internal(format!("3MF: {e}")))?;
    let parts = [
        ("[Content_Types].xml", CONTENT_TYPES),
        ("_rels/.rels", RELATIONSHIPS),
        ("3D/3dmodel.model", &model),
    ];
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        // The default time stamp is constant: same design, same bytes.
        zip.start_file(name, SimpleFileOptions::DEFAULT)
            .and_then(|()| Ok(zip.write_all(text.as_bytes())?))
            .map_err(|e| Error::Internal(format!("3MF: {e}")))?;
    }
    let cursor = zip
        .finish()
        .map_err(|e| Error::Internal(format!("3MF: {e}")))?;
    Ok(cursor.into_inner())
}

fn model(source: &Source, bodies: &[&SolidBody]) -> std::result::Result<String, std::fmt::Error> {
    let design = source.design;
    let mut xml = String::new();
    writeln!(xml, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        xml,
        r#"<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">"#
    )?;
    let maker = super::maker(design);
    let metadata = [
        ("Title", design.name.as_str()),
        ("Application", maker.as_str()),
        (
            "Description",
            &format!("Multi-point conjugation gear, class {}", design.class),
        ),
    ];
    for (name, value) in metadata {
        writeln!(
            xml,
            r#" <metadata name="{name}">{}</metadata>"#,
            crate::escape::markup(value)
        )?;
    }
    writeln!(xml, " <resources>")?;
    writeln!(xml, r#"  <basematerials id="1">"#)?;
    for body in bodies {
        writeln!(
            xml,
            r#"   <base name="{}" displaycolor="{}"/>"#,
            crate::escape::markup(&body.name),
            colour(&body.name)
        )?;
    }
    writeln!(xml, "  </basematerials>")?;
    for (i, body) in bodies.iter().enumerate() {
        writeln!(
            xml,
            r#"  <object id="{}" type="model" name="{}" pid="1" pindex="{i}">"#,
            i + 2,
            crate::escape::markup(&body.name)
        )?;
        write_mesh(&mut xml, &body.mesh)?;
        writeln!(xml, "  </object>")?;
    }
    writeln!(xml, " </resources>")?;
    writeln!(xml, " <build>")?;
    for (i, body) in bodies.iter().enumerate() {
        let pose = source.pose(body);
        writeln!(
            xml,
            r#"  <item objectid="{}" transform="{}"/>"#,
            i + 2,
            transform(&pose)
        )?;
    }
    writeln!(xml, " </build>")?;
    writeln!(xml, "</model>")?;
    Ok(xml)
}

fn write_mesh(xml: &mut String, mesh: &Mesh) -> std::fmt::Result {
    writeln!(xml, "   <mesh>\n    <vertices>")?;
    for [x, y, z] in &mesh.vertices {
        writeln!(xml, r#"     <vertex x="{x:.6}" y="{y:.6}" z="{z:.6}"/>"#)?;
    }
    writeln!(xml, "    </vertices>\n    <triangles>")?;
    for [a, b, c] in &mesh.triangles {
        writeln!(xml, r#"     <triangle v1="{a}" v2="{b}" v3="{c}"/>"#)?;
    }
    writeln!(xml, "    </triangles>\n   </mesh>")
}

/// The 4×3 matrix of the specification: row vectors times rotationᵀ, then the translation.
fn transform(pose: &Pose) -> String {
    let rotation = pose.rotation.iter().copied(); // column by column, that is rotationᵀ by rows
    let numbers: Vec<String> = rotation
        .chain(pose.translation.iter().copied())
        .map(|x| format!("{:.9}", x + 0.0))
        .collect();
    numbers.join(" ")
}
