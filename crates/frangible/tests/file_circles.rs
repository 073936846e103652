//! No two files of a crate import each other in a circle, and none imports through `lib.rs`, which
//! hands names to the outside only.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A file by its place in the crate, such as `["hull", "clip"]`; `lib.rs` by none.
type Module = Vec<String>;

/// The files under a folder, with their text; files of tests import what they test.
fn modules(folder: &Path, at: &[String], found: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut module = at.to_vec();
        if stem != "lib" {
            module.push(stem.clone());
        }
        if path.is_dir() {
            modules(&path, &module, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") && stem != "tests" {
            found.insert(module, without_tests(&fs::read_to_string(&path).unwrap()));
        }
    }
}

/// The text without comments and the tests at its end. A macro's `$crate` is for other crates.
fn without_tests(text: &str) -> String {
    let text = text.replace("$crate", "$");
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let lines = code.lines().map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

/// The paths that a tree such as `a::{b, c::{d, e}}` names.
fn paths(tree: &str) -> Vec<String> {
    let Some((prefix, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap().trim().to_string()];
    };
    let inner = &rest[..rest.rfind('}').unwrap()];
    let (mut depth, mut begin, mut branches) = (0, 0, Vec::new());
    for (at, letter) in inner.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                branches.push(&inner[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    branches.push(&inner[begin..]);
    let named = branches.into_iter().filter(|branch| !branch.trim().is_empty());
    named.flat_map(paths).map(|path| format!("{}{path}", prefix.trim())).collect()
}

/// All paths of a text: those that it imports, and those that it writes out.
fn mentioned(text: &str) -> Vec<String> {
    let (mut all, mut rest) = (Vec::new(), String::new());
    let mut tree: Option<String> = None;
    for line in text.lines() {
        let words = line.trim_start();
        let begins = ["use ", "pub use ", "pub(crate) use ", "pub(super) use "];
        let begun = begins.iter().find_map(|begin| words.strip_prefix(begin));
        match (&mut tree, begun) {
            (Some(open), _) => open.push_str(words),
            (None, Some(begun)) => tree = Some(begun.to_string()),
            (None, None) => rest.extend([line, "\n"]),
        }
        if tree.as_ref().is_some_and(|tree| tree.ends_with(';')) {
            all.extend(tree.take().iter().flat_map(|tree| paths(tree.trim_end_matches(';'))));
        }
    }
    let is_of_path = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = rest.split(|letter| !is_of_path(letter)).filter(|word| word.contains("::"));
    all.extend(words.map(str::to_string));
    all
}

/// Where a path of a module leads: the file, and whether it is a name of `lib.rs`.
fn target(path: &str, from: &Module, known: &BTreeMap<Module, String>) -> Option<Module> {
    let mut parts: Vec<&str> = path.split("::").map(str::trim).filter(|p| !p.is_empty()).collect();
    let mut base = from.clone();
    let is_child = |part: &str| {
        let child: Module = from.iter().cloned().chain([part.to_string()]).collect();
        known.contains_key(&child)
    };
    match *parts.first()? {
        "crate" => base.clear(),
        "self" => {}
        "super" => {
            while parts.first() == Some(&"super") {
                base.pop()?;
                parts.remove(0);
            }
            parts.insert(0, "");
        }
        child if parts.len() > 1 && is_child(child) => parts.insert(0, ""),
        _ => return None,
    }
    base.extend(parts[1..].iter().map(|part| (*part).to_string()));
    while !known.contains_key(&base) {
        base.pop()?;
    }
    Some(base)
}

/// Files that import each other in a circle, if there are any: of those that lead on for ever.
fn circle(imports: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<String> {
    let mut left = imports.clone();
    loop {
        let before = left.len();
        let alive: BTreeSet<Module> = left.keys().cloned().collect();
        left.retain(|_, to| to.iter().any(|module| alive.contains(module)));
        if left.len() == before {
            break;
        }
    }
    // All of them lead to a circle; those on one can come back to themselves.
    let reaches_itself = |start: &&Module| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![*start]);
        while let Some(module) = open.pop() {
            for next in left.get(module).into_iter().flatten() {
                if next == *start {
                    return true;
                }
                if left.contains_key(next) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        false
    };
    left.keys().filter(reaches_itself).map(|module| module.join("/")).collect()
}

/// Circles of the files of a crate, and imports through its `lib.rs`.
fn faults(known: &BTreeMap<Module, String>) -> Vec<String> {
    let mut through_root = Vec::new();
    let mut imports: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (module, text) in known.iter().filter(|(module, _)| !module.is_empty()) {
        let of = imports.entry(module.clone()).or_default();
        for path in mentioned(text) {
            match target(&path, module, known) {
                Some(to) if to.is_empty() => {
                    through_root.push(format!("{} imports {path}", module.join("/")));
                }
                Some(to) if to != *module => {
                    of.insert(to);
                }
                _ => {}
            }
        }
    }
    let on_circles = circle(&imports);
    if !on_circles.is_empty() {
        through_root.push(format!("circles of {}", on_circles.join(", ")));
    }
    through_root
}

#[test]
fn no_two_files_import_each_other() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    for entry in fs::read_dir(crates).unwrap() {
        let folder = entry.unwrap().path();
        if folder.join("src").is_dir() {
            let mut known = BTreeMap::new();
            modules(&folder.join("src"), &[], &mut known);
            let name = folder.file_name().unwrap().to_string_lossy().into_owned();
            found.extend(faults(&known).into_iter().map(|fault| format!("{name}: {fault}")));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_circle_is_found_through_imports_paths_and_the_root() {
    let with = |texts: &[(&str, &str)]| {
        let module = |path: &str| path.split('/').map(str::to_string).collect::<Module>();
        let mut known: BTreeMap<Module, String> =
            texts.iter().map(|(path, text)| (module(path), without_tests(text))).collect();
        known.insert(Vec::new(), String::new());
        faults(&known)
    };
    let straight = [("a", "use crate::b::{C, d::E};"), ("b", ""), ("b/d", "// use crate::a::F;")];
    assert!(with(&straight).is_empty());
    assert_eq!(with(&[("a", "use crate::b::C;"), ("b", "fn f(x: crate::a::D) {}")]).len(), 1);
    assert_eq!(with(&[("a", "use b::C;"), ("a/b", "use super::{D, E};")]), ["circles of a, a/b"]);
    assert_eq!(with(&[("a", "use crate::{B, c};"), ("c", "")]), ["a imports crate::B"]);
    assert!(
        with(&[("a", "use b::C;"), ("a/b", "#[cfg(test)]\nmod tests { use super::*; }")])
            .is_empty()
    );
}
