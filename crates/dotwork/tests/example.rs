//! The example does what it says.
#![cfg(feature = "files")]

use dotwork::Warnings;

#[allow(dead_code, reason = "its main is not called here")]
#[path = "../examples/mesh_to_dots.rs"]
mod mesh_to_dots;

#[test]
fn mesh_to_dots_writes_a_row_for_each_dot() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("dots.csv");
    let mut warnings = Warnings::new();
    let dots = mesh_to_dots::mesh_to_dots("demo:torus", table.to_str(), &mut warnings).unwrap();
    assert!(dots > 1000 && warnings.is_empty());
    assert_eq!(std::fs::read_to_string(table).unwrap().lines().count(), dots + 1);
}
