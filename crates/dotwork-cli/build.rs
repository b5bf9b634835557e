//! Says whether the shared test data lies beside the repository, and which programs that draw vectors are installed, so
//! that tests that need them show as ignored where they are missing.

use std::path::Path;

fn main() {
    println!("cargo::rustc-check-cfg=cfg(no_shared_data)");
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    println!("cargo::rerun-if-changed={folder}/README.md");
    println!("cargo::rerun-if-changed=build.rs");
    if !Path::new(folder).is_dir() {
        println!("cargo::rustc-cfg=no_shared_data");
    }
    println!("cargo::rerun-if-env-changed=PATH");
    let paths = std::env::var_os("PATH").unwrap_or_default();
    for (program, cfg) in [("rsvg-convert", "no_rsvg"), ("pdftoppm", "no_poppler")] {
        println!("cargo::rustc-check-cfg=cfg({cfg})");
        if !std::env::split_paths(&paths).any(|folder| folder.join(program).is_file()) {
            println!("cargo::rustc-cfg={cfg}");
        }
    }
}
