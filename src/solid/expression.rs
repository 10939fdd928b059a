//! Values of recipe expressions.

use std::collections::BTreeMap;

use exmex::Express;

use super::recipe::Parameter;
use crate::{Error, Result};

/// Parameter values by name.
pub struct Values<'a>(BTreeMap<&'a str, f64>);

impl<'a> Values<'a> {
    /// The values of `parameters`.
    pub fn new(parameters: &'a [Parameter]) -> Values<'a> {
        Values(
            parameters
                .iter()
                .map(|p| (p.name.as_str(), p.value))
                .collect(),
        )
    }

    /// Value of one expression, mm.
    ///
    /// # Errors
    /// [`Error::Internal`] when it does not parse, names an unknown parameter, or is not finite.
    pub fn eval(&self, expression: &str) -> Result<f64> {
        let fail =
            |why: String| Error::Internal(format!("recipe expression `{expression}`: {why}"));
        let parsed = exmex::parse::<f64>(expression).map_err(|e| fail(e.to_string()))?;
        let mut arguments = Vec::new();
        for name in parsed.var_names() {
            match self.0.get(name.as_str()) {
                Some(&value) => arguments.push(value),
                None => return Err(fail(format!("no parameter is called `{name}`"))),
            }
        }
        let value = parsed.eval(&arguments).map_err(|e| fail(e.to_string()))?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(fail(format!("the value is {value}")))
        }
    }

    /// Values of the three coordinates of a point.
    ///
    /// # Errors
    /// As [`Values::eval`].
    pub fn point(&self, coordinates: &[String; 3]) -> Result<nalgebra::Vector3<f64>> {
        let [x, y, z] = coordinates;
        Ok(nalgebra::Vector3::new(
            self.eval(x)?,
            self.eval(y)?,
            self.eval(z)?,
        ))
    }
}
