//! The text templates, and how they are filled in.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;

use crate::{Error, Result, escape};

/// Names must not end in `.xml` or `.html`: their values would be escaped a second time.
const TEMPLATES: [(&str, &str); 16] = [
    ("header", include_str!("../../templates/scad_header.jinja")),
    (
        "parameters",
        include_str!("../../templates/scad_parameters.jinja"),
    ),
    ("hidden", include_str!("../../templates/scad_hidden.jinja")),
    ("body", include_str!("../../templates/scad_body.jinja")),
    ("spokes", include_str!("../../templates/scad_spokes.jinja")),
    ("motion", include_str!("../../templates/scad_motion.jinja")),
    ("pieces", include_str!("../../templates/scad_pieces.jinja")),
    (
        "options_driver",
        include_str!("../../templates/scad_driver.jinja"),
    ),
    (
        "options_follower",
        include_str!("../../templates/scad_follower.jinja"),
    ),
    (
        "options_support",
        include_str!("../../templates/scad_support.jinja"),
    ),
    ("part.scad", include_str!("../../templates/part.scad.jinja")),
    (
        "assembly.scad",
        include_str!("../../templates/assembly.scad.jinja"),
    ),
    (
        "customizer.scad",
        include_str!("../../templates/customizer.scad.jinja"),
    ),
    ("card.md", include_str!("../../templates/card.md.jinja")),
    ("mjcf", include_str!("../../templates/mjcf.xml.jinja")),
    ("parts.md", include_str!("../../templates/parts.md.jinja")),
];

/// Renders one of the templates; a value that is missing is an error.
///
/// # Errors
/// [`Error::Internal`] when the template fails.
pub fn render(template: &str, values: impl Serialize) -> Result<String> {
    let fail = |e: minijinja::Error| Error::Internal(format!("template {template}: {e:#}"));
    let mut environment = Environment::new();
    escape::filters(&mut environment);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(
        SyntaxConfig::builder()
            .trim_blocks(true)
            .lstrip_blocks(true)
            .keep_trailing_newline(true)
            .build()
            .map_err(fail)?,
    );
    for (name, text) in TEMPLATES {
        environment.add_template(name, text).map_err(fail)?;
    }
    environment
        .get_template(template)
        .and_then(|t| t.render(Serde(&values)))
        .map_err(fail)
}
