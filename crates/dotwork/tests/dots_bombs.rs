//! Small `.dots` files that ask for much: none takes much memory, refused or not.
#![cfg(feature = "files")]

use std::path::Path;
use std::process::Command;

use dotwork::io::dots::{Kind, Reader, Writer};
use dotwork::{Object, Page, Scene, Stipples, Style, Warnings, encode_dots, load, mesh};

/// Files are no longer than this.
const LONGEST: usize = 256 << 10;

/// The most that reading one may take, MiB: the process is to stay under 200.
const MOST: u64 = 180;

/// A line of what Linux tells of the memory of the process, MiB; 0 elsewhere.
fn memory(line: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix(line)).unwrap_or_default();
    line.trim().trim_end_matches("kB").trim().parse::<u64>().unwrap_or(0) / 1024
}

/// In the process that has this variable, the test only loads the file that it names.
const FILE: &str = "DOTWORK_TEST_FILE";

/// The refusal of a file, or nothing; loading it must not take more than [`MOST`].
fn cheap(path: &Path, bytes: &[u8], what: &str) -> String {
    assert!(bytes.len() <= LONGEST, "{what}: {} bytes", bytes.len());
    std::fs::write(path, bytes).unwrap();
    // A process of its own: what was freed of earlier files would be used again, unseen.
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "bombs_take_no_memory"])
        .env(FILE, path)
        .output()
        .unwrap();
    assert!(output.status.success(), "{what}: {}", String::from_utf8_lossy(&output.stderr));
    let told = std::fs::read_to_string(path.with_extension("txt")).unwrap();
    let (taken, refusal) = told.split_once(' ').unwrap();
    let taken: u64 = taken.parse().unwrap();
    assert!(taken < MOST, "{what}: {taken} MiB");
    refusal.into()
}

/// Loads a file; what that took, MiB, and why it was refused is put beside it.
fn load_and_tell(path: &Path) {
    let read = load(path, &mut Warnings::new());
    let refusal = read.err().map(|e| e.to_string()).unwrap_or_default();
    std::fs::write(path.with_extension("txt"), format!("{} {refusal}", memory("VmHWM:"))).unwrap();
}

/// A scene of one square.
fn square() -> Reader {
    let raw = mesh::shapes::demo("plate").unwrap();
    let mut scene = Scene::of(Object::new("plate", raw, Style::default(), &mut Warnings::new()).unwrap());
    (scene.page, scene.stipples) = (Page::pixels(50, 50).unwrap(), Stipples::Count(10));
    scene.bake(|_| ());
    Reader::from_bytes(Path::new("x.dots"), encode_dots(&scene)).unwrap()
}

/// The file with texts changed, without the sections for which `keep` is false.
fn changed(file: &Reader, text: impl Fn(&str, String) -> String, keep: impl Fn(&str) -> bool) -> Writer {
    let mut writer = Writer::new();
    for name in file.names().filter(|name| keep(name)) {
        match file.describe(name).unwrap().0 {
            Kind::Text => writer.text(name, &text(name, file.text(name).unwrap())),
            Kind::F32 => writer.section_f32(name, &file.f32s(name).unwrap()),
            Kind::U32 => writer.section_u32(name, &file.u32s(name).unwrap()),
            Kind::U64 => writer.section_u64(name, &file.u64s(name).unwrap()),
            Kind::Bytes => panic!("{name} is made of bytes"),
        };
    }
    writer
}

/// The sections of a bake of another kind than that of voxels.
const BAKE: [&str; 4] = ["0/radius", "0/id", "0/element", "0/weights"];

/// `count` stipples, all in one place.
fn baked(file: &Reader, count: usize) -> Vec<u8> {
    let mut writer = changed(file, |_, text| text, |name| !BAKE.contains(&name));
    writer.section_f32("0/radius", &vec![1.0; count]);
    writer.section_u64("0/id", &(0..count as u64).collect::<Vec<_>>());
    writer.section_u32("0/element", &vec![0; count]);
    writer.section_f32("0/weights", &vec![0.25; 2 * count]);
    writer.finish()
}

/// `count` voxels, all in one place, of which each asks for `n_max` stipples.
fn voxels(file: &Reader, count: usize, n_max: f32) -> Vec<u8> {
    let recipe = format!(
        "voxels = {{ edges = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], n_max = {n_max:.1}, slab = 0.5, seed = 0 }}\n"
    );
    let text = |name: &str, text: String| match name {
        "surfaces" => text + &recipe,
        _ => text,
    };
    let mut writer = changed(file, text, |name| !BAKE.contains(&name));
    let up: Vec<f32> = [0.0, 0.0, 1.0].repeat(count);
    writer.section_f32("0/voxels/positions", &up);
    writer.section_f32("0/voxels/normals", &up);
    writer.section_f32("0/voxels/magnitudes", &vec![1.0; count]);
    writer.section_f32("0/voxels/values", &vec![1.0; count]);
    writer.finish()
}

#[test]
fn bombs_take_no_memory() {
    if let Some(path) = std::env::var_os(FILE) {
        return load_and_tell(path.as_ref());
    }
    let folder = tempfile::tempdir().unwrap();
    let file = square();
    let path = folder.path().join("bomb.dots");

    for (count, n_max) in [(9000, 4096.0), (20_000, 1e12), (900_000, 25.0)] {
        let what = format!("{count} voxels of {n_max} stipples");
        let message = cheap(&path, &voxels(&file, count, n_max), &what);
        assert!(message.contains("its voxels become more stipples than"), "{what}: {message}");
    }
    // As many as are let pass: of voxels, of stipples in voxels, of baked ones.
    assert_eq!(cheap(&path, &voxels(&file, 900_000, 1.0), "many voxels"), "");
    assert_eq!(cheap(&path, &voxels(&file, 40_000, 26.0), "many stipples in voxels"), "");
    assert_eq!(cheap(&path, &baked(&file, 1_300_000), "many stipples"), "");
    let message = cheap(&path, &baked(&file, 1_500_000), "too many stipples");
    assert!(message.contains("it unpacks to"), "{message}");

    for section in ["settings", "surfaces"] {
        for (begin, item, end) in [
            ("a=[", "[],", "]"),
            ("a=[", "{a=1},", "]"),
            ("a=[", "1,", "]"),
            ("", "[[a]]\n", ""),
            ("", "[[object]]\n", ""),
            ("a={b.", "c.", "c=1}"),
        ] {
            for length in [512 << 10, 20 << 20] {
                let what = format!("{section} of {length} bytes: {item}");
                let text = |name: &str, text: String| match name == section {
                    true => format!("{text}\n{begin}{}{end}\n", item.repeat(length / item.len() - 2000)),
                    false => text,
                };
                let message = cheap(&path, &changed(&file, text, |_| true).finish(), &what);
                let long = message.contains("is longer than that of any scene");
                assert!(long == (length > 512 << 10), "{what}: {message}");
            }
        }
    }
}
