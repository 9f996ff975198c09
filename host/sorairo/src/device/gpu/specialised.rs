//! One kernel of a SPIR-V module, specialised, without the code that its variant excludes.
//!
//! rust-gpu compiles everything that a kernel may need into one function; a variant needs between a fifth and a
//! twentieth of it. Drivers remove the rest too, but only after they have translated all of it, which takes several
//! times as long as translating what remains. Constants are propagated along the branches that they leave open (Wegman
//! and Zadeck 1991, *ACM TOPLAS* 13(2), section 3.4, doi:10.1145/103135.103136), for 32-bit integers and booleans only,
//! and without the optimism about loops. Section numbers are those of the SPIR-V 1.3 specification.

use std::collections::{HashMap, HashSet};

/// Words before the first instruction (2.3).
const HEADER: usize = 5;

/// Opcodes (3.32), as far as they are read here.
mod op {
    pub const ENTRY_POINT: u32 = 15;
    pub const EXECUTION_MODE: u32 = 16;
    pub const CONSTANT_TRUE: u32 = 41;
    pub const CONSTANT_FALSE: u32 = 42;
    pub const CONSTANT: u32 = 43;
    pub const SPEC_CONSTANT: u32 = 50;
    pub const FUNCTION: u32 = 54;
    pub const FUNCTION_END: u32 = 56;
    pub const DECORATE: u32 = 71;
    pub const I_ADD: u32 = 128;
    pub const I_SUB: u32 = 130;
    pub const LOGICAL_EQUAL: u32 = 164;
    pub const LOGICAL_NOT_EQUAL: u32 = 165;
    pub const LOGICAL_OR: u32 = 166;
    pub const LOGICAL_AND: u32 = 167;
    pub const LOGICAL_NOT: u32 = 168;
    pub const SELECT: u32 = 169;
    pub const I_EQUAL: u32 = 170;
    pub const I_NOT_EQUAL: u32 = 171;
    pub const U_GREATER_THAN: u32 = 172;
    pub const U_GREATER_THAN_EQUAL: u32 = 174;
    pub const U_LESS_THAN: u32 = 176;
    pub const U_LESS_THAN_EQUAL: u32 = 178;
    pub const SHIFT_RIGHT_LOGICAL: u32 = 194;
    pub const SHIFT_LEFT_LOGICAL: u32 = 196;
    pub const BITWISE_OR: u32 = 197;
    pub const BITWISE_XOR: u32 = 198;
    pub const BITWISE_AND: u32 = 199;
    pub const PHI: u32 = 245;
    pub const LOOP_MERGE: u32 = 246;
    pub const SELECTION_MERGE: u32 = 247;
    pub const LABEL: u32 = 248;
    pub const BRANCH: u32 = 249;
    pub const BRANCH_CONDITIONAL: u32 = 250;
    pub const SWITCH: u32 = 251;
}

/// The decoration that makes a constant one of specialisation (3.20).
const SPEC_ID: u32 = 1;

/// The words of a module with only this one of its kernels, and with its specialisation constant fixed to this value.
/// Branches on the constant are decided, and unreachable blocks removed.
///
/// # Panics
///
/// If the module is no SPIR-V or has no such kernel.
pub fn specialised(words: &[u32], entry_point: &str, value: u32) -> Vec<u32> {
    let instructions: Vec<&[u32]> = Instructions(&words[HEADER..]).collect();
    let first = instructions.iter().position(|it| opcode(it) == op::FUNCTION).expect("a module has functions");
    let (globals, functions) = instructions.split_at(first);
    let kernel = globals.iter().find(|it| opcode(it) == op::ENTRY_POINT && is_named(it, entry_point));
    let kernel = kernel.expect("the module has the kernel")[2];
    let mut specialised = words[..HEADER].to_vec();
    for it in globals {
        match opcode(it) {
            op::ENTRY_POINT if it[2] != kernel => {}
            op::EXECUTION_MODE if it[1] != kernel => {}
            op::DECORATE if it[2] == SPEC_ID => {}
            op::SPEC_CONSTANT => specialised.extend([head(op::CONSTANT, 4), it[1], it[2], value]),
            _ => specialised.extend_from_slice(it),
        }
    }
    let mut of_kernel = functions.split_inclusive(|it| opcode(it) == op::FUNCTION_END);
    let function = of_kernel.find(|function| function[0][2] == kernel).expect("an entry point is a function");
    specialised.extend(reached(function, constants(globals, value)));
    specialised
}

/// The instructions of a stream of words.
struct Instructions<'a>(&'a [u32]);

impl<'a> Iterator for Instructions<'a> {
    type Item = &'a [u32];

    fn next(&mut self) -> Option<Self::Item> {
        let length = (*self.0.first()? >> 16) as usize;
        let (instruction, rest) = self.0.split_at(length.max(1));
        self.0 = rest;
        Some(instruction)
    }
}

