//! PLY meshes, text and binary, gzipped or not.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::mesh("x.ply", "PLY", data));
