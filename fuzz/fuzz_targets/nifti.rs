//! NIfTI-1 and NIfTI-2 volumes, in one file and in two.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::nifti(data));
