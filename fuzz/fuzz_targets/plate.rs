//! The settings in PNG, SVG, PDF and TIFF files.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::plate(data));
