//! An interpreter of the committed kernels, which counts what an invocation does: the floating-point operations that are executed on the way it
//! takes through its branches and loops, not those that stand in the text.

use std::cell::RefCell;
use std::collections::HashMap;

use naga::{
    BinaryOperator, Block, BuiltIn, Expression, Function, Handle, Literal, MathFunction, Module, ScalarKind, Statement,
    SwitchValue, Type, TypeInner, UnaryOperator,
};

/// What an invocation did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Floating-point operations: each number of a sum, a difference, a product, a quotient, a root, an exponential, a logarithm, a smaller or a
    /// larger of two counts one, a multiply-add two. Integers, comparisons, choices and signs count nothing.
    pub operations: u64,
    /// Of these the quotients, roots, exponentials and logarithms, which take a device several times as long.
    pub slow: u64,
    /// Bytes loaded from buffers, from memory or from a cache.
    pub loaded: u64,
    /// Bytes stored into buffers.
    pub stored: u64,
}

/// A kernel, and the buffers that are bound to it.
pub struct Interpreter<'a> {
    module: &'a Module,
    entry: &'a Function,
    buffers: &'a [&'a [u8]],
}

/// A word that was stored: the binding, the place in its buffer (bytes) and the bits.
pub type Stored = (u32, usize, u32);

#[derive(Clone, Debug)]
enum Value {
    Float(f32),
    Unsigned(u32),
    Signed(i32),
    Bool(bool),
    Many(Vec<Value>),
    Pointer(Pointer),
}

#[derive(Clone, Debug)]
enum Pointer {
    /// A variable of the invocation, and the way to a part of it.
    Variable(usize, Vec<usize>),
    /// A part of a buffer: binding, place (bytes), type.
    Buffer(u32, usize, Shape),
}

/// The type of a part of a buffer.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Type(Handle<Type>),
    Scalar(ScalarKind),
}

/// What happens after a statement.
enum Flow {
    Next,
    Break,
    Continue,
    Return(Option<Value>),
}

/// A function that is being run.
struct Frame<'a> {
    function: &'a Function,
    arguments: Vec<Value>,
    /// The first of its variables.
    variables: usize,
    values: HashMap<Handle<Expression>, Value>,
}

/// All that an invocation changes.
#[derive(Default)]
struct State {
    counts: Counts,
    variables: Vec<Value>,
    globals: HashMap<Handle<naga::GlobalVariable>, usize>,
    stored: Vec<Stored>,
}

