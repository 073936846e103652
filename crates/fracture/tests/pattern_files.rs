//! A pattern that is saved comes back equal, and a file that is none gets a sentence.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use frangible_fracture::{Bricks, Concrete, Natural, Pattern, Splinters, Voronoi};
use proptest::prelude::*;

fn saved_and_loaded(pattern: &Pattern) -> Pattern {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pattern.json");
    pattern.save(&path).unwrap();
    Pattern::load(&path).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn patterns_come_back_equal(cells in 1..30usize, seed in any::<u64>()) {
        let patterns = [
            Pattern::voronoi(&Voronoi { cells, seed, ..Voronoi::default() }).unwrap(),
            Pattern::natural(&Natural { cells, seed, ..Natural::default() }).unwrap(),
            Pattern::splinters(&Splinters { fibres: cells, seed, ..Splinters::default() }).unwrap(),
            Pattern::concrete(&Concrete { cells, seed, ..Concrete::default() }).unwrap(),
            Pattern::bricks(&Bricks { courses: cells, seed, ..Bricks::default() }).unwrap(),
        ];
        for pattern in patterns {
            prop_assert!(saved_and_loaded(&pattern) == pattern);
        }
    }
}

#[test]
fn joints_are_saved() {
    let pattern = Pattern::bricks(&Bricks::default()).unwrap();
    let joints = (0..pattern.len()).filter(|&cell| pattern.is_joint(cell)).count();
    assert!(joints > pattern.len() / 2 && joints < pattern.len());
    let loaded = saved_and_loaded(&pattern);
    assert!((0..pattern.len()).all(|cell| loaded.is_joint(cell) == pattern.is_joint(cell)));
}

/// Each change of a good file gets a sentence that says what is wrong.
#[test]
fn files_that_are_no_patterns_get_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pattern.json");
    Pattern::voronoi(&Voronoi { cells: 3, ..Voronoi::default() }).unwrap().save(&path).unwrap();
    let good: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let sentence = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut changed = good.clone();
        change(&mut changed);
        std::fs::write(&path, changed.to_string()).unwrap();
        let sentence = Pattern::load(&path).unwrap_err().to_string();
        sentence.strip_prefix(&format!("{}: ", path.display())).unwrap().to_owned()
    };
    let says = |change: &dyn Fn(&mut serde_json::Value), expected: &str| {
        let sentence = sentence(change);
        assert!(sentence.contains(expected), "{sentence}");
    };
    says(
        &|v| v["format"] = "x".into(),
        "is not a pattern: must say \"format\": \"frangible-pattern\"",
    );
    says(&|v| v["version"] = 7.into(), "is a pattern of version 7, must be 1");
    says(&|v| v["colour"] = 7.into(), "is not a pattern: unknown field `colour`");
    says(&|v| v["half_extent"][0] = 0.into(), "must be positive and finite");
    says(&|v| v["center"][0] = 3.into(), "must lie inside of the box");
    says(&|v| v["joints"] = vec![9].into(), "joints: 9, must be numbers of cells, below 3");
    says(&|v| v["cells"]["planar"] = Vec::<u8>::new().into(), "has no cells");
    says(
        &|v| v["cells"]["planar"][0]["cuts"][0]["normal"][0] = 9.into(),
        "cell 0: a normal of length",
    );
    says(
        &|v| v["cells"]["planar"][0]["cuts"][0]["offset"] = 9.into(),
        "a face that does not lie on its plane",
    );
    says(
        &|v| {
            let cells = v["cells"]["planar"].as_array_mut().unwrap();
            cells.pop();
        },
        "the cells' volumes miss the box's by",
    );
    std::fs::write(&path, "{").unwrap();
    assert!(Pattern::load(&path).unwrap_err().to_string().contains("is not a pattern: EOF"));
    let missing = Pattern::load(&folder.path().join("none.json")).unwrap_err().to_string();
    assert!(missing.ends_with("none.json: no such file"));
}
