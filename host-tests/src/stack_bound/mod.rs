//! How deep the stack of an image can get: a bound from its machine code, for main and for every interrupt.
//!
//! Every function is walked through ([`frame`]), then the calls are followed from each root ([`Bounds::of`]). Calls by a
//! pointer are taken to reach whichever function has its address in the image's constants, but for formatting.
//!
//! Not followed is what ends the firmware ([`is_end`]): a panic and the last words before the reset. Should they not
//! find room, the guard below the stack ends them, and the watchdog restarts the board all the same.

pub mod frame;
pub mod image;
pub mod thumb;

use std::collections::{BTreeMap, BTreeSet};

use frame::Frame;

/// A function with what it does to the stack.
#[derive(Debug, Clone)]
pub struct Function {
    /// Its name, demangled.
    pub name: String,
    /// Its frame.
    pub frame: Frame,
}

/// Why there is no bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Unbounded {
    /// The functions call each other in a circle.
    Recursion(Vec<String>),
    /// The function moves the stack pointer in a way that is not followed.
    UnknownStack(String),
    /// The function calls by a pointer, and no function's address stands anywhere.
    NoCandidate(String),
    /// A call leads to where no function is known.
    Stray(String, u64),
}

impl std::fmt::Display for Unbounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Recursion(names) => write!(f, "recursion: {}", names.join(" -> ")),
            Self::UnknownStack(name) => write!(f, "{name} sets the stack pointer from a register"),
            Self::NoCandidate(name) => write!(f, "{name} calls by a pointer, to nowhere known"),
            Self::Stray(name, address) => write!(f, "{name} calls {address:#x}, where no function is known"),
        }
    }
}

impl std::error::Error for Unbounded {}

/// The deepest way from a root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bound {
    /// Bytes.
    pub bytes: i64,
    /// The functions on that way, the root first.
    pub way: Vec<u64>,
}

/// The functions of an image by their addresses.
#[derive(Debug, Default)]
pub struct Bounds {
    functions: BTreeMap<u64, Function>,
    /// Functions whose address stands in the constants.
    pointed_at: BTreeSet<u64>,
    known: BTreeMap<u64, Bound>,
}

impl Bounds {
    /// An image's functions, and those that pointers may lead to.
    pub fn new(functions: BTreeMap<u64, Function>, pointed_at: BTreeSet<u64>) -> Self {
        Self { functions, pointed_at, known: BTreeMap::new() }
    }

    /// The bound of a function and all that it calls.
    ///
    /// # Errors
    /// [`Unbounded`].
    pub fn of(&mut self, root: u64) -> Result<Bound, Unbounded> {
        self.follow(root, &mut Vec::new())
    }

    /// The name of the function at an address.
    pub fn name(&self, address: u64) -> &str {
        self.functions.get(&address).map_or("?", |function| &function.name)
    }

    fn follow(&mut self, address: u64, way: &mut Vec<u64>) -> Result<Bound, Unbounded> {
        if let Some(bound) = self.known.get(&address) {
            return Ok(bound.clone());
        }
        if let Some(begin) = way.iter().position(|passed| *passed == address) {
            let circle = way.iter().skip(begin).chain([&address]).map(|passed| self.name(*passed).to_owned());
            return Err(Unbounded::Recursion(circle.collect()));
        }
        let Some(Function { name, frame }) = self.functions.get(&address).cloned() else {
            let caller = way.last().map_or("?", |caller| self.name(*caller)).to_owned();
            return Err(Unbounded::Stray(caller, address));
        };
        let mut bound = Bound { bytes: frame.own_bytes, way: vec![address] };
        if is_end(&name) {
            return Ok(Bound { bytes: 0, ..bound });
        }
        if frame.unknown {
            return Err(Unbounded::UnknownStack(name));
        }
        way.push(address);
        for (target, depth) in self.targets(&name, &frame)? {
            let below = self.follow(target, way)?;
            if depth + below.bytes > bound.bytes {
                bound = Bound { bytes: depth + below.bytes, way: [vec![address], below.way].concat() };
            }
        }
        way.pop();
        self.known.insert(address, bound.clone());
        Ok(bound)
    }

