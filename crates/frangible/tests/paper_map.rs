//! docs/paper_map.md covers the paper, and each of its entries points to a function and a test that
//! exist; docs/references.md has what is cited; docs/conventions.md names what exists;
//! docs/the_step.md names the stages that a step reports; files and modules that the documents name
//! exist.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every numbered equation, and every section from 2 to 4.4.
const PAPER: &[&str] = &[
    "eq. 1", "eq. 2", "eq. 3", "eq. 4", "eq. 5", "eq. 6", "sec. 2", "sec. 2.1", "sec. 2.2",
    "sec. 2.3", "sec. 2.4", "sec. 3", "sec. 3.1", "sec. 3.2", "sec. 4", "sec. 4.1", "sec. 4.2",
    "sec. 4.3", "sec. 4.4",
];

struct Entry {
    paper: String,
    function: String,
    test: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn entries() -> Vec<Entry> {
    let text = fs::read_to_string(root().join("docs/paper_map.md")).unwrap();
    let rows = text.lines().filter(|line| line.starts_with("| sec.") || line.starts_with("| eq."));
    rows.map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        assert_eq!(cells.len(), 4, "four columns: {row}");
        let code = |cell: &str| cell.trim_matches('`').to_string();
        Entry { paper: cells[0].to_string(), function: code(cells[2]), test: code(cells[3]) }
    })
    .collect()
}

/// The lines of a file in which a function of that name is defined.
fn definitions(reference: &str) -> Vec<(Vec<String>, usize)> {
    let (file, name) =
        reference.split_once("::").unwrap_or_else(|| panic!("{reference}: not file::function"));
    let text = fs::read_to_string(root().join(file))
        .unwrap_or_else(|_| panic!("{reference}: no such file"));
    let lines: Vec<String> = text.lines().map(str::to_string).collect();
    let heads = [format!("fn {name}("), format!("fn {name}<")];
    let at = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| heads.iter().any(|head| line.contains(head.as_str())));
    at.map(|(number, _)| number)
        .collect::<Vec<_>>()
        .into_iter()
        .map(|number| (lines.clone(), number))
        .collect()
}

#[test]
fn every_equation_and_section_is_mapped() {
    let entries = entries();
    for claim in PAPER {
        assert!(
            entries.iter().any(|entry| entry.paper == *claim),
            "{claim} is not in docs/paper_map.md"
        );
    }
}

#[test]
fn every_entry_points_to_a_function_and_to_a_test() {
    for entry in entries() {
        assert!(
            !definitions(&entry.function).is_empty(),
            "{}: no function {}",
            entry.paper,
            entry.function
        );
        let is_test = definitions(&entry.test).into_iter().any(|(lines, number)| {
            let inside_proptest =
                lines[..number].iter().any(|line| line.trim_start().starts_with("proptest!"));
            lines[..number].iter().rev().take(6).any(|line| line.trim() == "#[test]")
                && (inside_proptest || lines[number].contains("()"))
        });
        assert!(is_test, "{}: no test {}", entry.paper, entry.test);
    }
}

/// The tags that a text cites: after a bracket a capital, letters, and two digits, such as `Su09`.
fn tags(text: &str) -> impl Iterator<Item = &str> {
    text.split('[').skip(1).filter_map(|after| {
        let tag = &after[..after.find(|c: char| !c.is_ascii_alphanumeric())?];
        let letters = tag.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_tag = letters.len() > 1
            && tag.len() == letters.len() + 2
            && letters.starts_with(|c: char| c.is_ascii_uppercase())
            && letters.chars().all(|c| c.is_ascii_alphabetic());
        // An array of `Vec3` in code is none: what follows a tag ends it, or says where to look.
        (is_tag && after[tag.len()..].starts_with([']', ' ', ',', ':'])).then_some(tag)
    })
}

/// The files under a folder, with their text.
fn texts(folder: &Path, endings: &[&str]) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(texts(&path, endings));
        } else if path
            .extension()
            .is_some_and(|ending| endings.iter().any(|known| ending == *known))
        {
            let text = fs::read_to_string(&path).unwrap();
            found.push((path, text));
        }
    }
    found
}

