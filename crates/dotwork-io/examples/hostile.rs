//! Thousands of damaged files through every reader in one process: what panics, what takes long, what takes memory.
//!
//! ```text
//! cargo run --release -p dotwork-io --example hostile -- COUNT FOLDER
//! ```
//!
//! Sources are the small files of the tests and every readable file under FOLDER. Every reader gets as many mutants,
//! and of these a large file fewer than a small one. The same arguments damage the same files in the same ways.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "its result is a table")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/mutate.rs"]
mod mutate;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dotwork_drawing::Warnings;
use dotwork_io::dots::{Reader, Writer};
use dotwork_io::volume::{RawLayout, VolumeOptions, read_volume_bytes, volume_format_of};
use dotwork_io::{mesh_facts, mesh_format_name, read_mesh_bytes};

/// A reader that takes longer for one file hangs.
const HANGS: Duration = Duration::from_secs(2);

/// The process gives up on a file after this.
const STUCK: Duration = Duration::from_secs(60);

/// A file of this size gets half as many mutants as a tiny one.
const HALF: f64 = 200_000.0;

/// Where the bytes of a source come from, and who reads them.
struct Source {
    reader: String,
    path: PathBuf,
    /// `None`: the file at `path`.
    bytes: Option<Vec<u8>>,
    size: usize,
}

/// What became of the mutants of one reader.
#[derive(Default)]
struct Tally {
    read: usize,
    refused: usize,
    panics: usize,
    hangs: usize,
    time: Duration,
    slowest: Option<(Duration, String)>,
    /// Largest resident memory of the process while this reader had the word, MiB.
    peak: u64,
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let count = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(20_000);
    let folder = arguments.next().map_or_else(common::shared_data, PathBuf::from);
    let mut sources = made();
    found(&folder, &mut sources);
    found(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")), &mut sources);
    sources.sort_by(|a, b| (&a.reader, &a.path).cmp(&(&b.reader, &b.path)));
    let weight = |source: &Source| 1.0 / (1.0 + source.size as f64 / HALF);
    // As many for every reader, however many files it has.
    let mut totals: BTreeMap<&str, f64> = BTreeMap::new();
    for source in &sources {
        *totals.entry(&source.reader).or_default() += weight(source);
    }

    let current = Arc::new(Mutex::new((String::new(), Instant::now())));
    watch(Arc::clone(&current));
    let mut tallies: BTreeMap<&str, Tally> = BTreeMap::new();
    let (mut done, mut share) = (0, 0.0);
    for source in &sources {
        share += weight(source) / totals[source.reader.as_str()] / totals.len() as f64;
        let bytes = source.bytes.clone().or_else(|| std::fs::read(&source.path).ok()).unwrap_or_default();
        let tally = tallies.entry(&source.reader).or_default();
        forget_peak();
        let until = (share * f64::from(count)).round() as u32;
        for seed in done..until {
            let what = format!("{}, seed {seed}", source.path.display());
            let mutant = mutate::mutate(&bytes, seed);
            let start = Instant::now();
            *current.lock().expect("nobody panics with it") = (what.clone(), start);
            let result = catch_unwind(AssertUnwindSafe(|| read(source, &mutant, seed)));
            let took = start.elapsed();
            match result {
                Ok(true) => tally.read += 1,
                Ok(false) => tally.refused += 1,
                Err(_) => {
                    eprintln!("PANIC: {what}");
                    tally.panics += 1;
                }
            }
            if took > HANGS {
                eprintln!("{:.1} s: {what}", took.as_secs_f64());
                tally.hangs += 1;
            }
            tally.time += took;
            if tally.slowest.as_ref().is_none_or(|(slowest, _)| took > *slowest) {
                tally.slowest = Some((took, what));
            }
        }
        tally.peak = tally.peak.max(peak());
        done = until;
    }
    report(&tallies, sources.len());
    let bad = |tally: &Tally| tally.panics + tally.hangs > 0;
    if tallies.values().any(bad) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Gives a mutant to its reader; true if it was read.
fn read(source: &Source, mutant: &[u8], seed: u32) -> bool {
    let mut warnings = Warnings::new();
    let name = &source.path;
    let volume = |options: &VolumeOptions, warnings: &mut Warnings| {
        let mut beside = |path: &Path| dotwork_io::read_file(path);
        read_volume_bytes(name, mutant, options, &mut beside, warnings).map(drop).map_err(|e| e.to_string())
    };
    let result = match source.reader.as_str() {
        "dots" => Reader::from_bytes(name, mutant.to_vec()).map_err(|e| e.to_string()).and_then(|file| {
            let names: Vec<_> = file.names().collect();
            names.iter().try_for_each(|n| file.f32s(n).map(drop).map_err(|e| e.to_string()))
        }),
        "raw" => {
            // The layout fits the sound file; every other time the layout is damaged as well.
            let text = format!("{}x6x6:u8:le:1,1,1.5:header=0", source.size / 36).into_bytes();
            let text = if seed.is_multiple_of(2) { text } else { mutate::mutate(&text, seed) };
            match String::from_utf8_lossy(&text).parse::<RawLayout>() {
                Ok(layout) => {
                    volume(&VolumeOptions { raw: Some(layout), ..VolumeOptions::default() }, &mut warnings)
                }
                Err(_) => return false,
            }
        }
        _ if volume_format_of(name, mutant).is_some() => volume(&VolumeOptions::default(), &mut warnings),
        _ => {
            assert!(!mesh_facts(name, mutant).iter().any(|(_, text)| text.contains('\n')));
            read_mesh_bytes(name, mutant, &mut warnings).map(drop).map_err(|e| e.to_string())
        }
    };
    if let Err(message) = &result {
        assert!(!message.contains('\n'), "{message:?}");
    }
    result.is_ok()
}

/// The small files of the tests, and a `.dots` file.
fn made() -> Vec<Source> {
    let mut dots = Writer::new();
    dots.section_f32("a", &[1.0; 1000]).section_f32("b", &[0.5; 3]);
    let mut files = common::all_samples();
    files.push(("scene.dots", dots.finish()));
    let of = |(name, bytes): (&str, Vec<u8>)| {
        let path = PathBuf::from(name);
        let reader = if name.ends_with("dots") { "dots".into() } else { reader_of(&path, &bytes)? };
        Some(Source { reader, path, size: bytes.len(), bytes: Some(bytes) })
    };
    files.into_iter().filter_map(of).collect()
}

/// Every file under `folder` that a reader takes.
fn found(folder: &Path, sources: &mut Vec<Source>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found(&path, sources);
            continue;
        }
        let bytes = std::fs::read(&path).unwrap_or_default();
        if let Some(reader) = reader_of(&path, &bytes).filter(|_| !bytes.is_empty()) {
            sources.push(Source { reader, path, bytes: None, size: bytes.len() });
        }
    }
}

