//! MetaImage volumes, in one file and in two.
#![no_main]

use dotwork::io::volume::VolumeFormat;

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::volume("x.mha", VolumeFormat::MetaImage, data));
