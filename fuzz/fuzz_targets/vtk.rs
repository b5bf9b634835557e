//! Legacy VTK structured points.
#![no_main]

use dotwork::io::volume::VolumeFormat;

libfuzzer_sys::fuzz_target!(|data: &[u8]| dotwork_fuzz::volume("x.vtk", VolumeFormat::Vtk, data));
