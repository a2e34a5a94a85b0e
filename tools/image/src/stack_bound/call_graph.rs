//! Every function of an image: what it takes off the stack, and whom it may call.

use super::StackError;
use super::constants::Constants;
use super::instructions::{Instruction, decode, len};
use super::veneer;
use crate::elf::{Code, Elf};
use std::collections::{BTreeMap, BTreeSet};

/// Where every program of ours ends: last words, then a reset (`boards/cortex_m/faults.rs`).
const ENDING: &str = "cortex::faults::stop";

/// A function of the image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Function {
    /// Its name, demangled.
    pub name: String,
    /// All that it takes off the stack pointer on any way through it.
    pub frame_bytes: u64,
    /// First addresses of the functions that it names itself.
    pub calls: BTreeSet<u64>,
    /// It also calls through pointers.
    pub calls_anywhere: bool,
    /// It masks the interrupts before it goes anywhere else.
    pub masks_first: bool,
}

/// The functions of an image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CallGraph {
    /// By the address of the first instruction.
    pub functions: BTreeMap<u64, Function>,
    /// Functions that a pointer may lead to: their addresses stand in the image.
    pub pointed_to: BTreeSet<u64>,
    /// The handlers of the vector table, by their first addresses: the first is what runs after reset.
    pub handlers: Vec<u64>,
}

impl CallGraph {
    /// Reads the image.
    ///
    /// # Errors
    /// [`StackError`].
    pub fn read(image: &Elf) -> Result<Self, StackError> {
        let code = image.code()?;
        let mut ranges: BTreeMap<u64, (u64, String)> = BTreeMap::new();
        for function in &code.functions {
            let (end, names) = ranges.entry(function.address).or_default();
            *end = (*end).max(function.address + function.size_bytes);
            // the linker folds functions that are alike into one
            if names.is_empty() {
                names.clone_from(&function.name);
            } else if !names.ends_with("…") {
                let more = names.matches(" = ").count() < 2;
                names.push_str(&if more { format!(" = {}", function.name) } else { " = …".to_owned() });
            }
        }
        let begins = |address: u64| ranges.contains_key(&address);
        let pointer = |word: u32| Some(u64::from(word)).filter(|word| word & 1 == 1).map(|word| word & !1);
        let mut pointed_to: BTreeSet<u64> = code.words().filter_map(pointer).filter(|to| begins(*to)).collect();
        let mut functions = BTreeMap::new();
        for (&address, (end, name)) in &ranges {
            let (function, constants) = walk(&code, address..*end, name, &ranges)?;
            pointed_to.extend(constants.into_iter().filter_map(pointer).filter(|to| begins(*to)));
            functions.insert(address, function);
        }
        let handlers: BTreeSet<u32> = code.vectors.iter().skip(2).copied().filter(|vector| *vector != 0).collect();
        let reset = code.vectors.get(1).copied().unwrap_or_default();
        let all = std::iter::once(reset).chain(handlers.into_iter().filter(|vector| *vector != reset));
        let handlers = all.map(|vector| u64::from(vector & !1));
        let handlers = handlers.map(|at| if begins(at) { Ok(at) } else { Err(StackError::NoHandler(at)) });
        Ok(Self { functions, pointed_to, handlers: handlers.collect::<Result<_, _>>()? })
    }

    /// The function with which a program of ours ends, by its first address: by its name, and it masks the interrupts
    /// before anything else.
    pub fn ending(&self) -> Option<u64> {
        let ends = |function: &Function| function.masks_first && function.name.contains(ENDING);
        self.functions.iter().find(|(_, function)| ends(function)).map(|(address, _)| *address)
    }

    /// The same graph, in which a function calls nothing.
    #[must_use]
    pub fn without_callees_of(&self, address: u64) -> Self {
        let mut graph = self.clone();
        if let Some(function) = graph.functions.get_mut(&address) {
            function.calls.clear();
            function.calls_anywhere = false;
        }
        graph
    }

    /// Everything that a function may call.
    pub fn callees<'a>(&'a self, function: &'a Function) -> impl Iterator<Item = u64> + 'a {
        let anywhere = function.calls_anywhere.then_some(&self.pointed_to);
        function.calls.iter().chain(anywhere.into_iter().flatten()).copied()
    }
}

/// Goes through a function's instructions, and gives it and the constants that it puts together.
fn walk(
    code: &Code,
    range: std::ops::Range<u64>,
    name: &str,
    ranges: &BTreeMap<u64, (u64, String)>,
) -> Result<(Function, Vec<u32>), StackError> {
    let mut function = Function {
        name: name.to_owned(),
        frame_bytes: 0,
        calls: BTreeSet::new(),
        calls_anywhere: false,
        masks_first: false,
    };
    let mut constants = Constants::default();
    let mut at = range.start;
    while at < range.end {
        if code.is_data(at) {
            at += 2;
            continue;
        }
        if let Some(to) = veneer::leads_to(|at| code.half_word(at), at) {
            let (_, callee) = ranges.get(&to).ok_or_else(|| StackError::Nowhere(name.to_owned(), to))?;
            if at == range.start {
                function.name = format!("veneer of {callee}");
            }
            function.calls.insert(to);
            at += veneer::LEN;
            continue;
        }
        let first = code.half_word(at);
        match decode(at, first, code.half_word(at + 2)) {
            Instruction::Takes(bytes) => function.frame_bytes += bytes,
            Instruction::ComputesStackPointer => return Err(StackError::Computed(name.to_owned(), at)),
            Instruction::GoesTo(to) if range.contains(&to) && to != range.start => {}
            Instruction::GoesTo(to) => match ranges.range(..=to).next_back() {
                Some((&begin, (end, _))) if to < *end || to == begin => drop(function.calls.insert(begin)),
                _ => return Err(StackError::Nowhere(name.to_owned(), to)),
            },
            Instruction::GoesAnywhere => function.calls_anywhere = true,
            Instruction::LowerHalf { register, value } => constants.lower_half(register, value),
            Instruction::UpperHalf { register, value } => constants.upper_half(register, value),
            Instruction::MasksInterrupts => {
                function.masks_first |= function.calls.is_empty() && !function.calls_anywhere;
            }
            Instruction::Other => {}
        }
        at += len(first);
    }
    Ok((function, constants.all().collect()))
}
