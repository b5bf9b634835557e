//! `.dots` files: the box with its checksums mended, or sections put into a sound box.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::dots(data));
