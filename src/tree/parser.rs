//! The parser of expressions: operator precedence after Pratt, "Top down operator precedence" (1973), straight to a program.
//!
//! From loosest to tightest: `?:` (right), `||`, `&&`, `== !=`, `< <= > >=`, `+ -`, `* / %`, prefix `- !`, `^` (right).

use super::cursor::{Cursor, Fault};
use super::expression::{FUNCTIONS, Function, Op, Operator, Program};
use std::collections::BTreeMap;
use std::ops::Range;

/// Deepest nesting of one expression: what a person writes needs less than ten.
const DEPTH_LIMIT: usize = 64;
const TERNARY: u8 = 1;
const OR: u8 = 2;
const AND: u8 = 3;
const PREFIX: u8 = 8;

/// Dyadic operators with their binding power and whether they group to the right; longer tokens first.
const OPERATORS: [(&str, Operator, u8, bool); 12] = [
    ("==", Operator::Equal, 4, false),
    ("!=", Operator::NotEqual, 4, false),
    ("<=", Operator::LessEqual, 5, false),
    (">=", Operator::GreaterEqual, 5, false),
    ("<", Operator::Less, 5, false),
    (">", Operator::Greater, 5, false),
    ("+", Operator::Add, 6, false),
    ("-", Operator::Subtract, 6, false),
    ("*", Operator::Multiply, 7, false),
    ("/", Operator::Divide, 7, false),
    ("%", Operator::Remainder, 7, false),
    ("^", Operator::Power, 9, true),
];

/// The names that expressions of one rule know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Names<'a> {
    pub parameters: &'a [String],
    pub constants: &'a BTreeMap<String, f64>,
}

impl Names<'_> {
    /// Parameters hide constants, constants hide `n`.
    fn look_up(&self, name: &str) -> Option<Op> {
        if let Some(index) = self.parameters.iter().position(|known| known == name) {
            return Some(Op::Parameter(index));
        }
        if let Some(&value) = self.constants.get(name) {
            return Some(Op::Constant(value));
        }
        matches!(name, "age" | "n").then_some(Op::Age)
    }

    fn known(&self) -> String {
        let names = self.parameters.iter().chain(self.constants.keys()).map(String::as_str);
        names.chain(["age"]).collect::<Vec<_>>().join(", ")
    }
}

/// Parses the expression at the cursor. Unknown names are noted in `faults` and parsing goes on.
pub(super) fn expression(cursor: &mut Cursor<'_>, names: Names<'_>, faults: &mut Vec<Fault>) -> Result<Program, Fault> {
    let mut parser = Parser { cursor, names, faults, program: Program::default(), depth: 0 };
    parser.expression(0)?;
    Ok(parser.program)
}

struct Parser<'c, 't, 'n> {
    cursor: &'c mut Cursor<'t>,
    names: Names<'n>,
    faults: &'c mut Vec<Fault>,
    program: Program,
    depth: usize,
}

