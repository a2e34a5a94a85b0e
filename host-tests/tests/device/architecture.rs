//! The drawn map is the true one: what the modules import, read off their sources, against the map in the README; and no
//! two files lean on each other.

use host_tests::firmware::workspace;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The name of a module, part by part; empty for the root of its crate.
type Module = Vec<String>;

/// Arithmetic that every module may use; the map leaves it out.
const ARITHMETIC: [&str; 2] = ["scalar", "linear_algebra"];

/// The modules of a crate with their sources, tests left out.
fn modules(root: &Path) -> BTreeMap<Module, String> {
    let mut found = BTreeMap::new();
    collect(root, &Vec::new(), &mut found);
    found
}

fn collect(folder: &Path, name: &Module, found: &mut BTreeMap<Module, String>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        // images and commands are crates of their own; tests may look at whatever they test
        if ["boards", "bin", "tests"].contains(&stem.as_str()) {
            continue;
        }
        let child = [name.clone(), vec![stem.clone()]].concat();
        if path.is_dir() {
            collect(&path, &child, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let module = if ["mod", "lib", "main"].contains(&stem.as_str()) { name.clone() } else { child };
            found.insert(module, code(&fs::read_to_string(&path).unwrap()));
        }
    }
}

/// A source without comments and without its unit tests.
fn code(source: &str) -> String {
    let source = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    source.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Every path in a `use` tree: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let (mut depth, mut from) = (0, 0);
    let ends = tree.char_indices().filter(|(_, c)| {
        depth += i32::from(*c == '{') - i32::from(*c == '}');
        *c == ',' && depth == 0
    });
    for end in ends.map(|(at, _)| at).collect::<Vec<_>>().into_iter().chain([tree.len()]) {
        let part = tree[from..end].trim();
        from = end + 1;
        match part.split_once('{') {
            Some((before, inner)) => {
                let inner = inner.trim_end().strip_suffix('}').unwrap_or(inner);
                expand(&format!("{prefix}{}", before.trim()), inner, paths);
            }
            None if part.is_empty() => {}
            None => paths.push(format!("{prefix}{}", part.split(" as ").next().unwrap_or(part).trim())),
        }
    }
}

/// All paths of a source that begin at its own crate or a module above.
fn paths(source: &str) -> Vec<String> {
    let mut paths = Vec::new();
    for (index, _) in source.match_indices("use ") {
        if source[..index].chars().next_back().is_none_or(|before| !before.is_alphanumeric())
            && let Some(end) = source[index..].find(';')
        {
            expand("", &source[index + 4..index + end].replace('\n', " "), &mut paths);
        }
    }
    for begin in ["crate::", "super::"] {
        for (index, _) in source.match_indices(begin) {
            let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
            let rest = &source[index..];
            paths.push(rest[..rest.find(|c| !is_path(c)).unwrap_or(rest.len())].to_owned());
        }
    }
    // what ends so is the beginning of a tree, read above
    paths.retain(|path| !path.ends_with("::"));
    paths.retain(|path| path.starts_with("crate::") || path.starts_with("super::") || path.starts_with("self::"));
    paths
}

/// The module that a path in `from` leads to.
fn target(path: &str, from: &Module, modules: &BTreeMap<Module, String>) -> Module {
    let mut at: Module = from.clone();
    for part in path.split("::").filter(|part| !part.is_empty()) {
        match part {
            "crate" => at.clear(),
            "super" => drop(at.pop()),
            "self" => {}
            part => at.push(part.to_owned()),
        }
    }
    while !at.is_empty() && !modules.contains_key(&at) {
        at.pop();
    }
    at
}

/// What each module imports from the same crate.
fn imports(root: &Path) -> BTreeMap<Module, BTreeSet<Module>> {
    let modules = modules(root);
    assert!(modules.len() > 2, "{}", root.display());
    let of = |(name, source): (&Module, &String)| {
        let targets = paths(source).iter().map(|path| target(path, name, &modules)).filter(|to| to != name).collect();
        (name.clone(), targets)
    };
    modules.iter().map(of).collect()
}

