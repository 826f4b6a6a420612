//! Arithmetic expressions over named variables, compiled once to a small stack program.
//!
//! Numbers (with exponent), names, `+ - * /`, `^` (binds to the right and before a sign, so that `-x^2` is
//! `-(x^2)`), parentheses, functions. A fault is told by its place in the text, and a value that is not finite
//! by the operation it comes from; no general parser at hand tells either.

use crate::text::meant;

/// Deepest nesting and greatest length: far beyond any law, far below what could hurt.
const MOST_NESTING: usize = 48;
const MOST_STACK: usize = 32;
const MOST_CHARACTERS: usize = 2000;

/// What is wrong with an expression, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Character in the text, from 1.
    pub character: usize,
    /// What is wrong there.
    pub message: String,
}

#[derive(Debug, Clone, Copy)]
enum Operation {
    Number(f64),
    Variable(usize),
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Negate,
    Call(Function),
    Join(Joining),
}

type Function = fn(f64) -> f64;
type Joining = fn(f64, f64) -> f64;

const FUNCTIONS: [(&str, Function); 11] = [
    ("tanh", f64::tanh),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("atan", f64::atan),
    ("abs", f64::abs),
    ("sqrt", f64::sqrt),
    ("sign", |x| if x == 0.0 { 0.0 } else { x.signum() }),
    ("square", |x| x * x),
];

const JOINING: [(&str, Joining); 2] = [("min", f64::min), ("max", f64::max)];

/// Names that a variable or parameter cannot have.
pub fn is_reserved(name: &str) -> bool {
    name == "pi"
        || FUNCTIONS.iter().any(|(known, _)| *known == name)
        || JOINING.iter().any(|(known, _)| *known == name)
}

/// A compiled expression.
#[derive(Debug, Clone)]
pub struct Expression {
    program: Vec<Operation>,
    /// Character of each operation in the text, from 1.
    places: Vec<usize>,
}

impl Expression {
    /// Compiles a text in which `names` stand for the values that evaluation is given, in their order.
    ///
    /// # Errors
    ///
    /// [`Fault`] with the place.
    pub fn parse(text: &str, names: &[&str]) -> Result<Self, Fault> {
        let characters: Vec<char> = text.chars().collect();
        if characters.len() > MOST_CHARACTERS {
            let message = format!("longer than {MOST_CHARACTERS} characters");
            return Err(Fault { character: MOST_CHARACTERS + 1, message });
        }
        let mut parser = Parser {
            characters: &characters,
            at: 0,
            names,
            nesting: 0,
            stack: 0,
            out: Self { program: Vec::new(), places: Vec::new() },
        };
        parser.sum()?;
        parser.skip_blanks();
        if parser.at < characters.len() {
            return Err(parser.fault(format!("'{}' is not expected here", characters[parser.at])));
        }
        Ok(parser.out)
    }

    /// The expression with fixed values for all variables from `first` on.
    pub fn bind(&self, first: usize, values: &[f64]) -> Self {
        let bound = |operation: &Operation| match *operation {
            Operation::Variable(i) if i >= first => Operation::Number(values[i - first]),
            other => other,
        };
        Self { program: self.program.iter().map(bound).collect(), places: self.places.clone() }
    }

    /// The value.
    #[inline]
    pub fn value(&self, variables: &[f64]) -> f64 {
        let mut stack = [0.0; MOST_STACK];
        let mut top = 0;
        for operation in &self.program {
            step(operation, variables, &mut stack, &mut top);
        }
        stack[0]
    }

    /// The value, or where it stops being finite.
    ///
    /// # Errors
    ///
    /// [`Fault`] at the first operation that divides by zero or is not finite.
    pub fn checked(&self, variables: &[f64]) -> Result<f64, Fault> {
        let mut stack = [0.0; MOST_STACK];
        let mut top: usize = 0;
        for (operation, &character) in self.program.iter().zip(&self.places) {
            let divides_by_zero =
                matches!(operation, Operation::Divide) && stack[top.saturating_sub(1)] == 0.0;
            step(operation, variables, &mut stack, &mut top);
            if divides_by_zero {
                return Err(Fault { character, message: "division by zero".to_owned() });
            }
            let value = stack[top.saturating_sub(1)];
            if !value.is_finite() {
                return Err(Fault { character, message: format!("the value is {value}") });
            }
        }
        Ok(stack[0])
    }
}

