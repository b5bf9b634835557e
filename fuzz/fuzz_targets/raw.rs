//! Raw volumes: the first line is the layout, the rest the file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::raw(data));
