//! glTF and GLB scenes; buffers beside them are looked for in the current folder.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::mesh("x.gltf", "glTF", data));
