//! OBJ meshes, gzipped or not.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::mesh("x.obj", "OBJ", data));
