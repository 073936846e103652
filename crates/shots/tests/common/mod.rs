//! Helpers of several tests.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on fails")]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// The bunny of the npm package, as an OBJ file in `folder`.
pub(crate) fn bunny(folder: &Path, without_triangle: impl Fn(usize) -> bool) -> PathBuf {
    let source =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/tools/node_modules/bunny/index.js");
    let script = fs::read_to_string(source).expect("the bunny is not installed, run `make test`");
    let array = |name: &str| -> Vec<[f64; 3]> {
        let start =
            script.find(&format!("exports.{name}=")).unwrap() + format!("exports.{name}=").len();
        let text = &script[start..];
        let end = text.find("]]").unwrap() + 2;
        serde_json::from_str(&text[..end]).unwrap()
    };
    let mut obj = String::new();
    for [x, y, z] in array("positions") {
        writeln!(obj, "v {x} {y} {z}").unwrap();
    }
    for (number, [a, b, c]) in array("cells").into_iter().enumerate() {
        if !without_triangle(number) {
            writeln!(obj, "f {} {} {}", a + 1.0, b + 1.0, c + 1.0).unwrap();
        }
    }
    let path = folder.join("bunny.obj");
    fs::write(&path, obj).unwrap();
    path
}
