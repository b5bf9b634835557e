//! Tells the tests whether the shared data are there, so that those that need them show as ignored elsewhere.

use std::path::Path;

fn main() {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    println!("cargo::rustc-check-cfg=cfg(no_shared_data)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={data}");
    if !Path::new(data).is_dir() {
        println!("cargo::rustc-cfg=no_shared_data");
    }
}
