//! TIFF files of one or several pages.
#![no_main]

use dotwork::io::volume::VolumeFormat;

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::volume("x.tif", VolumeFormat::Tiff, data));
