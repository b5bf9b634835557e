//! STL meshes, text and binary, gzipped or not.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::mesh("x.stl", "STL", data));
