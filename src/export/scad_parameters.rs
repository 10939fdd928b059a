//! The parameters of a script as OpenSCAD's Customizer sees them.

/// A parameter of a script.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// The value that stands in the script.
    pub value: String,
    /// What the Customizer allows, as it stands in the comment: `0:0.1:5`, `none:None, M2`; may be empty.
    pub allowed: String,
}

/// The parameters of `script`: assignments before the hidden group and the first brace.
pub fn read(script: &str) -> Vec<Parameter> {
    let shown = script.split("/* [Hidden] */").next().unwrap_or_default();
    let shown = shown.split('{').next().unwrap_or_default();
    shown.lines().filter_map(parameter).collect()
}

fn parameter(line: &str) -> Option<Parameter> {
    let (name, rest) = line.split_once(" = ")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (value, comment) = rest.split_once(';')?;
    let allowed = comment.trim().strip_prefix("// ").unwrap_or_default();
    let allowed = allowed.trim_start_matches('[').trim_end_matches(']');
    (!name.is_empty() && name.chars().all(plain)).then(|| Parameter {
        name: name.into(),
        value: value.into(),
        allowed: allowed.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_customizer_shows_is_read() {
        let script = "// a = 1\n/* [Fit] */\n// gap\ngap = 0.1; // [0:0.01:0.5]\nkind = \"none\"; // [none:None, M2]\n\
                      key = false;\n/* [Hidden] */\nfar = 3;\nmodule m() {\n  x = 2;\n}\n";
        let found = read(script);
        let text: Vec<String> = found
            .iter()
            .map(|p| format!("{}|{}|{}", p.name, p.value, p.allowed))
            .collect();
        assert_eq!(
            text,
            [
                "gap|0.1|0:0.01:0.5",
                "kind|\"none\"|none:None, M2",
                "key|false|"
            ]
        );
    }
}
