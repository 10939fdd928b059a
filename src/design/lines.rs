//! JSON that people can read and that stays small: what holds only numbers is on one line.

use std::io::{Result, Write};

use serde_json::ser::Formatter;

/// Objects deeper than this are on one line: contact stations and whatever is as small.
const DEEPEST: usize = 6;

/// Formatter of `design.json`.
#[derive(Debug, Default)]
pub(super) struct Lines {
    depth: usize,
    /// A line break is due before the next value, unless that is a number.
    pending: bool,
}

impl Lines {
    /// The line break that is due.
    fn flush<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        match std::mem::take(&mut self.pending) {
            true => self.line(to),
            false => Ok(()),
        }
    }

    /// Begins a line.
    fn line<W: ?Sized + Write>(&self, to: &mut W) -> Result<()> {
        match self.depth > DEEPEST {
            true => Ok(()),
            false => write!(to, "\n{:1$}", "", self.depth),
        }
    }
}

impl Formatter for Lines {
    fn write_f64<W: ?Sized + Write>(&mut self, to: &mut W, value: f64) -> Result<()> {
        self.pending = false;
        // The shortest text that reads as the same number.
        serde_json::ser::CompactFormatter.write_f64(to, value)
    }

    fn begin_string<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        self.flush(to)?;
        to.write_all(b"\"")
    }

    fn begin_array<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        self.flush(to)?;
        self.depth += 1;
        to.write_all(b"[")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, to: &mut W, first: bool) -> Result<()> {
        self.pending = true;
        match first {
            true => Ok(()),
            false => to.write_all(b","),
        }
    }

    fn end_array<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        self.depth -= 1;
        self.pending = false;
        to.write_all(b"]")
    }

    fn begin_object<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        self.flush(to)?;
        self.depth += 1;
        to.write_all(b"{")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, to: &mut W, first: bool) -> Result<()> {
        if !first {
            to.write_all(b",")?;
        }
        self.line(to)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        to.write_all(b":")
    }

    fn end_object<W: ?Sized + Write>(&mut self, to: &mut W) -> Result<()> {
        self.depth -= 1;
        self.pending = false;
        to.write_all(b"}")
    }
}
