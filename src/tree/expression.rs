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
    Call(Function),
    /// Leaves 0 and jumps if the top is 0, else drops it.
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

    /// The value, or the bytes of the step whose result was not finite.
    pub fn evaluate(&self, scope: &mut Scope<'_>) -> Result<f64, Range<usize>> {
        if let [Op::Literal(value)] = self.ops[..] {
            return Ok(value);
        }
        scope.stack.clear();
        let mut at = 0;
        while let Some(&op) = self.ops.get(at) {
            at = scope.step(op, at);
            if scope.stack.last().is_some_and(|value| !value.is_finite()) {
                return Err(self.spans[at - 1].clone());
            }
        }
        Ok(scope.pop())
    }
}

impl Scope<'_> {
    fn pop(&mut self) -> f64 {
        self.stack.pop().unwrap_or(0.0)
    }

    /// Runs one step and returns the number of the next.
    fn step(&mut self, op: Op, at: usize) -> usize {
        let truth = |holds: bool| if holds { 1.0 } else { 0.0 };
        let value = match op {
            Op::Jump(target) => return target,
            Op::Branch(target) => return if self.pop() == 0.0 { target } else { at + 1 },
            Op::And(target) | Op::Or(target) => return self.shortcut(op, target, at),
            Op::Literal(value) | Op::Constant(value) => value,
            Op::Parameter(index) => self.parameters.get(index).copied().unwrap_or(f64::NAN),
            Op::Age => self.age,
            Op::Negate => -self.pop(),
            Op::Not => truth(self.pop() == 0.0),
            Op::Truth => truth(self.pop() != 0.0),
            Op::Dyadic(operator) => {
                let b = self.pop();
                operator.apply(self.pop(), b)
            }
            Op::Call(function) => self.call(function),
        };
        self.stack.push(value);
        at + 1
    }

    fn shortcut(&mut self, op: Op, target: usize, at: usize) -> usize {
        let holds = self.pop() != 0.0;
        if holds == matches!(op, Op::Or(_)) {
            self.stack.push(if holds { 1.0 } else { 0.0 });
            return target;
        }
        at + 1
    }

    fn call(&mut self, function: Function) -> f64 {
        let last = self.pop();
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
