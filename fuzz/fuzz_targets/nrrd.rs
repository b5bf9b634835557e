//! NRRD volumes, attached and detached.
#![no_main]

use dotwork::io::volume::VolumeFormat;

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::volume("x.nrrd", VolumeFormat::Nrrd, data));