/// What an instruction does.
fn opcode(instruction: &[u32]) -> u32 {
    instruction[0] & 0xffff
}

/// The first word of an instruction of so many words.
fn head(opcode: u32, words: u32) -> u32 {
    words << 16 | opcode
}

/// Whether an entry point has this name, a literal that ends with a zero byte (2.2.1).
fn is_named(entry_point: &[u32], name: &str) -> bool {
    let bytes = entry_point[3..].iter().flat_map(|word| word.to_le_bytes());
    bytes.take_while(|&byte| byte != 0).eq(name.bytes())
}

/// The constants of one word, by their identifiers; truth values are 1 and 0.
fn constants(globals: &[&[u32]], value: u32) -> HashMap<u32, u32> {
    let known = globals.iter().filter_map(|it| match (opcode(it), it.len()) {
        (op::CONSTANT_TRUE, _) => Some((it[2], 1)),
        (op::CONSTANT_FALSE, _) => Some((it[2], 0)),
        (op::CONSTANT, 4) => Some((it[2], it[3])),
        (op::SPEC_CONSTANT, _) => Some((it[2], value)),
        _ => None,
    });
    known.collect()
}

/// A stretch of instructions that begins with a label and ends with a branch.
struct Block<'a> {
    instructions: &'a [&'a [u32]],
    /// Where it merges again, if it says so.
    merges: Vec<u32>,
    /// Where it can go.
    successors: Vec<u32>,
}

impl<'a> Block<'a> {
    fn new(instructions: &'a [&'a [u32]]) -> Self {
        let last = instructions[instructions.len() - 1];
        let before = instructions[instructions.len() - 2];
        let merges = match opcode(before) {
            op::SELECTION_MERGE => vec![before[1]],
            op::LOOP_MERGE => vec![before[1], before[2]],
            _ => vec![],
        };
        let successors = match opcode(last) {
            op::BRANCH => vec![last[1]],
            op::BRANCH_CONDITIONAL => vec![last[2], last[3]],
            op::SWITCH => [last[2]].into_iter().chain(last[3..].chunks(2).map(|case| case[1])).collect(),
            _ => vec![],
        };
        Self { instructions, merges, successors }
    }

    /// The one side to which it goes, if its condition is known. A loop keeps the branch that ends its rounds, which
    /// has no merge: without a way back it would be no loop (2.11).
    fn decided(&self, known: &HashMap<u32, u32>) -> Option<u32> {
        let last = self.instructions[self.instructions.len() - 1];
        if opcode(last) != op::BRANCH_CONDITIONAL || self.merges.is_empty() {
            return None;
        }
        Some(if *known.get(&last[1])? == 0 { last[3] } else { last[2] })
    }
}

/// What was found out about the blocks of a function.
struct Reached {
    known: HashMap<u32, u32>,
    blocks: HashSet<u32>,
    /// From which block to which.
    branches: HashSet<(u32, u32)>,
}

/// The words of a function without the blocks that nothing reaches.
fn reached(function: &[&[u32]], known: HashMap<u32, u32>) -> Vec<u32> {
    let begin = function.iter().position(|it| opcode(it) == op::LABEL).expect("a kernel has a block");
    let (before, body) = function.split_at(begin);
    let (end, body) = body.split_last().expect("a function ends");
    let starts: Vec<usize> = (0..body.len()).filter(|&i| opcode(body[i]) == op::LABEL).collect();
    let ends = starts[1..].iter().copied().chain([body.len()]);
    let labels: Vec<u32> = starts.iter().map(|&start| body[start][1]).collect();
    let blocks: Vec<Block<'_>> = starts.iter().zip(ends).map(|(&start, end)| Block::new(&body[start..end])).collect();
    let blocks: HashMap<u32, Block<'_>> = labels.iter().copied().zip(blocks).collect();
    let reached = propagated(&blocks, labels[0], known);
    let mut words = before.concat();
    for label in labels.iter().filter(|label| reached.blocks.contains(label)) {
        write_block(&blocks[label], *label, &reached, &mut words);
    }
    words.extend_from_slice(end);
    words
}

/// Follows the branches from the first block, as far as constants leave them open.
fn propagated(blocks: &HashMap<u32, Block<'_>>, first: u32, known: HashMap<u32, u32>) -> Reached {
    let mut reached = Reached { known, blocks: HashSet::from([first]), branches: HashSet::new() };
    let mut seen = HashSet::new();
    for label in in_order(blocks, first) {
        seen.insert(label);
        if !reached.blocks.contains(&label) {
            continue;
        }
        let block = &blocks[&label];
        for it in block.instructions {
            let value = match opcode(it) {
                op::PHI => joined(it, label, &seen, &reached),
                _ => evaluated(it, &reached.known),
            };
            if let Some(value) = value {
                reached.known.insert(it[2], value);
            }
        }
        let decided = block.decided(&reached.known).map(|successor| vec![successor]);
        if decided.is_none() || block.merges.len() == 2 {
            reached.blocks.extend(&block.merges);
        }
        for &successor in decided.as_ref().unwrap_or(&block.successors) {
            reached.blocks.insert(successor);
            reached.branches.insert((label, successor));
        }
    }
    reached
}

