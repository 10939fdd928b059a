//! Recipe expressions: arithmetic in parameters as a small tree, of bounded size and depth.

use std::collections::BTreeMap;

use super::recipe::Parameter;
use crate::{Error, Result};

/// Longest expression, bytes; the longest of our own has fewer than a hundred.
pub const LONGEST: usize = 1000;

/// Deepest nesting of parentheses and signs.
const DEEPEST: usize = 32;

/// A parsed expression; mm.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// A constant.
    Number(f64),
    /// The value of a parameter.
    Parameter(String),
    /// The opposite.
    Negative(Box<Expression>),
    /// Two terms joined.
    Binary(Operator, Box<[Expression; 2]>),
}

/// What joins two terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// +
    Plus,
    /// −
    Minus,
    /// ×
    Times,
    /// ÷
    Over,
}

impl Expression {
    /// Parses numbers, names, `+ - * /` and parentheses.
    ///
    /// # Errors
    /// What is wrong, for a sentence that begins with the expression.
    pub fn parse(text: &str) -> std::result::Result<Expression, String> {
        if text.len() > LONGEST {
            let length = text.len();
            return Err(format!("has {length} bytes, allowed {LONGEST}"));
        }
        let mut parser = Parser { rest: text };
        let whole = parser.sum(0)?;
        match parser.peek() {
            None => Ok(whole),
            Some(c) => Err(format!("has `{c}` where + - * / or the end should be")),
        }
    }

    /// The first parameter that it names and `known` does not have.
    pub fn unknown<'a>(&'a self, known: &dyn Fn(&str) -> bool) -> Option<&'a str> {
        match self {
            Expression::Number(_) => None,
            Expression::Parameter(name) => (!known(name)).then_some(name),
            Expression::Negative(inner) => inner.unknown(known),
            Expression::Binary(_, terms) => terms.iter().find_map(|term| term.unknown(known)),
        }
    }

    /// Its value; NaN for a parameter that `value` does not know.
    fn value(&self, value: &dyn Fn(&str) -> f64) -> f64 {
        match self {
            Expression::Number(x) => *x,
            Expression::Parameter(name) => value(name),
            Expression::Negative(inner) => -inner.value(value),
            Expression::Binary(operator, terms) => {
                let [a, b] = terms.each_ref().map(|term| term.value(value));
                match operator {
                    Operator::Plus => a + b,
                    Operator::Minus => a - b,
                    Operator::Times => a * b,
                    Operator::Over => a / b,
                }
            }
        }
    }
}

/// Recursive descent; what is left to read.
struct Parser<'t> {
    rest: &'t str,
}

