//! Text of users inside other languages: one function for each, also a filter of the templates.

use std::fmt::Write;

use minijinja::Environment;

/// What ends a line somewhere, or has no place in text at all.
fn breaks(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{fffe}' | '\u{ffff}')
}

/// What turns the direction of the text around it, so that a line reads other than it runs.
fn turns(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// On one line: each run of blanks, control characters and line ends becomes one blank.
fn one_line(text: &str) -> String {
    text.split(|c: char| c.is_whitespace() || breaks(c) || turns(c))
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// For comments of OpenSCAD and Python: one line that neither ends a comment nor starts one; brackets,
/// which the Customizer reads, are round.
pub fn comment(text: &str) -> String {
    let text = one_line(text).replace('[', "(").replace(']', ")");
    text.replace('*', "∗").replace('\\', "/")
}

/// Inside the double quotes of an OpenSCAD string.
pub fn scad(text: &str) -> String {
    one_line(text).replace('\\', "\\\\").replace('"', "\\\"")
}

/// Inside the quotes, single or double, of a Python string.
pub fn python(text: &str) -> String {
    let text = one_line(text).replace('\\', "\\\\");
    text.replace('"', "\\\"").replace('\'', "\\'")
}

/// Inside an element or a quoted attribute of XML or HTML; what XML 1.0 cannot hold becomes U+FFFD.
pub fn markup(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// In a line or cell of Markdown.
pub fn markdown(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in one_line(text).chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '\\' | '`' | '*' | '[' | ']' | '|' | '#' | '~' | '$' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

/// In a span of code of Markdown, also within a table.
pub fn code(text: &str) -> String {
    one_line(text).replace('`', "'").replace('|', "¦")
}

/// A cell of CSV before it is quoted: spreadsheets take no text for a formula.
pub fn cell(text: &str) -> String {
    let formula = text
        .trim_start()
        .starts_with(['=', '+', '-', '@', '\t', '\r']);
    match formula && text.parse::<f64>().is_err() {
        true => format!("'{text}"),
        false => text.into(),
    }
}

/// For people at a terminal: control characters (but line ends and tabs) and turns of the direction
/// as `\u001b`, which leaves JSON what it was.
pub fn terminal(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if !matches!(c, '\n' | '\t') && (breaks(c) || turns(c)) {
            // Writing to a String cannot fail.
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out
}

/// Gives the templates the functions as filters.
pub(crate) fn filters(environment: &mut Environment) {
    for (name, escape) in [
        ("comment", comment as fn(&str) -> String),
        ("scad", scad),
        ("python", python),
        ("markdown", markdown),
        ("code", code),
        ("markup", markup),
    ] {
        environment.add_filter(name, move |text: String| escape(&text));
    }
}