/// The blocks, each after all that lead to it except from behind, in a loop: the reverse of the order in which a search
/// leaves them.
fn in_order(blocks: &HashMap<u32, Block<'_>>, first: u32) -> Vec<u32> {
    let mut order = Vec::with_capacity(blocks.len());
    let mut entered = HashSet::from([first]);
    let mut path = vec![(first, 0)];
    while let Some((label, next)) = path.last_mut() {
        let block = &blocks[label];
        let successor = block.merges.iter().chain(&block.successors).nth(*next);
        *next += 1;
        match successor {
            Some(&successor) if entered.insert(successor) => path.push((successor, 0)),
            Some(_) => {}
            None => {
                order.push(*label);
                path.pop();
            }
        }
    }
    order.reverse();
    order
}

/// The value of a phi, if all branches that lead to it bring the same.
fn joined(phi: &[u32], label: u32, seen: &HashSet<u32>, reached: &Reached) -> Option<u32> {
    let mut common = None;
    for pair in phi[3..].chunks(2) {
        if seen.contains(&pair[1]) && !reached.branches.contains(&(pair[1], label)) {
            continue;
        }
        let value = *reached.known.get(&pair[0]).filter(|_| seen.contains(&pair[1]))?;
        if *common.get_or_insert(value) != value {
            return None;
        }
    }
    common
}

/// The value of an instruction on known operands. One operand is enough where the other says nothing.
fn evaluated(it: &[u32], known: &HashMap<u32, u32>) -> Option<u32> {
    let operand = |i: usize| known.get(it.get(i)?).copied();
    let both = |f: fn(u32, u32) -> u32| Some(f(operand(3)?, operand(4)?));
    let either = |decides: u32| (operand(3) == Some(decides) || operand(4) == Some(decides)).then_some(decides);
    match opcode(it) {
        op::I_ADD => both(u32::wrapping_add),
        op::I_SUB => both(u32::wrapping_sub),
        op::LOGICAL_EQUAL | op::I_EQUAL => both(|a, b| u32::from(a == b)),
        op::LOGICAL_NOT_EQUAL | op::I_NOT_EQUAL => both(|a, b| u32::from(a != b)),
        op::LOGICAL_OR => either(1).or_else(|| both(|a, b| a | b)),
        op::LOGICAL_AND | op::BITWISE_AND => either(0).or_else(|| both(|a, b| a & b)),
        op::LOGICAL_NOT => Some(1 - operand(3)?),
        op::SELECT => operand(if operand(3)? == 0 { 5 } else { 4 }),
        op::U_GREATER_THAN => both(|a, b| u32::from(a > b)),
        op::U_GREATER_THAN_EQUAL => both(|a, b| u32::from(a >= b)),
        op::U_LESS_THAN => both(|a, b| u32::from(a < b)),
        op::U_LESS_THAN_EQUAL => both(|a, b| u32::from(a <= b)),
        op::SHIFT_RIGHT_LOGICAL => both(|a, b| a.checked_shr(b).unwrap_or(0)),
        op::SHIFT_LEFT_LOGICAL => both(|a, b| a.checked_shl(b).unwrap_or(0)),
        op::BITWISE_OR => both(|a, b| a | b),
        op::BITWISE_XOR => both(|a, b| a ^ b),
        _ => None,
    }
}

/// Writes a block that is reached: with the one branch that it takes, if that is decided, and without what comes from
/// blocks that are not.
fn write_block(block: &Block<'_>, label: u32, reached: &Reached, words: &mut Vec<u32>) {
    let decided = block.decided(&reached.known);
    for it in block.instructions {
        match (opcode(it), decided) {
            (op::PHI, _) => {
                let pairs = it[3..].chunks(2).filter(|pair| reached.branches.contains(&(pair[1], label)));
                let pairs: Vec<u32> = pairs.flatten().copied().collect();
                words.extend([head(op::PHI, 3 + pairs.len() as u32), it[1], it[2]]);
                words.extend(pairs);
            }
            (op::SELECTION_MERGE, Some(_)) => {}
            (op::BRANCH_CONDITIONAL, Some(target)) => words.extend([head(op::BRANCH, 2), target]),
            _ => words.extend_from_slice(it),
        }
    }
}