impl Parser<'_> {
    /// The next character that is not a space.
    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start_matches(' ');
        self.rest.chars().next()
    }

    /// The next character, if it is one of `wanted`.
    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let c = self.peek().filter(|c| wanted.contains(c))?;
        self.rest = &self.rest[c.len_utf8()..];
        Some(c)
    }

    fn sum(&mut self, depth: usize) -> std::result::Result<Expression, String> {
        let mut left = self.product(depth)?;
        while let Some(sign) = self.take(&['+', '-']) {
            let operator = match sign {
                '+' => Operator::Plus,
                _ => Operator::Minus,
            };
            left = Expression::Binary(operator, Box::new([left, self.product(depth)?]));
        }
        Ok(left)
    }

    fn product(&mut self, depth: usize) -> std::result::Result<Expression, String> {
        let mut left = self.factor(depth)?;
        while let Some(sign) = self.take(&['*', '/']) {
            let operator = match sign {
                '*' => Operator::Times,
                _ => Operator::Over,
            };
            left = Expression::Binary(operator, Box::new([left, self.factor(depth)?]));
        }
        Ok(left)
    }

    fn factor(&mut self, depth: usize) -> std::result::Result<Expression, String> {
        if depth > DEEPEST {
            return Err(format!("is nested deeper than {DEEPEST} levels"));
        }
        match self.peek() {
            Some('-') => {
                self.take(&['-']);
                Ok(Expression::Negative(Box::new(self.factor(depth + 1)?)))
            }
            Some('(') => {
                self.take(&['(']);
                let inner = self.sum(depth + 1)?;
                match self.take(&[')']) {
                    Some(_) => Ok(inner),
                    None => Err("has a ( that is not closed".into()),
                }
            }
            Some(c) if c.is_ascii_digit() || c == '.' => {
                let word = self.word(|c| c.is_ascii_digit() || c == '.');
                let number = word
                    .parse()
                    .map_err(|_| format!("has no number `{word}`"))?;
                Ok(Expression::Number(number))
            }
            Some(c) if c.is_ascii_lowercase() => {
                let name = self.word(|c| c.is_ascii_alphanumeric() || c == '_');
                Ok(Expression::Parameter(name.into()))
            }
            Some(c) => Err(format!("has `{c}` where a number or a name should be")),
            None => Err("ends where a number or a name should be".into()),
        }
    }

    /// The characters from here that are `part` of a word.
    fn word(&mut self, part: impl Fn(char) -> bool) -> &str {
        let end = self.rest.find(|c| !part(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }
}

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

    /// Value of one expression, mm; or what is wrong with it.
    ///
    /// # Errors
    /// As [`Expression::parse`]; an unknown parameter; a value that is not finite.
    pub fn try_eval(&self, expression: &str) -> std::result::Result<f64, String> {
        let parsed = Expression::parse(expression)?;
        if let Some(name) = parsed.unknown(&|name| self.0.contains_key(name)) {
            return Err(format!("names `{name}`, which is no parameter"));
        }
        let value = parsed.value(&|name| self.0.get(name).copied().unwrap_or(f64::NAN));
        match value.is_finite() {
            true => Ok(value),
            false => Err(format!("has the value {value}")),
        }
    }

    /// Value of one expression, mm.
    ///
    /// # Errors
    /// [`Error::Internal`] where [`Values::try_eval`] fails: recipes are checked where they are read.
    pub fn eval(&self, expression: &str) -> Result<f64> {
        self.try_eval(expression)
            .map_err(|what| Error::Internal(format!("recipe expression `{expression}` {what}")))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str, value: f64) -> Parameter {
        Parameter {
            name: name.into(),
            value,
            min: value,
            max: value,
            group: "Hub".into(),
            description: String::new(),
        }
    }

    #[test]
    fn expressions_have_the_usual_meaning() {
        let parameters = [parameter("a", 3.0), parameter("b_2", 0.5)];
        let values = Values::new(&parameters);
        for (text, value) in [
            ("3", 3.0),
            ("-(2 + 1) * 2", -6.0),
            ("7 / 2 / 2", 1.75),
            ("-40 - -2", -38.0),
            ("10 - 4 - 3", 3.0),
            ("a * (b_2 + 1.5) - .5", 5.5),
            ("2 + 3 * a", 11.0),
            ("--a", 3.0),
        ] {
            assert_eq!(values.try_eval(text), Ok(value), "{text}");
        }
    }

    #[test]
    fn what_is_no_expression_is_refused_at_any_length() {
        let parameters = [parameter("a", 3.0)];
        let values = Values::new(&parameters);
        let deep = format!("{}a{}", "(".repeat(400), ")".repeat(400));
        let signs = "-".repeat(900) + "a";
        let long = "a+".repeat(50_000) + "a";
        for (text, why) in [
            ("", "ends where"),
            ("a +", "ends where"),
            ("a b", "has `b` where"),
            ("(a", "not closed"),
            ("a)", "has `)`"),
            ("1.2.3", "no number"),
            ("2 ^ 3", "has `^`"),
            ("b", "names `b`"),
            ("sin(a)", "has `(`"),
            ("1 / (a - 3)", "inf"),
            ("*/ echo(1); /*", "has `*`"),
            ("ä", "has `ä`"),
            (&deep, "nested deeper"),
            (&signs, "nested deeper"),
            (&long, "allowed 1000"),
        ] {
            let error = values.try_eval(text).expect_err(text);
            assert!(error.contains(why), "{error}");
        }
        let most = "1+".repeat(LONGEST / 2 - 1) + "1";
        assert_eq!(values.try_eval(&most), Ok(LONGEST as f64 / 2.0));
    }
}
