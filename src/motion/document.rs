//! A TOML text whose problems can be placed: line of every field, suggestions for unknown ones.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use crate::{Problem, Problems};

/// Parsed TOML that remembers where its fields are.
pub(crate) struct Document<'t> {
    text: &'t str,
    spans: DeTable<'t>,
    /// The same as plain values.
    pub table: toml::Table,
}

impl<'t> Document<'t> {
    /// Parses `text`.
    pub(crate) fn parse(text: &'t str) -> Result<Document<'t>, Problem> {
        let broken = |e: &toml::de::Error| {
            let at = e.span().map_or(0, |span| span.start);
            let message = e.message().lines().collect::<Vec<_>>().join("; ");
            Problem::new(
                format!("line {}", line(text, at)),
                format!("this is not TOML: {message}"),
                "text goes in quotes, tables are written [name], comments start with #",
            )
        };
        let spans = DeTable::parse(text).map_err(|e| broken(&e))?.into_inner();
        let table = toml::from_str(text).map_err(|e| broken(&e))?;
        Ok(Document { text, spans, table })
    }

    /// Puts the line in front of places such as `gear.teeth` or `motion.axis[1]` that are in the
    /// file, and sorts the problems by it.
    pub(crate) fn locate(&self, problems: &mut Problems) {
        let problems = problems.first_mut();
        problems.sort_by_cached_key(|problem| self.line_of(&problem.place));
        for problem in problems {
            if let Some(line) = self.line_of(&problem.place) {
                problem.place = format!("line {line}, {}", problem.place);
            }
        }
    }

    /// Line of the innermost part of a dotted place that is in the file.
    fn line_of(&self, place: &str) -> Option<usize> {
        let mut table = &self.spans;
        let mut rest = place;
        let mut at = None;
        loop {
            let found = table.iter().find_map(|(key, value)| {
                let rest = rest.strip_prefix(&*as_key(key.get_ref()))?;
                let ends = rest.is_empty() || rest.starts_with(['.', ' ', '[']);
                ends.then_some((key.span().start, value, rest))
            });
            let Some((start, value, after)) = found else {
                break;
            };
            at = Some(start);
            match (value.get_ref(), after.strip_prefix('.')) {
                (DeValue::Table(inner), Some(after)) => (table, rest) = (inner, after),
                _ => break,
            }
        }
        at.map(|at| line(self.text, at))
    }
}

/// A key as a TOML file has it: in quotes if need be.
pub(crate) fn as_key(name: &str) -> Cow<'_, str> {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match !name.is_empty() && name.chars().all(bare) {
        true => Cow::Borrowed(name),
        false => Cow::Owned(format!("{name:?}")),
    }
}

/// Line number (from 1) of the byte at `offset`.
fn line(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|b| *b == b'\n').count() + 1
}

/// Adds a problem for every field of `table` that is not among `known`.
pub(crate) fn unknown_fields(
    path: &str,
    table: &toml::Table,
    known: &[&str],
    problems: &mut Problems,
) {
    for key in table.keys().filter(|key| !known.contains(&key.as_str())) {
        problems.add(|| {
            let place = match path {
                "" => as_key(key).into_owned(),
                path => format!("{path}.{}", as_key(key)),
            };
            let hint = match nearest(key, known) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("known here: {}", known.join(", ")),
            };
            Problem::new(place, "unknown field", hint)
        });
    }
}

/// Longer words are not compared with what they may have meant.
const LONGEST_WORD: usize = 100;

/// The most similar of `known`, if similar at all.
pub(crate) fn nearest<'k>(word: &str, known: &[&'k str]) -> Option<&'k str> {
    // Comparing takes as long as both lengths multiplied.
    if word.len() > LONGEST_WORD {
        return None;
    }
    // Jaro-Winkler forgives missing ends (`clearance`), edit distance prefers equal length (`tooth`).
    let similarity = |name: &str| {
        (strsim::jaro_winkler(word, name) + strsim::normalized_damerau_levenshtein(word, name))
            / 2.0
    };
    known
        .iter()
        .map(|name| (similarity(name), *name))
        .filter(|(similarity, _)| *similarity > 0.55)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