impl<'a> Interpreter<'a> {
    /// Of an entry point, with the contents of its buffers by their bindings.
    ///
    /// # Panics
    ///
    /// If the module has no entry point of this name.
    pub fn new(module: &'a Module, entry_point: &str, buffers: &'a [&'a [u8]]) -> Self {
        let found = module.entry_points.iter().find(|entry| entry.name == entry_point);
        Self { module, entry: &found.expect("the module has every kernel").function, buffers }
    }

    /// Runs the invocation with a global index.
    pub fn run(&self, id: [u32; 3]) -> (Counts, Vec<Stored>) {
        let state = RefCell::new(State::default());
        let id = Value::Many(id.map(Value::Unsigned).into());
        let arguments = self.entry.arguments.iter().map(|argument| match argument.binding {
            Some(naga::Binding::BuiltIn(BuiltIn::GlobalInvocationId)) => id.clone(),
            ref other => unreachable!("no kernel that is counted takes {other:?}"),
        });
        self.call(self.entry, arguments.collect(), &state);
        let State { counts, stored, .. } = state.into_inner();
        (counts, stored)
    }

    fn call(&self, function: &'a Function, arguments: Vec<Value>, state: &RefCell<State>) -> Option<Value> {
        let variables = state.borrow().variables.len();
        let mut frame = Frame { function, arguments, variables, values: HashMap::new() };
        for (_, variable) in function.local_variables.iter() {
            let value =
                variable.init.map_or_else(|| self.zero(variable.ty), |init| self.evaluate(&mut frame, init, state));
            state.borrow_mut().variables.push(value);
        }
        match self.block(&mut frame, &function.body, state) {
            Flow::Return(value) => value,
            _ => None,
        }
    }

    fn block(&self, frame: &mut Frame<'a>, block: &'a Block, state: &RefCell<State>) -> Flow {
        for statement in block {
            match self.statement(frame, statement, state) {
                Flow::Next => {}
                other => return other,
            }
        }
        Flow::Next
    }

    fn statement(&self, frame: &mut Frame<'a>, statement: &'a Statement, state: &RefCell<State>) -> Flow {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    let value = self.compute(frame, expression, state);
                    frame.values.insert(expression, value);
                }
            }
            Statement::Block(block) => return self.block(frame, block, state),
            Statement::If { condition, accept, reject } => {
                let accepted = self.evaluate(frame, *condition, state).bool();
                return self.block(frame, if accepted { accept } else { reject }, state);
            }
            Statement::Switch { selector, cases } => {
                let selector = self.evaluate(frame, *selector, state).bits();
                let is_meant = |value: &SwitchValue| match *value {
                    SwitchValue::I32(value) => value as u32 == selector,
                    SwitchValue::U32(value) => value == selector,
                    SwitchValue::Default => false,
                };
                let default = || cases.iter().position(|case| case.value == SwitchValue::Default);
                let first = cases.iter().position(|case| is_meant(&case.value)).or_else(default);
                for case in cases.iter().skip(first.unwrap_or(cases.len())) {
                    match self.block(frame, &case.body, state) {
                        Flow::Next if case.fall_through => {}
                        Flow::Next | Flow::Break => break,
                        other => return other,
                    }
                }
            }
            Statement::Loop { body, continuing, break_if } => loop {
                match self.block(frame, body, state) {
                    Flow::Next | Flow::Continue => {}
                    Flow::Break => break,
                    other => return other,
                }
                self.block(frame, continuing, state);
                if break_if.is_some_and(|condition| self.evaluate(frame, condition, state).bool()) {
                    break;
                }
            },
            Statement::Break => return Flow::Break,
            Statement::Continue => return Flow::Continue,
            Statement::Return { value } => {
                return Flow::Return(value.map(|value| self.evaluate(frame, value, state)));
            }
            Statement::Store { pointer, value } => {
                let pointer = self.evaluate(frame, *pointer, state).pointer();
                let value = self.evaluate(frame, *value, state);
                store(&mut state.borrow_mut(), &pointer, value);
            }
            Statement::Call { function, arguments, result } => {
                let arguments = arguments.iter().map(|&argument| self.evaluate(frame, argument, state)).collect();
                let value = self.call(&self.module.functions[*function], arguments, state);
                if let (Some(result), Some(value)) = (result, value) {
                    frame.values.insert(*result, value);
                }
            }
            other => unreachable!("no kernel that is counted has {other:?}"),
        }
        Flow::Next
    }

    /// The value of an expression that is there already, or that needs no statement.
    fn evaluate(&self, frame: &mut Frame<'a>, handle: Handle<Expression>, state: &RefCell<State>) -> Value {
        match frame.values.get(&handle) {
            Some(value) => value.clone(),
            None => self.compute(frame, handle, state),
        }
    }

    fn compute(&self, frame: &mut Frame<'a>, handle: Handle<Expression>, state: &RefCell<State>) -> Value {
        let expression = &frame.function.expressions[handle];
        let mut of = |handle| self.evaluate(frame, handle, state);
        match expression {
            Expression::Access { base, index } => {
                let index = of(*index).bits() as usize;
                self.part(of(*base), index)
            }
            Expression::AccessIndex { base, index } => self.part(of(*base), *index as usize),
            Expression::Splat { size, value } => Value::Many(vec![of(*value); *size as usize]),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = of(*vector).many();
                Value::Many(pattern[..*size as usize].iter().map(|&from| vector[from as usize].clone()).collect())
            }
            Expression::Compose { ty, components } => {
                let components = components.iter().map(|&component| of(component)).collect();
                self.composed(*ty, components)
            }
            Expression::FunctionArgument(index) => frame.arguments[*index as usize].clone(),
            Expression::GlobalVariable(variable) => Value::Pointer(self.global(*variable, state)),
            Expression::LocalVariable(variable) => {
                Value::Pointer(Pointer::Variable(frame.variables + variable.index(), Vec::new()))
            }
            Expression::Load { pointer } => {
                let pointer = of(*pointer).pointer();
                self.load(&mut state.borrow_mut(), &pointer)
            }
            Expression::Unary { op, expr } => unary(*op, of(*expr)),
            Expression::Binary { op, left, right } => {
                let (left, right) = (of(*left), of(*right));
                count_binary(&mut state.borrow_mut().counts, *op, &left, &right);
                binary(*op, left, right)
            }
            Expression::Select { condition, accept, reject } => {
                let (condition, accept, reject) = (of(*condition), of(*accept), of(*reject));
                select(condition, accept, reject)
            }
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let mut arguments = vec![of(*arg)];
                arguments.extend([arg1, arg2].into_iter().flatten().map(|&argument| of(argument)));
                math(&mut state.borrow_mut().counts, *fun, arguments)
            }
            Expression::As { expr, kind, convert } => converted(of(*expr), *kind, convert.is_some()),
            Expression::ArrayLength(pointer) => {
                let Pointer::Buffer(binding, at, Shape::Type(ty)) = of(*pointer).pointer() else {
                    unreachable!("only buffers are unsized")
                };
                let TypeInner::Array { stride, .. } = self.module.types[ty].inner else {
                    unreachable!("only arrays have a length")
                };
                Value::Unsigned(((self.buffers[binding as usize].len() - at) / stride as usize) as u32)
            }
            constant => self.constant(constant),
        }
    }

    /// The value of a constant expression.
    fn constant(&self, expression: &Expression) -> Value {
        let of = |handle: Handle<Expression>| self.constant(&self.module.global_expressions[handle]);
        match expression {
            Expression::Literal(Literal::F32(value)) => Value::Float(*value),
            Expression::Literal(Literal::U32(value)) => Value::Unsigned(*value),
            Expression::Literal(Literal::I32(value)) => Value::Signed(*value),
            Expression::Literal(Literal::Bool(value)) => Value::Bool(*value),
            Expression::ZeroValue(ty) => self.zero(*ty),
            Expression::Constant(constant) => of(self.module.constants[*constant].init),
            Expression::Splat { size, value } => Value::Many(vec![of(*value); *size as usize]),
            Expression::Compose { ty, components } => {
                self.composed(*ty, components.iter().map(|&component| of(component)).collect())
            }
            other => unreachable!("no kernel that is counted has {other:?}"),
        }
    }

    /// A vector may be composed of vectors.
    fn composed(&self, ty: Handle<Type>, components: Vec<Value>) -> Value {
        if !matches!(self.module.types[ty].inner, TypeInner::Vector { .. }) {
            return Value::Many(components);
        }
        let flat = |component| match component {
            Value::Many(values) => values,
            scalar => vec![scalar],
        };
        Value::Many(components.into_iter().flat_map(flat).collect())
    }

    fn global(&self, handle: Handle<naga::GlobalVariable>, state: &RefCell<State>) -> Pointer {
        let variable = &self.module.global_variables[handle];
        if let Some(binding) = &variable.binding {
            return Pointer::Buffer(binding.binding, 0, Shape::Type(variable.ty));
        }
        let mut state = state.borrow_mut();
        if let Some(&index) = state.globals.get(&handle) {
            return Pointer::Variable(index, Vec::new());
        }
        let index = state.variables.len();
        let value = variable.init.map(|init| self.constant(&self.module.global_expressions[init]));
        state.variables.push(value.unwrap_or_else(|| self.zero(variable.ty)));
        state.globals.insert(handle, index);
        Pointer::Variable(index, Vec::new())
    }

    /// A part of a value, or a pointer to a part of what a pointer shows.
    fn part(&self, of: Value, index: usize) -> Value {
        match of {
            Value::Many(values) => values[index].clone(),
            Value::Pointer(Pointer::Variable(variable, mut way)) => {
                way.push(index);
                Value::Pointer(Pointer::Variable(variable, way))
            }
            Value::Pointer(Pointer::Buffer(binding, at, Shape::Type(ty))) => {
                let (offset, shape) = match &self.module.types[ty].inner {
                    TypeInner::Struct { members, .. } => {
                        (members[index].offset as usize, Shape::Type(members[index].ty))
                    }
                    TypeInner::Array { base, stride, .. } => (*stride as usize * index, Shape::Type(*base)),
                    TypeInner::Vector { scalar, .. } => (4 * index, Shape::Scalar(scalar.kind)),
                    other => unreachable!("{other:?} has no parts"),
                };
                Value::Pointer(Pointer::Buffer(binding, at + offset, shape))
            }
            other => unreachable!("{other:?} has no parts"),
        }
    }

    fn load(&self, state: &mut State, pointer: &Pointer) -> Value {
        match pointer {
            Pointer::Variable(variable, way) => {
                way.iter().fold(&state.variables[*variable], |value, &index| value.at(index)).clone()
            }
            Pointer::Buffer(binding, at, shape) => {
                self.read(&mut state.counts, self.buffers[*binding as usize], *at, *shape)
            }
        }
    }

    fn read(&self, counts: &mut Counts, buffer: &[u8], at: usize, shape: Shape) -> Value {
        let mut scalar = |kind, at: usize| {
            counts.loaded += 4;
            let bits = u32::from_le_bytes(buffer[at..at + 4].try_into().expect("four bytes"));
            of_bits(kind, bits)
        };
        let ty = match shape {
            Shape::Scalar(kind) => return scalar(kind, at),
            Shape::Type(ty) => ty,
        };
        match &self.module.types[ty].inner {
            TypeInner::Scalar(of) => scalar(of.kind, at),
            TypeInner::Vector { size, scalar: of } => {
                Value::Many((0..*size as usize).map(|index| scalar(of.kind, at + 4 * index)).collect())
            }
            TypeInner::Struct { members, .. } => {
                let member = |member: &naga::StructMember| {
                    self.read(counts, buffer, at + member.offset as usize, Shape::Type(member.ty))
                };
                Value::Many(members.iter().map(member).collect())
            }
            other => unreachable!("no kernel that is counted loads {other:?}"),
        }
    }

    fn zero(&self, ty: Handle<Type>) -> Value {
        match &self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => of_bits(scalar.kind, 0),
            TypeInner::Vector { size, scalar } => Value::Many(vec![of_bits(scalar.kind, 0); *size as usize]),
            TypeInner::Struct { members, .. } => {
                Value::Many(members.iter().map(|member| self.zero(member.ty)).collect())
            }
            TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
                Value::Many(vec![self.zero(*base); count.get() as usize])
            }
            other => unreachable!("no kernel that is counted has a variable of {other:?}"),
        }
    }
}

