//! Measures the universal coverage table and prints `src/coverage_table.rs`:
//!
//! ```sh
//! cargo run --release -p dotwork-ink --example measure_coverage > table.rs && mv table.rs crates/dotwork-ink/src/coverage_table.rs
//! ```
#![allow(clippy::print_stdout, reason = "it prints the table")]

use dotwork_ink::calibrate::Plate;
use rayon::prelude::*;

const WIDTH: f32 = 0.3;
const COSINES: [f32; 11] = [0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.85, 1.0];

fn main() {
    // Ink areas: dense where dots begin to meet, up to where even a grazing surface is black.
    let mut inks = vec![0.0f32, 0.1, 0.2];
    inks.extend((0..20).map(|i| 0.25 * 1.175f32.powi(i)));
    println!(
        "//! The universal coverage table; see `coverage.rs`. Made by `examples/measure_coverage.rs`: do not edit.\n"
    );
    println!("/// The wider of the two arrival widths of the tables; the other is 0.");
    println!("pub(crate) const COVERAGE_WIDTH: f32 = {WIDTH};\n");
    println!("/// Ink areas per page area.\n#[rustfmt::skip]");
    println!("pub(crate) const COVERAGE_INKS: [f32; {}] = {inks:.4?};\n", inks.len());
    println!("/// Cosines between the normal and the eye.");
    println!("pub(crate) const COVERAGE_COSINES: [f32; {}] = {COSINES:?};\n", COSINES.len());
    println!(
        "/// Covered shares of the page, for regularity 0 then 1, arrival width 0 then the wider; by cosine, then ink."
    );
    println!("#[rustfmt::skip]");
    println!("pub(crate) const COVERAGE: [[[f32; {}]; {}]; 4] = [", inks.len(), COSINES.len());
    for regularity in [0.0, 1.0] {
        let plates = [11, 12].map(|seed| Plate::new(16_000, regularity, seed));
        for width in [0.0, WIDTH] {
            println!("    [");
            let rows: Vec<Vec<f32>> = COSINES
                .par_iter()
                .map(|&c| {
                    inks.iter()
                        .map(|&x| {
                            if x == 0.0 {
                                return 0.0;
                            }
                            // The limit of grazing view, short of a plate without height.
                            let c = c.max(0.015);
                            plates.iter().map(|p| p.covered(x, c, width)).sum::<f32>() / plates.len() as f32
                        })
                        .collect()
                })
                .collect();
            for row in rows {
                println!("        {row:.4?},");
            }
            println!("    ],");
        }
    }
    println!("];");
}