/// The reader of a file, by its sound content: "PLY", "Nrrd", …
fn reader_of(path: &Path, bytes: &[u8]) -> Option<String> {
    if path.extension().is_some_and(|e| e == "raw") {
        return Some("raw".into());
    }
    let format = match volume_format_of(path, bytes) {
        Some(format) => format!("{format:?}"),
        None => mesh_format_name(path, bytes)?,
    };
    let end = format.find([' ', ',']).unwrap_or(format.len());
    Some(if format[..end].ends_with("OFF") { "OFF".into() } else { format[..end].into() })
}

/// Ends the process when one file takes a minute: nothing else could name a reader that never comes back.
fn watch(current: Arc<Mutex<(String, Instant)>>) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let (what, start) = current.lock().map(|c| c.clone()).unwrap_or((String::new(), Instant::now()));
            if !what.is_empty() && start.elapsed() > STUCK {
                eprintln!("STUCK: {what}");
                std::process::exit(2);
            }
        }
    });
}

/// Peak resident memory since [`forget_peak`], MiB; 0 where the system does not say (other than Linux).
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.trim().trim_end_matches("kB").trim().parse::<u64>().unwrap_or(0) / 1024
}

fn forget_peak() {
    // Where that is not possible, the peak is that of all readers so far.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn report(tallies: &BTreeMap<&str, Tally>, sources: usize) {
    println!("reader      mutants    read refused panics hangs      s  peak MiB  slowest");
    let mut all = Tally::default();
    for (reader, t) in tallies {
        let (slowest, what) = t.slowest.clone().unwrap_or_default();
        let row = row(t);
        println!("{reader:10} {row}  {:.0} ms: {what}", slowest.as_secs_f64() * 1e3);
        all.read += t.read;
        all.refused += t.refused;
        all.panics += t.panics;
        all.hangs += t.hangs;
        all.time += t.time;
        all.peak = all.peak.max(t.peak);
    }
    println!("{:10} {}  from {sources} sources", "all", row(&all));
}

fn row(t: &Tally) -> String {
    let mutants = t.read + t.refused + t.panics;
    let (read, refused, panics, hangs, time, peak) =
        (t.read, t.refused, t.panics, t.hangs, t.time.as_secs_f64(), t.peak);
    format!("{mutants:8} {read:7} {refused:7} {panics:6} {hangs:5} {time:6.1} {peak:9}")
}