impl Value {
    fn bool(&self) -> bool {
        matches!(self, Self::Bool(true))
    }

    fn float(&self) -> f32 {
        match self {
            Self::Float(value) => *value,
            other => unreachable!("{other:?} is no float"),
        }
    }

    fn bits(&self) -> u32 {
        match self {
            Self::Float(value) => value.to_bits(),
            Self::Unsigned(value) => *value,
            Self::Signed(value) => *value as u32,
            Self::Bool(value) => u32::from(*value),
            other => unreachable!("{other:?} is no scalar"),
        }
    }

    fn many(self) -> Vec<Self> {
        match self {
            Self::Many(values) => values,
            other => vec![other],
        }
    }

    fn pointer(self) -> Pointer {
        match self {
            Self::Pointer(pointer) => pointer,
            other => unreachable!("{other:?} is no pointer"),
        }
    }

    fn at(&self, index: usize) -> &Self {
        match self {
            Self::Many(values) => &values[index],
            other => unreachable!("{other:?} has no parts"),
        }
    }

    /// Floats in it.
    fn floats(&self) -> u64 {
        match self {
            Self::Float(_) => 1,
            Self::Many(values) => values.iter().map(Self::floats).sum(),
            _ => 0,
        }
    }
}

fn of_bits(kind: ScalarKind, bits: u32) -> Value {
    match kind {
        ScalarKind::Float => Value::Float(f32::from_bits(bits)),
        ScalarKind::Sint => Value::Signed(bits as i32),
        ScalarKind::Bool => Value::Bool(bits != 0),
        _ => Value::Unsigned(bits),
    }
}

