//! OFF meshes and their variants, gzipped or not.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::off(data));
