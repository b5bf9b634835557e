//! DICOM files and directories.
#![no_main]

use dotwork::io::volume::VolumeFormat;

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::volume("x.dcm", VolumeFormat::Dicom, data));