fn store(state: &mut State, pointer: &Pointer, value: Value) {
    match pointer {
        Pointer::Variable(variable, way) => {
            let mut place = &mut state.variables[*variable];
            for &index in way {
                let Value::Many(values) = place else { unreachable!("a scalar has no parts") };
                place = &mut values[index];
            }
            *place = value;
        }
        Pointer::Buffer(binding, at, _) => {
            for (index, scalar) in value.many().into_iter().enumerate() {
                state.counts.stored += 4;
                state.stored.push((*binding, at + 4 * index, scalar.bits()));
            }
        }
    }
}

/// Applies a function to every lane; a scalar beside vectors stands for each of their lanes.
fn lanes(values: &[&Value], of: &dyn Fn(&[&Value]) -> Value) -> Value {
    let count = values.iter().find_map(|value| match value {
        Value::Many(values) => Some(values.len()),
        _ => None,
    });
    let Some(count) = count else { return of(values) };
    let lane = |index: usize| {
        let of_lane: Vec<&Value> = values
            .iter()
            .map(|value| match value {
                Value::Many(values) => &values[index],
                scalar => scalar,
            })
            .collect();
        of(&of_lane)
    };
    Value::Many((0..count).map(lane).collect())
}

fn unary(op: UnaryOperator, value: Value) -> Value {
    lanes(&[&value], &|lane| match (op, lane[0]) {
        (UnaryOperator::Negate, Value::Float(value)) => Value::Float(-value),
        (UnaryOperator::Negate, Value::Signed(value)) => Value::Signed(value.wrapping_neg()),
        (UnaryOperator::LogicalNot, Value::Bool(value)) => Value::Bool(!value),
        (UnaryOperator::BitwiseNot, Value::Unsigned(value)) => Value::Unsigned(!value),
        other => unreachable!("no kernel that is counted has {other:?}"),
    })
}