#[test]
fn every_citation_has_its_reference_and_every_reference_is_cited() {
    // Lines such as "- [Su09] J. Su, ...: title. Venue, year."
    let references = fs::read_to_string(root().join("docs/references.md")).unwrap();
    let lines = references.lines().filter_map(|line| line.strip_prefix("- [")?.split_once("] "));
    let known: BTreeSet<&str> = lines.map(|(tag, _)| tag).collect();

    let mut sources = texts(&root().join("crates"), &["rs"]);
    sources.extend(texts(&root().join("docs"), &["md"]));
    sources.retain(|(path, _)| {
        !path.ends_with("references.md") && !path.ends_with("tests/paper_map.rs")
    });
    for (path, text) in &sources {
        for tag in tags(text) {
            assert!(
                known.contains(tag),
                "{}: [{tag}] is not in docs/references.md",
                path.display()
            );
        }
    }
    for tag in &known {
        let cited = |(_, text): &(PathBuf, String)| {
            [']', ' ', ',', ':'].iter().any(|end| text.contains(&format!("[{tag}{end}")))
        };
        assert!(sources.iter().any(cited), "[{tag}] is not cited anywhere");
    }

    // Valid and invalid tags.
    let text =
        "[Xy12] [Xyz34 sec. 5] [XY56: z] [M1] [Vec32; 4] [a12] [Long2009] [DVec3; 10] no Xy99]";
    assert_eq!(tags(text).collect::<Vec<_>>(), ["Xy12", "Xyz34", "XY56"]);
}

#[test]
fn names_that_the_conventions_give_as_examples_exist() {
    let conventions = fs::read_to_string(root().join("docs/conventions.md")).unwrap();
    let line = conventions.lines().find(|line| line.starts_with("**Frames.**")).unwrap();
    let names: Vec<&str> = line.split('`').skip(1).step_by(2).collect();
    assert!(names.len() >= 3);
    let sources = texts(&root().join("crates"), &["rs"]);
    for name in names {
        let uses = sources.iter().filter(|(_, text)| text.contains(&format!("{name}:"))).count();
        assert!(uses > 0, "{name} is a name of nothing");
    }
}

/// Names that a text has between backticks: every second part of it, from the second one on.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

#[test]
fn files_that_the_documents_name_exist() {
    let mut documents = texts(&root().join("docs"), &["md"]);
    // Measurements tell of files as they were.
    documents.retain(|(path, _)| !path.starts_with(root().join("docs/measurements")));
    for name in ["ARCHITECTURE.md", "CONTRIBUTING.md", "README.md"] {
        documents.push((root().join(name), fs::read_to_string(root().join(name)).unwrap()));
    }
    let mut count = 0;
    for (document, text) in &documents {
        let files = quoted(text).map(|name| name.split("::").next().unwrap()).filter(|name| {
            let folder = name.split('/').next().unwrap();
            ["crates", "python", "web", "docs", "bench", "tests"].contains(&folder)
                && [".rs", ".py", ".ts", ".js", ".md"].iter().any(|end| name.ends_with(end))
                && !name.contains(['*', '<', ' '])
        });
        for file in files {
            assert!(root().join(file).exists(), "{}: no file {file}", document.display());
            count += 1;
        }
    }
    assert!(count > 50, "{count} files are named");
}

/// The file of a module such as `dynamics::energy::ledger`, or of the item at its end.
fn module_exists(path: &str) -> bool {
    let parts: Vec<&str> = path.split("::").collect();
    let source = root().join("crates").join(parts[0]).join("src");
    let inner = parts[1..parts.len() - 1].join("/");
    let name = parts[parts.len() - 1];
    let file = match inner.as_str() {
        "" => source.join("lib.rs"),
        inner => source.join(format!("{inner}.rs")),
    };
    source.join(&inner).join(format!("{name}.rs")).exists()
        || fs::read_to_string(file).is_ok_and(|text| text.contains(name))
}

#[test]
fn modules_that_the_step_names_exist() {
    let text = fs::read_to_string(root().join("docs/the_step.md")).unwrap();
    let crates = ["frangible::", "dynamics::", "collision::", "bodies::"];
    let modules = quoted(&text).filter(|name| crates.iter().any(|root| name.starts_with(root)));
    let modules: BTreeSet<&str> = modules.collect();
    assert!(modules.len() > 20, "{modules:?}");
    for module in modules {
        assert!(module_exists(module), "docs/the_step.md: no module {module}");
    }
    assert!(!module_exists("dynamics::energy::bank_robbery"));
}

#[test]
fn every_stage_is_described() {
    let text = fs::read_to_string(root().join("docs/the_step.md")).unwrap();
    for method in [frangible::Method::Paper, frangible::Method::FrameRate] {
        let mut scene = frangible::SceneDesc::new("empty");
        scene.method = method;
        scene.bodies.push(frangible::BodyDesc::ground(0.0));
        let mut world = frangible::World::build(&scene).unwrap();
        for (stage, _) in frangible::step(&mut world).stages {
            assert!(text.contains(&format!("| {stage} |")), "{stage} is not in docs/the_step.md");
        }
    }
}
