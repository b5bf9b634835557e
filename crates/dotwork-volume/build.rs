//! Tests that read real volumes are shown as ignored where `shared/data` is absent.

use std::path::Path;

fn main() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    println!("cargo::rustc-check-cfg=cfg(no_shared_data)");
    println!("cargo::rerun-if-changed={}", data.display());
    if !data.is_dir() {
        println!("cargo::rustc-cfg=no_shared_data");
    }
}