fn count_binary(counts: &mut Counts, op: BinaryOperator, left: &Value, right: &Value) {
    use BinaryOperator::{Add, Divide, Modulo, Multiply, Subtract};
    let floats = if left.floats() > right.floats() { left.floats() } else { right.floats() };
    if matches!(op, Add | Subtract | Multiply | Divide | Modulo) {
        counts.operations += floats;
    }
    if matches!(op, Divide | Modulo) {
        counts.slow += floats;
    }
}

fn binary(op: BinaryOperator, left: Value, right: Value) -> Value {
    use BinaryOperator as Op;
    lanes(&[&left, &right], &|lane| match (lane[0], lane[1]) {
        (&Value::Float(a), &Value::Float(b)) => match op {
            Op::Add => Value::Float(a + b),
            Op::Subtract => Value::Float(a - b),
            Op::Multiply => Value::Float(a * b),
            Op::Divide => Value::Float(a / b),
            Op::Modulo => Value::Float(a % b),
            _ => Value::Bool(compared(op, a.partial_cmp(&b))),
        },
        (&Value::Bool(a), &Value::Bool(b)) => Value::Bool(match op {
            Op::LogicalAnd | Op::And => a & b,
            Op::LogicalOr | Op::InclusiveOr => a | b,
            _ => compared(op, Some(a.cmp(&b))),
        }),
        (&Value::Signed(a), &Value::Signed(b)) if is_comparison(op) => Value::Bool(compared(op, Some(a.cmp(&b)))),
        (a, b) => {
            let (bits_a, bits_b) = (a.bits(), b.bits());
            if is_comparison(op) {
                return Value::Bool(compared(op, Some(bits_a.cmp(&bits_b))));
            }
            let bits = match op {
                Op::Add => bits_a.wrapping_add(bits_b),
                Op::Subtract => bits_a.wrapping_sub(bits_b),
                Op::Multiply => bits_a.wrapping_mul(bits_b),
                Op::Divide => bits_a / bits_b,
                Op::Modulo => bits_a % bits_b,
                Op::And => bits_a & bits_b,
                Op::ExclusiveOr => bits_a ^ bits_b,
                Op::InclusiveOr => bits_a | bits_b,
                Op::ShiftLeft => bits_a << bits_b,
                Op::ShiftRight => bits_a >> bits_b,
                other => unreachable!("no kernel that is counted has {other:?} of integers"),
            };
            if matches!(a, Value::Signed(_)) { Value::Signed(bits as i32) } else { Value::Unsigned(bits) }
        }
    })
}

