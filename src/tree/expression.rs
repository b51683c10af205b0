//! Arithmetic of the rules as flat programs for a stack machine: parsed once, evaluated for every module. Not a language of
//! its own: no assignments, no loops, so every program ends. Logic is 0 and 1; anything but 0 counts as true.

use super::draws::Draws;
use crate::base::maths::{cos, exp, ln, pow, sin};
use std::ops::Range;

/// A function that expressions may call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Min,
    Max,
    Abs,
    Floor,
    Sqrt,
    Sin,
    Cos,
    Exp,
    Ln,
    Rand,
    Normal,
}

/// Every function with its name and number of arguments.
pub(super) const FUNCTIONS: [(&str, Function, usize); 11] = [
    ("min", Function::Min, 2),
    ("max", Function::Max, 2),
    ("abs", Function::Abs, 1),
    ("floor", Function::Floor, 1),
    ("sqrt", Function::Sqrt, 1),
    ("sin", Function::Sin, 1),
    ("cos", Function::Cos, 1),
    ("exp", Function::Exp, 1),
    ("ln", Function::Ln, 1),
    ("rand", Function::Rand, 2),
    ("normal", Function::Normal, 2),
];

/// A dyadic operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Power,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

impl Operator {
    /// The value of `a operator b`; the remainder has the divisor's sign.
    pub fn apply(self, a: f64, b: f64) -> f64 {
        let truth = |holds: bool| if holds { 1.0 } else { 0.0 };
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Remainder => a - b * (a / b).floor(),
            Self::Power => pow(a, b),
            Self::Less => truth(a < b),
            Self::LessEqual => truth(a <= b),
            Self::Greater => truth(a > b),
            Self::GreaterEqual => truth(a >= b),
            Self::Equal => truth(a == b),
            Self::NotEqual => truth(a != b),
        }
    }
}

/// A step of a program. Jumps name the step to go on with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Op {
    /// A number as written.
    Literal(f64),
    /// The value of a named constant.
    Constant(f64),
    /// The module's parameter of this number.
    Parameter(usize),
    /// The number of the derivation step, from 1.
    Age,
    Negate,
    Not,
    /// 1 for anything but 0.
    Truth,
    Dyadic(Operator),
    /// With this number on the right.
    With(Operator, f64),
    Call(Function),
    /// If the top is 0, leaves it and jumps, else drops it.
    And(usize),
    /// Leaves 1 and jumps if the top is not 0, else drops it.
    Or(usize),
    /// Drops the top and jumps if it was 0.
    Branch(usize),
    Jump(usize),
}

/// An expression ready to run; each step remembers the bytes it came from.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Program {
    pub ops: Vec<Op>,
    pub spans: Vec<Range<usize>>,
}

/// What an expression may read.
pub(super) struct Scope<'a> {
    pub parameters: &'a [f64],
    pub age: f64,
    pub draws: &'a mut Draws,
    pub stack: &'a mut Vec<f64>,
}

impl Program {
    pub fn push(&mut self, op: Op, span: Range<usize>) {
        self.ops.push(op);
        self.spans.push(span);
    }

    /// Adds a dyadic operator; a right side that is only a number becomes part of it. `right` is the step it starts with.
    pub fn push_dyadic(&mut self, operator: Operator, right: usize, span: Range<usize>) {
        let op = match self.ops[right..] {
            [Op::Literal(value) | Op::Constant(value)] => {
                self.ops.truncate(right);
                self.spans.truncate(right);
                Op::With(operator, value)
            }
            _ => Op::Dyadic(operator),
        };
        self.push(op, span);
    }

    /// The value, or the bytes of the step whose result was not finite.
    #[inline]
    pub fn evaluate(&self, scope: &mut Scope<'_>) -> Result<f64, Range<usize>> {
        match self.ops[..] {
            [Op::Literal(value)] => Ok(value),
            // The commonest programs, `l > 0.1` and `l*0.9`.
            [Op::Parameter(index), Op::With(operator, value)] if index < scope.parameters.len() => {
                let value = operator.apply(scope.parameters[index], value);
                if value.is_finite() { Ok(value) } else { Err(self.spans[1].clone()) }
            }
            _ => self.run(scope),
        }
    }

    /// Runs the steps. The top of the stack is held apart from the rest.
    fn run(&self, scope: &mut Scope<'_>) -> Result<f64, Range<usize>> {
        let truth = |holds: bool| if holds { 1.0 } else { 0.0 };
        scope.stack.clear();
        let (mut at, mut top) = (0, 0.0);
        while let Some(&op) = self.ops.get(at) {
            if let Op::Literal(_) | Op::Constant(_) | Op::Parameter(_) | Op::Age = op {
                scope.stack.push(top);
            }
            top = match op {
                Op::Literal(value) | Op::Constant(value) => value,
                Op::Parameter(index) => scope.parameters.get(index).copied().unwrap_or(f64::NAN),
                Op::Age => scope.age,
                Op::Negate => -top,
                Op::Not => truth(top == 0.0),
                Op::Truth => truth(top != 0.0),
                Op::Dyadic(operator) => operator.apply(scope.pop(), top),
                Op::With(operator, value) => operator.apply(top, value),
                Op::Call(function) => scope.call(function, top),
                Op::Jump(target) => {
                    at = target;
                    continue;
                }
                Op::Branch(target) => {
                    at = if top == 0.0 { target } else { at + 1 };
                    top = scope.pop();
                    continue;
                }
                Op::And(target) | Op::Or(target) => {
                    let holds = top != 0.0;
                    let decided = holds == matches!(op, Op::Or(_));
                    (at, top) = if decided { (target, truth(holds)) } else { (at + 1, scope.pop()) };
                    continue;
                }
            };
            if !top.is_finite() {
                return Err(self.spans[at].clone());
            }
            at += 1;
        }
        Ok(top)
    }
}

impl Scope<'_> {
    fn pop(&mut self) -> f64 {
        self.stack.pop().unwrap_or(0.0)
    }

    /// The value of a function whose last argument is `last`.
    fn call(&mut self, function: Function, last: f64) -> f64 {
        match function {
            Function::Min => self.pop().min(last),
            Function::Max => self.pop().max(last),
            Function::Abs => last.abs(),
            Function::Floor => last.floor(),
            Function::Sqrt => last.sqrt(),
            Function::Sin => sin(last.to_radians()),
            Function::Cos => cos(last.to_radians()),
            Function::Exp => exp(last),
            Function::Ln => ln(last),
            Function::Rand => {
                let low = self.pop();
                self.draws.stream().range(low, last)
            }
            Function::Normal => {
                let mean = self.pop();
                mean + last * self.draws.stream().normal()
            }
        }
    }
}
