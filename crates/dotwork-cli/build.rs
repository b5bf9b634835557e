//! Says whether the shared test data lies beside the repository, so that tests that need it show as ignored
//! where it does not.

use std::path::Path;

fn main() {
    println!("cargo::rustc-check-cfg=cfg(no_shared_data)");
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    println!("cargo::rerun-if-changed={folder}/README.md");
    println!("cargo::rerun-if-changed=build.rs");
    if !Path::new(folder).is_dir() {
        println!("cargo::rustc-cfg=no_shared_data");
    }
}