fn is_comparison(op: BinaryOperator) -> bool {
    use BinaryOperator::{Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual};
    matches!(op, Equal | NotEqual | Less | LessEqual | Greater | GreaterEqual)
}

fn compared(op: BinaryOperator, order: Option<std::cmp::Ordering>) -> bool {
    use std::cmp::Ordering::{Equal, Greater, Less};
    match op {
        BinaryOperator::Equal => order == Some(Equal),
        BinaryOperator::NotEqual => order != Some(Equal),
        BinaryOperator::Less => order == Some(Less),
        BinaryOperator::LessEqual => matches!(order, Some(Less | Equal)),
        BinaryOperator::Greater => order == Some(Greater),
        BinaryOperator::GreaterEqual => matches!(order, Some(Greater | Equal)),
        other => unreachable!("{other:?} compares nothing"),
    }
}

fn select(condition: Value, accept: Value, reject: Value) -> Value {
    match condition {
        Value::Bool(condition) => {
            if condition {
                accept
            } else {
                reject
            }
        }
        lanes_of_condition => lanes(&[&lanes_of_condition, &accept, &reject], &|lane| {
            if lane[0].bool() { lane[1].clone() } else { lane[2].clone() }
        }),
    }
}

fn math(counts: &mut Counts, function: MathFunction, arguments: Vec<Value>) -> Value {
    use MathFunction as Math;
    let floats = arguments.iter().map(Value::floats).fold(0, |a, b| if a > b { a } else { b });
    match function {
        Math::Abs | Math::Sign => {}
        Math::Fma => counts.operations += 2 * floats,
        Math::Dot => counts.operations += (2 * floats).saturating_sub(1),
        _ => counts.operations += floats,
    }
    if matches!(function, Math::Sqrt | Math::InverseSqrt | Math::Exp | Math::Exp2 | Math::Log | Math::Log2 | Math::Pow)
    {
        counts.slow += floats;
    }
    if function == Math::Dot {
        let (a, b) = (arguments[0].clone().many(), arguments[1].clone().many());
        return Value::Float(a.iter().zip(&b).map(|(a, b)| a.float() * b.float()).sum());
    }
    let arguments: Vec<&Value> = arguments.iter().collect();
    lanes(&arguments, &|lane| {
        if let Value::Unsigned(_) | Value::Signed(_) = lane[0] {
            return integer_math(function, lane);
        }
        let argument = |index: usize| f64::from(lane[index].float());
        let value = match function {
            Math::Abs => argument(0).abs(),
            Math::Min => argument(0).min(argument(1)),
            Math::Max => argument(0).max(argument(1)),
            Math::Clamp => argument(0).max(argument(1)).min(argument(2)),
            Math::Floor => argument(0).floor(),
            Math::Sqrt => argument(0).sqrt(),
            Math::InverseSqrt => 1.0 / argument(0).sqrt(),
            Math::Exp => argument(0).exp(),
            Math::Exp2 => argument(0).exp2(),
            Math::Log => argument(0).ln(),
            Math::Log2 => argument(0).log2(),
            Math::Fma => argument(0) * argument(1) + argument(2),
            other => unreachable!("no kernel that is counted has {other:?}"),
        };
        Value::Float(value as f32)
    })
}

fn integer_math(function: MathFunction, lane: &[&Value]) -> Value {
    let (a, b) = (lane[0].bits(), lane.get(1).map_or(0, |value| value.bits()));
    match function {
        MathFunction::Min => Value::Unsigned(a.min(b)),
        MathFunction::Max => Value::Unsigned(a.max(b)),
        other => unreachable!("no kernel that is counted has {other:?} of integers"),
    }
}

fn converted(value: Value, kind: ScalarKind, converts: bool) -> Value {
    lanes(&[&value], &|lane| {
        if !converts {
            return of_bits(kind, lane[0].bits());
        }
        match (lane[0], kind) {
            (&Value::Float(value), ScalarKind::Uint) => Value::Unsigned(value as u32),
            (&Value::Float(value), ScalarKind::Sint) => Value::Signed(value as i32),
            (&Value::Unsigned(value), ScalarKind::Float) => Value::Float(value as f32),
            (&Value::Signed(value), ScalarKind::Float) => Value::Float(value as f32),
            (other, kind) => of_bits(kind, other.bits()),
        }
    })
}
