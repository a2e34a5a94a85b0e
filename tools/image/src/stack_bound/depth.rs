//! The deepest way from each root through the call graph.

use super::call_graph::CallGraph;
use super::{EXCEPTION_FRAME_BYTES, StackError};
use std::collections::BTreeMap;

/// How often a circle of functions that call each other is gone round at most. A line of the log is a text
/// (1) with an entry in it (2) with a field in it (3) that writes a string of its own (4).
pub const MOST_ROUNDS: u64 = 4;

/// Where a stack begins to grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// The main program, from reset.
    Main,
    /// An exception or interrupt on top of whatever runs.
    Exception,
}

/// The most that a root can take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bound {
    /// What it is.
    pub root: Root,
    /// The name of its function.
    pub name: String,
    /// The most bytes, with what the exception itself puts on the stack.
    pub bytes: u64,
    /// The deepest way, function by function, with what each takes. A circle is one entry.
    pub way: Vec<(String, u64)>,
}

/// The most that a function takes with all that it calls, bytes, and the deepest way.
pub(super) fn depth(graph: &CallGraph, address: u64) -> Deepest {
    let circles = Circles::of(graph);
    circles.deepest(graph, circles.of_function[&address], &mut BTreeMap::new())
}

/// The bound of every root.
pub(super) fn bounds(graph: &CallGraph) -> Result<Vec<Bound>, StackError> {
    let circles = Circles::of(graph);
    let mut deepest = BTreeMap::new();
    let roots = graph.handlers.iter().enumerate().map(|(number, &address)| {
        let root = if number == 0 { Root::Main } else { Root::Exception };
        let (bytes, way) = circles.deepest(graph, circles.of_function[&address], &mut deepest);
        let entry = if root == Root::Exception { EXCEPTION_FRAME_BYTES } else { 0 };
        Bound { root, name: graph.functions[&address].name.clone(), bytes: bytes + entry, way }
    });
    Ok(roots.collect())
}

/// Functions that call each other in a circle, taken together; a function in no circle is one by itself.
struct Circles {
    of_function: BTreeMap<u64, usize>,
    members: Vec<Vec<u64>>,
}

/// Bytes, and the way to get there.
pub(super) type Deepest = (u64, Vec<(String, u64)>);

impl Circles {
    /// Strongly connected components (Tarjan, 1972).
    fn of(graph: &CallGraph) -> Self {
        let mut search =
            Search { graph, order: BTreeMap::new(), low: BTreeMap::new(), open: Vec::new(), members: Vec::new() };
        for address in graph.functions.keys() {
            if !search.order.contains_key(address) {
                search.visit(*address);
            }
        }
        let of_function = search.members.iter().enumerate().flat_map(|(k, all)| all.iter().map(move |at| (*at, k)));
        Self { of_function: of_function.collect(), members: search.members }
    }

    fn deepest(&self, graph: &CallGraph, circle: usize, known: &mut BTreeMap<usize, Deepest>) -> Deepest {
        if let Some(known) = known.get(&circle) {
            return known.clone();
        }
        let members = &self.members[circle];
        let callees = members.iter().flat_map(|at| graph.callees(&graph.functions[at]).map(move |to| (*at, to)));
        let callees: Vec<(u64, u64)> = callees.collect();
        let is_circle = callees.iter().any(|(_, to)| self.of_function[to] == circle);
        let frames: u64 = members.iter().map(|at| graph.functions[at].frame_bytes).sum();
        let (name, own) = match (members.as_slice(), is_circle) {
            ([only], false) => (graph.functions[only].name.clone(), frames),
            (all, _) => {
                let largest = all.iter().map(|at| &graph.functions[at]).max_by_key(|function| function.frame_bytes);
                let largest = largest.map_or("", |function| &function.name);
                (
                    format!("{} functions in a circle, {MOST_ROUNDS} times, such as {largest}", all.len()),
                    MOST_ROUNDS * frames,
                )
            }
        };
        let below = callees.iter().map(|(_, to)| self.of_function[to]).filter(|to| *to != circle);
        let deepest = below.map(|to| self.deepest(graph, to, known)).max_by_key(|(bytes, _)| *bytes);
        let (below, mut way) = deepest.unwrap_or_default();
        way.insert(0, (name, own));
        known.insert(circle, (own + below, way.clone()));
        (own + below, way)
    }
}

struct Search<'a> {
    graph: &'a CallGraph,
    order: BTreeMap<u64, usize>,
    low: BTreeMap<u64, usize>,
    open: Vec<u64>,
    members: Vec<Vec<u64>>,
}

impl Search<'_> {
    fn visit(&mut self, at: u64) {
        let number = self.order.len();
        self.order.insert(at, number);
        self.low.insert(at, number);
        self.open.push(at);
        let graph = self.graph;
        for to in graph.callees(&graph.functions[&at]) {
            if !self.order.contains_key(&to) {
                self.visit(to);
                self.low.insert(at, self.low[&at].min(self.low[&to]));
            } else if self.open.contains(&to) {
                self.low.insert(at, self.low[&at].min(self.order[&to]));
            }
        }
        if self.low[&at] == number {
            let first = self.open.iter().position(|open| *open == at).unwrap_or_default();
            self.members.push(self.open.split_off(first));
        }
    }
}

#[cfg(test)]
mod tests;