/// The map: a line a module, `module ← what it imports`.
fn drawn() -> Vec<(String, BTreeSet<String>)> {
    let text = fs::read_to_string(workspace().join("README.md")).unwrap();
    let lines = text.lines().filter_map(|line| line.split_once(" ← "));
    lines
        .map(|(module, imports)| {
            let imports = imports.split(',').map(|name| name.trim().to_owned()).filter(|name| name != "nothing");
            (module.trim().to_owned(), imports.collect())
        })
        .collect()
}

#[test]
fn the_map_is_what_the_modules_import() {
    let drawn = drawn();
    let mut real: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, targets) in imports(&workspace().join("src")) {
        let Some(area) = module.first() else { continue };
        let others = targets.iter().filter_map(|target| target.first()).filter(|other| *other != area);
        real.entry(area.clone()).or_default().extend(others.cloned());
    }
    real.retain(|area, _| !ARITHMETIC.contains(&area.as_str()));
    for targets in real.values_mut() {
        targets.retain(|target| !ARITHMETIC.contains(&target.as_str()));
    }
    assert_eq!(drawn.iter().cloned().collect::<BTreeMap<_, _>>(), real);
    // data flow one way: every module imports from the lines above it only
    for (line, (module, imports)) in drawn.iter().enumerate() {
        let is_above = |name: &String| drawn[..line].iter().any(|(above, _)| above == name);
        assert!(imports.iter().all(is_above), "{module} imports from below");
    }
}

/// The stages of the estimator, each of which names the stage that may follow it: the one circle that is meant, and drawn
/// in `src/identification/estimator/mod.rs`.
const STAGES: [&str; 6] = ["place", "refine", "excite", "inspect", "check", "isolate"];

/// `to` is a stage of the state machine that `from` belongs to.
fn is_next_stage(from: &Module, to: &Module) -> bool {
    let [.., machine, stage] = to.as_slice() else { return false };
    machine == "estimator" && STAGES.contains(&stage.as_str()) && from.contains(machine)
}

#[test]
fn no_two_files_lean_on_each_other() {
    for root in ["src", "host-tests/src", "tools/image/src", "tools/audit/src", "tools/oracle/src", "tools/speed/src"] {
        let mut imports = imports(&workspace().join(root));
        // a module and the parts that it is made of are one thing
        let is_family = |a: &Module, b: &Module| a.starts_with(b) || b.starts_with(a);
        for (module, targets) in &mut imports {
            targets.retain(|target| !is_family(module, target) && !is_next_stage(module, target));
        }
        // what imports nothing, or is imported by nothing, stands in no circle
        loop {
            let imported: BTreeSet<&Module> = imports.values().flatten().collect();
            let free = imports.iter().find(|(name, targets)| targets.is_empty() || !imported.contains(name));
            let Some(free) = free.map(|(name, _)| name.clone()) else { break };
            imports.remove(&free);
            imports.values_mut().for_each(|targets| {
                targets.remove(&free);
            });
        }
        assert!(
            imports.is_empty(),
            "{root}: circles among {:?}",
            imports.keys().map(|m| m.join("::")).collect::<Vec<_>>()
        );
    }
}

#[test]
fn imports_are_read_as_the_compiler_reads_them() {
    let read = |source: &str| {
        let mut paths = paths(&code(source));
        paths.sort();
        paths.dedup();
        paths
    };
    assert_eq!(
        read("use crate::{a::{B, c::D}, e as f};\nuse std::fmt; // use crate::no;\nfn g() { super::h::i(); }"),
        ["crate::a::B", "crate::a::c::D", "crate::e", "super::h::i"]
    );
    let module = |name: &str| -> Module { name.split("::").map(str::to_owned).collect() };
    let modules = ["a", "a::c", "x", "x::h"].map(|name| (module(name), String::new())).into();
    assert_eq!(target("crate::a::c::D", &module("x::h"), &modules), module("a::c"));
    assert_eq!(target("super::h::i", &module("x::y"), &modules), module("x::h"));
    assert_eq!(target("crate::a::B", &module("x"), &modules), module("a"));
}