    /// All that a function may call, with the depth at the call.
    fn targets(&self, name: &str, frame: &Frame) -> Result<Vec<(u64, i64)>, Unbounded> {
        let mut targets = frame.calls.clone();
        if let Some(depth) = frame.indirect.iter().max() {
            if self.pointed_at.is_empty() {
                return Err(Unbounded::NoCandidate(name.to_owned()));
            }
            targets.extend(self.pointed_at.iter().map(|target| (*target, *depth)));
        }
        Ok(targets)
    }
}

/// What ends the firmware, or only serves that end: never followed.
pub fn is_end(name: &str) -> bool {
    const ENDS: [&str; 5] =
        ["core::panicking", "faults::stop", "core::result::unwrap_failed", "defmt_panic", "give_up"];
    ENDS.iter().any(|end| name.contains(end))
}

/// Formatting is called by pointers from formatting alone, which only the end of the firmware uses.
pub fn is_formatting(name: &str) -> bool {
    name.contains("core::fmt") || name.contains("::fmt::")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(name: &str, own_bytes: i64, calls: &[(u64, i64)], indirect: &[i64]) -> Function {
        let frame = Frame { own_bytes, calls: calls.to_vec(), indirect: indirect.to_vec(), unknown: false };
        Function { name: name.to_owned(), frame }
    }

    fn bounds(functions: &[(u64, Function)], pointed_at: &[u64]) -> Bounds {
        Bounds::new(functions.iter().cloned().collect(), pointed_at.iter().copied().collect())
    }

    #[test]
    fn the_deepest_way_is_found() {
        let functions = [
            (1, function("main", 40, &[(2, 40), (3, 8)], &[])),
            (2, function("shallow", 16, &[], &[])),
            (3, function("deep", 100, &[(2, 100)], &[])),
        ];
        let bound = bounds(&functions, &[]).of(1);
        assert_eq!(bound, Ok(Bound { bytes: 124, way: vec![1, 3, 2] }));
    }

    #[test]
    fn a_pointer_leads_to_the_worst_that_it_can() {
        let functions = [
            (1, function("main", 8, &[], &[8])),
            (2, function("one", 30, &[], &[])),
            (3, function("other", 20, &[(2, 20)], &[])),
        ];
        assert_eq!(bounds(&functions, &[2, 3]).of(1).map(|bound| bound.bytes), Ok(58));
        assert_eq!(bounds(&functions, &[]).of(1), Err(Unbounded::NoCandidate("main".to_owned())));
    }

    #[test]
    fn what_cannot_be_bounded_is_named() {
        let circle = [(1, function("a", 8, &[(2, 8)], &[])), (2, function("b", 8, &[(1, 8)], &[]))];
        let names = ["a", "b", "a"].map(str::to_owned).to_vec();
        assert_eq!(bounds(&circle, &[]).of(1), Err(Unbounded::Recursion(names)));
        assert_eq!(bounds(&circle[..1], &[]).of(1), Err(Unbounded::Stray("a".to_owned(), 2)));
        let mut unknown = function("c", 8, &[], &[]);
        unknown.frame.unknown = true;
        assert_eq!(bounds(&[(1, unknown)], &[]).of(1), Err(Unbounded::UnknownStack("c".to_owned())));
    }

    #[test]
    fn the_end_of_the_firmware_is_not_followed() {
        let functions = [
            (1, function("main", 8, &[(2, 8)], &[])),
            (2, function("core::panicking::panic_fmt", 4_000, &[(1, 0)], &[])),
        ];
        assert_eq!(bounds(&functions, &[]).of(1).map(|bound| bound.bytes), Ok(8));
    }
}