impl Parser<'_, '_, '_> {
    fn here(&self) -> usize {
        self.program.ops.len()
    }

    /// Points the jump at step `from` to the next step.
    fn land(&mut self, from: usize) {
        let here = self.here();
        if let Op::And(to) | Op::Or(to) | Op::Branch(to) | Op::Jump(to) = &mut self.program.ops[from] {
            *to = here;
        }
    }

    fn expression(&mut self, least: u8) -> Result<(), Fault> {
        self.depth += 1;
        if self.depth > DEPTH_LIMIT {
            let here = self.cursor.next_range();
            return Err(Fault::new(here, "the expression is nested too deeply", "split it up with constants"));
        }
        let (start, first) = (self.cursor.place(), self.here());
        self.operand()?;
        while self.operator(least, start, first)? {}
        self.depth -= 1;
        Ok(())
    }

    /// Takes one operator that binds at least as tightly as `least`, with its right side.
    fn operator(&mut self, least: u8, start: usize, first: usize) -> Result<bool, Fault> {
        if self.cursor.sees("->") {
            return Ok(false);
        }
        if least <= TERNARY && self.cursor.accept("?") {
            self.ternary(start)?;
        } else if least <= OR && self.cursor.accept("||") {
            self.logic(Op::Or(0), OR, start)?;
        } else if least <= AND && self.cursor.accept("&&") {
            self.logic(Op::And(0), AND, start)?;
        } else {
            let found = OPERATORS.iter().find(|(token, ..)| self.cursor.sees(token));
            let Some(&(token, operator, power, right)) = found.filter(|&&(_, _, power, _)| power >= least) else {
                return Ok(false);
            };
            self.cursor.accept(token);
            self.dyadic(operator, if right { PREFIX } else { power + 1 }, start, first)?;
        }
        Ok(true)
    }

    fn ternary(&mut self, start: usize) -> Result<(), Fault> {
        let branch = self.here();
        self.program.push(Op::Branch(0), start..self.cursor.end());
        self.expression(TERNARY)?;
        self.cursor.expect(":", "a choice reads `condition ? value : other value`")?;
        let jump = self.here();
        self.program.push(Op::Jump(0), start..self.cursor.end());
        self.land(branch);
        self.expression(TERNARY)?;
        self.land(jump);
        Ok(())
    }

    fn logic(&mut self, op: Op, power: u8, start: usize) -> Result<(), Fault> {
        let jump = self.here();
        self.program.push(op, start..self.cursor.end());
        self.expression(power + 1)?;
        self.program.push(Op::Truth, start..self.cursor.end());
        self.land(jump);
        Ok(())
    }

    fn dyadic(&mut self, operator: Operator, least: u8, start: usize, first: usize) -> Result<(), Fault> {
        let second = self.here();
        self.expression(least)?;
        let span = start..self.cursor.end();
        let literal = |code: &[Op]| if let [Op::Literal(value)] = *code { Some(value) } else { None };
        let divisor = literal(&self.program.ops[second..]);
        if matches!(operator, Operator::Divide | Operator::Remainder) && divisor == Some(0.0) {
            self.faults.push(Fault::new(span.clone(), "division by zero", "divide by something else"));
        }
        match (literal(&self.program.ops[first..second]), divisor) {
            (Some(a), Some(b)) => self.fold(first, operator.apply(a, b), span),
            _ => self.program.push_dyadic(operator, second, span),
        }
        Ok(())
    }

    /// Replaces the steps from `first` on by their known value.
    fn fold(&mut self, first: usize, value: f64, span: Range<usize>) {
        let reported = self.faults.last().is_some_and(|fault| fault.within == span);
        if !value.is_finite() && !reported {
            self.faults.push(Fault::new(span.clone(), "this is not a finite number", "write one that exists"));
        }
        self.program.ops.truncate(first);
        self.program.spans.truncate(first);
        self.program.push(Op::Literal(value), span);
    }

    fn operand(&mut self) -> Result<(), Fault> {
        let start = self.cursor.place();
        if let Some((value, span)) = self.cursor.number() {
            self.fold(self.here(), value, span);
        } else if self.cursor.accept("(") {
            self.expression(0)?;
            self.cursor.expect(")", "close the parenthesis")?;
        } else if self.cursor.accept("-") {
            let first = self.here();
            self.expression(PREFIX)?;
            match self.program.ops[first..] {
                [Op::Literal(value)] => self.fold(first, -value, start..self.cursor.end()),
                _ => self.program.push(Op::Negate, start..self.cursor.end()),
            }
        } else if self.cursor.accept("!") {
            self.expression(PREFIX)?;
            self.program.push(Op::Not, start..self.cursor.end());
        } else {
            self.name()?;
        }
        Ok(())
    }

    fn name(&mut self) -> Result<(), Fault> {
        let (name, span) = self.cursor.run(|c| c.is_ascii_alphanumeric() || c == '_');
        if name.is_empty() {
            let here = self.cursor.next_range();
            let help = "write a number, a name, a function or something in parentheses";
            return Err(Fault::new(here, "a value is missing here", help));
        }
        if self.cursor.accept("(") {
            return self.call(name, span);
        }
        let found = self.names.look_up(name);
        if found.is_none() {
            let help = format!("known here: {}; or add it to tree.constants", self.names.known());
            self.faults.push(Fault::new(span.clone(), format!("`{name}` is not known"), help));
        }
        self.program.push(found.unwrap_or(Op::Constant(1.0)), span);
        Ok(())
    }

    fn call(&mut self, name: &str, span: Range<usize>) -> Result<(), Fault> {
        let mut count = 0;
        while !self.cursor.accept(")") {
            if count > 0 {
                self.cursor.expect(",", "separate the arguments by commas and close the parenthesis")?;
            }
            self.expression(0)?;
            count += 1;
        }
        let whole = span.start..self.cursor.end();
        let found = FUNCTIONS.iter().find(|(known, ..)| *known == name);
        match found {
            None => {
                let known = FUNCTIONS.map(|(known, ..)| known).join(", ");
                self.faults.push(Fault::new(span, format!("there is no function `{name}`"), format!("known: {known}")));
            }
            Some(&(_, _, wanted)) if wanted != count => {
                let message = format!("`{name}` takes {wanted} arguments, not {count}");
                self.faults.push(Fault::new(whole.clone(), message, "add or remove arguments"));
            }
            Some(_) => {}
        }
        let function = found.map_or(Function::Abs, |&(_, function, _)| function);
        self.program.push(Op::Call(function), whole);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::draws::Draws;
    use super::super::expression::Scope;
    use super::*;

    fn value(text: &str) -> Result<f64, Vec<Fault>> {
        let constants = BTreeMap::from([("r".to_owned(), 0.5), ("zero".to_owned(), 0.0)]);
        let parameters = ["l".to_owned(), "w".to_owned()];
        let names = Names { parameters: &parameters, constants: &constants };
        let mut faults = Vec::new();
        let program = expression(&mut Cursor::new(text), names, &mut faults).map_err(|fault| vec![fault])?;
        if !faults.is_empty() {
            return Err(faults);
        }
        let (mut draws, mut stack) = (Draws::new(1, 2, 3), Vec::new());
        let mut scope = Scope { parameters: &[2.0, 3.0], age: 4.0, draws: &mut draws, stack: &mut stack };
        program.evaluate(&mut scope).map_err(|within| vec![Fault::new(within, "run", "")])
    }

    #[test]
    fn precedence_is_that_of_arithmetic() {
        let cases = [
            ("1+2*3", 7.0),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("2*-l", -4.0),
            ("10-4-3", 3.0),
            ("16/4/2", 2.0),
            ("-7%3", 2.0),
            ("l*w^2+r", 18.5),
            ("l<w && !(l==w)", 1.0),
            ("0 || 0 && 1", 0.0),
            ("l>3 ? 1 : w>2 ? 7 : 8", 7.0),
            ("1 ? 2 : 3 + 4", 2.0),
            ("max(min(l,w),age)", 4.0),
            ("sin(30)", 0.5),
            ("zero == 0 ? 5 : 1/zero", 5.0),
            ("0 && 1/zero", 0.0),
            ("n", 4.0),
        ];
        for (text, wanted) in cases {
            let got = value(text).unwrap_or_else(|faults| panic!("{text}: {faults:?}"));
            assert!((got - wanted).abs() < 1e-12, "{text} gave {got}");
        }
    }

    #[test]
    fn faults_point_at_their_bytes() {
        let place = |fault: &Fault| (fault.within.start, fault.within.end);
        let within = |text: &str| value(text).map_err(|faults| faults.iter().map(place).collect::<Vec<_>>());
        assert_eq!(within("l + xx*yy"), Err(vec![(4, 6), (7, 9)]));
        assert_eq!(within("l / 0"), Err(vec![(0, 5)]));
        assert_eq!(within("1 + w/zero"), Err(vec![(4, 10)]));
        assert_eq!(within("l + "), Err(vec![(4, 4)]));
        assert_eq!(within("min(l)"), Err(vec![(0, 6)]));
        assert_eq!(within("ln(-l)"), Err(vec![(0, 6)]));
    }

    #[test]
    fn deep_nesting_is_refused_and_long_chains_are_not() {
        assert!(value(&"(".repeat(100_000)).is_err());
        assert!(value(&"-".repeat(100_000)).is_err());
        let chain = vec!["l"; 50_000].join("+");
        assert_eq!(value(&chain), Ok(100_000.0));
    }

    #[test]
    fn draws_are_repeatable_and_in_range() {
        let drawn = value("rand(2,3)").unwrap();
        assert!((2.0..3.0).contains(&drawn));
        assert_eq!(value("rand(2,3)"), Ok(drawn));
        assert_eq!(value("normal(l,0)"), Ok(2.0));
    }
}