#[inline(always)]
fn step(operation: &Operation, variables: &[f64], stack: &mut [f64; MOST_STACK], top: &mut usize) {
    match *operation {
        Operation::Number(_) | Operation::Variable(_) => {
            stack[*top] = match *operation {
                Operation::Variable(i) => variables[i],
                Operation::Number(value) => value,
                _ => 0.0,
            };
            *top += 1;
        }
        Operation::Negate => stack[*top - 1] = -stack[*top - 1],
        Operation::Call(function) => stack[*top - 1] = function(stack[*top - 1]),
        _ => {
            *top -= 1;
            let (a, b) = (stack[*top - 1], stack[*top]);
            stack[*top - 1] = match *operation {
                Operation::Add => a + b,
                Operation::Subtract => a - b,
                Operation::Multiply => a * b,
                Operation::Divide => a / b,
                Operation::Join(function) => function(a, b),
                _ if b == 2.0 => a * a,
                _ => a.powf(b),
            };
        }
    }
}

struct Parser<'a> {
    characters: &'a [char],
    at: usize,
    names: &'a [&'a str],
    nesting: usize,
    stack: usize,
    out: Expression,
}

impl Parser<'_> {
    fn fault(&self, message: impl Into<String>) -> Fault {
        Fault { character: self.at + 1, message: message.into() }
    }

    fn skip_blanks(&mut self) {
        while self.characters.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
    }

    fn next_is(&mut self, wanted: char) -> bool {
        self.skip_blanks();
        let found = self.characters.get(self.at) == Some(&wanted);
        self.at += usize::from(found);
        found
    }

    fn emit(&mut self, operation: Operation, character: usize) -> Result<(), Fault> {
        match operation {
            Operation::Number(_) | Operation::Variable(_) => self.stack += 1,
            Operation::Negate | Operation::Call(_) => {}
            _ => self.stack -= 1,
        }
        if self.stack > MOST_STACK {
            return Err(self.fault("too many values that wait for an operation"));
        }
        self.out.program.push(operation);
        self.out.places.push(character);
        Ok(())
    }

    fn sum(&mut self) -> Result<(), Fault> {
        self.nesting += 1;
        if self.nesting > MOST_NESTING {
            return Err(self.fault(format!("nested more than {MOST_NESTING} deep")));
        }
        self.product()?;
        loop {
            let operation = if self.next_is('+') {
                Operation::Add
            } else if self.next_is('-') {
                Operation::Subtract
            } else {
                self.nesting -= 1;
                return Ok(());
            };
            let character = self.at;
            self.product()?;
            self.emit(operation, character)?;
        }
    }

    fn product(&mut self) -> Result<(), Fault> {
        self.signed()?;
        loop {
            let operation = if self.next_is('*') {
                Operation::Multiply
            } else if self.next_is('/') {
                Operation::Divide
            } else {
                return Ok(());
            };
            let character = self.at;
            self.signed()?;
            self.emit(operation, character)?;
        }
    }

    fn signed(&mut self) -> Result<(), Fault> {
        let mut negative = false;
        let mut character = 0;
        loop {
            if self.next_is('-') {
                (negative, character) = (!negative, self.at);
            } else if !self.next_is('+') {
                break;
            }
        }
        self.atom()?;
        if self.next_is('^') {
            let character = self.at;
            self.nesting += 1;
            if self.nesting > MOST_NESTING {
                return Err(self.fault(format!("nested more than {MOST_NESTING} deep")));
            }
            self.signed()?;
            self.nesting -= 1;
            self.emit(Operation::Power, character)?;
        }
        if negative { self.emit(Operation::Negate, character) } else { Ok(()) }
    }

    fn atom(&mut self) -> Result<(), Fault> {
        self.skip_blanks();
        let start = self.at;
        match self.characters.get(start) {
            None => Err(self.fault("the expression ends here, but a value is expected")),
            Some('(') => {
                self.at += 1;
                self.sum()?;
                self.close()
            }
            Some(c) if c.is_ascii_digit() || *c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || *c == '_' => {
                while self.characters.get(self.at).is_some_and(|c| c.is_ascii_alphanumeric() || *c == '_') {
                    self.at += 1;
                }
                let name: String = self.characters[start..self.at].iter().collect();
                self.named(&name, start)
            }
            Some(c) => Err(self.fault(format!("'{c}' is not expected here, but a value"))),
        }
    }

    fn close(&mut self) -> Result<(), Fault> {
        if self.next_is(')') { Ok(()) } else { Err(self.fault("')' is missing")) }
    }

    fn number(&mut self) -> Result<(), Fault> {
        let start = self.at;
        let digits = |parser: &mut Self| {
            while parser.characters.get(parser.at).is_some_and(char::is_ascii_digit) {
                parser.at += 1;
            }
        };
        digits(self);
        if self.characters.get(self.at) == Some(&'.') {
            self.at += 1;
            digits(self);
        }
        if matches!(self.characters.get(self.at), Some('e' | 'E')) {
            self.at += 1;
            if matches!(self.characters.get(self.at), Some('+' | '-')) {
                self.at += 1;
            }
            digits(self);
        }
        let text: String = self.characters[start..self.at].iter().collect();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => self.emit(Operation::Number(value), start + 1),
            _ => Err(Fault { character: start + 1, message: format!("'{text}' is no number") }),
        }
    }

    fn named(&mut self, name: &str, start: usize) -> Result<(), Fault> {
        let character = start + 1;
        let function = FUNCTIONS.iter().find(|(n, _)| *n == name).map(|(_, f)| *f);
        let joining = JOINING.iter().find(|(n, _)| *n == name).map(|(_, f)| *f);
        if function.is_some() || joining.is_some() {
            if !self.next_is('(') {
                return Err(self.fault(format!("'(' is missing after the function '{name}'")));
            }
            self.sum()?;
            let mut further = 0;
            while self.next_is(',') {
                self.sum()?;
                further += 1;
                if let Some(joining) = joining {
                    self.emit(Operation::Join(joining), character)?;
                }
            }
            self.close()?;
            return match function {
                Some(_) if further > 0 => {
                    Err(Fault { character, message: format!("'{name}' takes one value") })
                }
                Some(function) => self.emit(Operation::Call(function), character),
                None if further == 0 => {
                    Err(Fault { character, message: format!("'{name}' takes at least two values") })
                }
                None => Ok(()),
            };
        }
        if let Some(i) = self.names.iter().position(|n| *n == name) {
            return self.emit(Operation::Variable(i), character);
        }
        if name == "pi" {
            return self.emit(Operation::Number(std::f64::consts::PI), character);
        }
        let functions = FUNCTIONS.iter().map(|(n, _)| *n).chain(JOINING.iter().map(|(n, _)| *n));
        let hint = meant(name, self.names.iter().copied().chain(functions));
        let known = self.names.join(", ");
        Err(Fault { character, message: format!("unknown name '{name}'{hint} Known here are {known}") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        Expression::parse(text, &["x", "y"]).unwrap_or_else(|f| panic!("{f:?}")).value(&[3.0, -0.5])
    }

    #[test]
    fn analytic_values_and_precedence() {
        let close = |text: &str, truth: f64| assert!((value(text) - truth).abs() < 1e-14, "{text}");
        close("1 + 2*x", 7.0);
        close("-x^2", -9.0);
        close("2^-1 + 2^3^2", 512.5);
        close("x - 1 - 1", 1.0);
        close("8/2/2", 2.0);
        close("1.5e-3*abs(y) + 2E2", 200.00075);
        close("min(x, 2, y) + max(1, x)", 2.5);
        close("sign(y) + sign(0) + sqrt(square(x)) - -1", 3.0);
        close("tanh(x/1e-3)*cos(pi)", -1.0);
    }

    #[test]
    fn faults_are_told_by_their_place() {
        let fault = |text: &str| Expression::parse(text, &["y_dot", "a"]).expect_err(text);
        let unknown = fault("a*y_dott");
        assert_eq!(unknown.character, 3);
        assert!(unknown.message.contains("did you mean 'y_dot'?"), "{unknown:?}");
        assert_eq!(fault("a*(1 + y_dot").character, 13);
        assert_eq!(fault("a*").character, 3);
        assert_eq!(fault("a y_dot").character, 3);
        assert_eq!(fault("sin a").character, 5);
        assert_eq!(fault("1.2.3").character, 4);
        assert!(fault(&"(".repeat(5000)).message.contains("longer"));
        assert!(fault(&"(".repeat(500)).message.contains("nested"));
        assert!(fault(&"2^".repeat(500)).message.contains("values that wait"));
        assert!(fault(&"2^-(".repeat(40)).message.contains("nested"));
        assert!(fault(&format!("{}1", "1-(".repeat(40))).message.contains("values that wait"));
    }

    #[test]
    fn what_is_not_finite_is_told_by_its_operation() {
        let law = Expression::parse("a + 1/y_dot", &["a", "y_dot"]).expect("good");
        let fault = law.checked(&[1.0, 0.0]).expect_err("divides by zero");
        assert_eq!((fault.character, fault.message.as_str()), (6, "division by zero"));
        assert_eq!(law.checked(&[1.0, 2.0]), Ok(1.5));
        let law = Expression::parse("sqrt(a)", &["a"]).expect("good");
        assert_eq!(law.checked(&[-1.0]).expect_err("not real").character, 1);
    }
}
