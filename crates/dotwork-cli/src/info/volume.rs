//! What is in a volume: its grid, its place in the world, its values and their histogram.

use dotwork::drawing::lettering::{text_width, write_text};
use dotwork::drawing::{Drawing, Layer, Page};
use dotwork::ink::tone::FactorHistogram;
use dotwork::ink::{BakeMethod, FeatureChoice};
use dotwork::volume::{Feature, Features, Histogram, SampleType, Space, Unit, VolumeStats};
use dotwork::{Color, FileError, Loaded, Scene, Style, VolumeInput, Warnings};
use serde_json::{Value, json};

use crate::words::{grouped, list, number};

/// Rows of the histogram in words.
const ROWS: usize = 24;

/// Bins of the histogram in JSON.
const BINS: usize = 256;

/// Columns of the longest bar.
const BAR: f64 = 36.0;

/// Most features on a contact sheet.
const MOST_FEATURES: usize = 12;

/// Pictures side by side on a contact sheet.
const COLUMNS: usize = 4;

/// Side of each, and height of the line below, pixels.
const TILE: u32 = 512;
const CAPTION: u32 = 48;

/// How the papers' factors of a style are spread over a volume's voxels, seen as the style `papers` sees them without
/// further options: which of them takes the dots away, and where one might begin.
pub fn factors(input: VolumeInput, style: Style, warnings: &mut Warnings) -> Result<Value, FileError> {
    // The lists themselves are not needed.
    let style = Style { bake: BakeMethod::Voxel, k_max: 0.01, ..style };
    let mut scene = Scene::default();
    for part in Loaded::Volume(Box::new(input)).into_meshes(&style, None, warnings)?.into_iter().take(1) {
        part.turn_camera(&style, None, &mut scene);
        scene.add(part.into_object(style.clone(), warnings)?);
    }
    scene.bake(|_| ());
    let histograms = scene.factor_histograms(0).unwrap_or_default();
    let one = |h: &FactorHistogram| json!({ "name": h.name, "on": h.on, "mean": h.mean, "above_1": h.above, "bins": h.bins });
    Ok(histograms.iter().map(one).collect())
}

/// A volume in words and as JSON, with the features that were found in it; warnings are the caller's.
pub fn describe(input: &VolumeInput, features: &Result<Features, FileError>) -> (String, Value) {
    let volume = &input.volume;
    let affine = volume.affine();
    let [x, y, z] = volume.dims();
    let kind = volume.samples().sample_type();
    let count = volume.samples().len();
    let unit = match affine.unit {
        Unit::Unknown => String::new(),
        unit => format!(" {unit}"),
    };
    let triple = |v: [f64; 3]| v.map(number).join(" x ");
    let place = |v: [f64; 3]| v.map(number).join(", ");
    let anisotropy = affine.anisotropy();
    let unequal =
        if anisotropy > 1.001 { format!(" (unequal: 1 to {})", number(anisotropy)) } else { String::new() };
    let orientation = affine.orientation().map(|letters| letters.iter().collect::<String>());
    let oblique = affine.is_oblique().then(|| affine.obliquity_deg());
    let words = match (&orientation, oblique) {
        (None, _) => "unknown (the file does not say)".into(),
        (Some(letters), None) => letters.clone(),
        (Some(letters), Some(angle)) => format!("{letters}, oblique by {angle:.1} degrees"),
    };
    let [low, high] = volume.bounds().map(|corner| corner.to_array());
    let mut rows = vec![("format", input.format.clone())];
    if let Some(checksum) = input.source.checksum {
        rows.push(("checksum", format!("{checksum:016x}")));
    }
    rows.push((
        "voxels",
        format!("{x} x {y} x {z}, {} of {} ({})", grouped(count), kind.name(), mib(count * kind.bytes())),
    ));
    rows.push(("spacing", format!("{}{unit}{unequal}", triple(volume.spacing()))));
    rows.push(("size", format!("{}{unit}", triple(volume.extent()))));
    rows.push(("orientation", words));
    let space = match affine.space {
        Space::Unknown => "its own axes",
        Space::Patient => "the patient's: +x left, +y posterior, +z superior",
    };
    rows.push(("space", space.into()));
    rows.push(("first voxel", place(affine.origin.to_array())));
    rows.push(("bounds", format!("{} to {}", place(low), place(high))));
    if affine.is_mirrored() {
        rows.push(("handedness", "mirrored: the axes of the voxels are left-handed".into()));
    }
    if affine.unit == Unit::Unknown {
        rows.push(("units", "unknown (the file does not say)".into()));
    }
    let scaling = volume.scaling();
    if !scaling.is_identity() {
        let (slope, intercept) = (number(scaling.slope), number(scaling.intercept));
        rows.push(("scaling", format!("value = {slope} x sample + {intercept}")));
    }
    let stats = volume.stats();
    match &stats {
        None => rows.push(("values", "none is a finite number".into())),
        Some(s) => {
            rows.push(("values", format!("{} to {}", number(s.min), number(s.max))));
            rows.push(("mean", format!("{}, standard deviation {}", number(s.mean), number(s.deviation))));
            let percentiles = [s.low, s.median, s.high].map(number);
            rows.push(("0.1, 50, 99.9 %", percentiles.join(", ")));
            if s.nans + s.infinities > 0 {
                let (nans, infinities) = (grouped(s.nans), grouped(s.infinities));
                rows.push(("no number", format!("{nans} NaN, {infinities} infinite")));
            }
        }
    }
    // What the file says in its own words comes last: it may be anything.
    let facts: Vec<(&str, String)> = input.facts.iter().map(|(k, v)| (k.as_str(), v.clone())).collect();
    let mut words = format!("{}\n{}", input.input, list(&rows));
    if !facts.is_empty() {
        words += &format!("\nin the file\n{}", list(&facts));
    }
    match features {
        Ok(found) => {
            words += &format!(
                "\nfeatures (render --set feature=N; {} first: {})\n",
                found.default + 1,
                found.reason
            );
            let row = |(i, f): (usize, &Feature)| {
                let [low, high] = f.range.map(number);
                let text = format!(
                    "{}, surface at {}, values {low} to {high}, {:.0} %",
                    f.name,
                    number(f.iso),
                    100.0 * f.share
                );
                ((i + 1).to_string(), text)
            };
            let rows: Vec<(String, String)> = found.features.iter().enumerate().map(row).collect();
            words += &list(&rows.iter().map(|(k, v)| (k.as_str(), v.clone())).collect::<Vec<_>>());
        }
        Err(error) => words += &format!("\nfeatures\n  none: {error}\n"),
    }
    if let Some(histogram) = volume.histogram(ROWS) {
        // Bins of whole numbers begin half-way between two of them.
        let whole = !matches!(kind, SampleType::F32 | SampleType::F64) && scaling.is_identity();
        words +=
            &format!("\nhistogram (bars: logarithm of the number of voxels)\n{}", bars(&histogram, whole));
    }
    let linear = affine.linear;
    let columns = [linear.x_axis, linear.y_axis, linear.z_axis, affine.origin].map(|v| v.to_array());
    let mut value = json!({
        "file": input.input,
        "format": input.format,
        "dimensions": [x, y, z],
        "type": kind.name(),
        "spacing": volume.spacing(),
        "size": volume.extent(),
        "units": match affine.unit { Unit::Unknown => Value::Null, unit => json!(unit.symbol()) },
        "orientation": orientation,
        "oblique_deg": oblique,
        "mirrored": affine.is_mirrored(),
        "space": match affine.space { Space::Unknown => Value::Null, Space::Patient => json!("LPS") },
        "affine": columns,
        "bounds": { "min": low, "max": high },
        "scaling": { "slope": scaling.slope, "intercept": scaling.intercept },
        "values": stats.as_ref().map(values),
        "facts": input.facts.iter().map(|(k, v)| json!([k, v])).collect::<Vec<_>>(),
        "histogram": volume.histogram(BINS).map(|h| json!({ "min": h.min, "max": h.max, "counts": h.counts })),
    });
    if let Ok(found) = features {
        value["features"] = found.features.iter().map(feature).collect();
        value["default_feature"] = json!(found.default + 1);
    }
    if let Some(checksum) = input.source.checksum {
        value["checksum"] = json!(format!("{checksum:016x}"));
    }
    (words, value)
}

fn feature(f: &Feature) -> Value {
    json!({ "name": f.name, "iso": f.iso, "range": f.range, "mean": f.mean, "share": f.share })
}

/// Draws the features of a volume in rows, each as `feature=N` draws it, and under each its number. If there are more
/// than [`MOST_FEATURES`], `warnings` say that the others are left out.
pub fn sheet(
    input: &VolumeInput,
    features: &Features,
    warnings: &mut Warnings,
) -> Result<Drawing, FileError> {
    let found = features.features.len();
    if found > MOST_FEATURES {
        warnings
            .say(format!("only the first {MOST_FEATURES} of {found} features stand on the contact sheet"));
    }
    let count = found.clamp(1, MOST_FEATURES);
    let columns = count.min(COLUMNS);
    let rows = count.div_ceil(columns);
    let page =
        Page { width: TILE * columns as u32, height: (TILE + CAPTION) * rows as u32, ..Page::default() };
    let mut sheet = Drawing::new(page, Color::WHITE);
    for (i, feature) in features.features.iter().take(count).enumerate() {
        let style = Style { feature: FeatureChoice::Number(i as u32 + 1), ..Style::default() };
        let mesh = input.surface(&style, Some(feature.iso), warnings)?;
        let mut scene = Scene::default();
        mesh.turn_camera(&style, None, &mut scene);
        scene.add(mesh.into_object(style, warnings)?);
        scene.page = Page { width: TILE, height: TILE, ..Page::default() };
        let left = (i % columns) as f32 * TILE as f32;
        let top = (i / columns) as f32 * (TILE + CAPTION) as f32;
        for mut layer in scene.draw().layers {
            layer.dots.x.iter_mut().chain(&mut layer.strokes.x).for_each(|x| *x += left);
            layer.dots.y.iter_mut().chain(&mut layer.strokes.y).for_each(|y| *y += top);
            layer.object = format!("{} {}", i + 1, feature.name);
            sheet.layers.push(layer);
        }
        let mut layer = Layer { object: "captions".into(), ..Layer::default() };
        // The number, and the value of its surface.
        let height = 0.4 * CAPTION as f32;
        let text = format!("{}   {}", i + 1, number(feature.iso));
        let x = left + 0.5 * (TILE as f32 - text_width(&text, height));
        let at = [x, top + TILE as f32 + 0.7 * CAPTION as f32];
        write_text(&mut layer.strokes, &text, at, height, 2.0, (i as u64) << 16);
        sheet.layers.push(layer);
    }
    Ok(sheet)
}

fn values(s: &VolumeStats) -> Value {
    json!({
        "min": s.min, "max": s.max, "mean": s.mean, "deviation": s.deviation,
        "percentiles": { "0.1": s.low, "50": s.median, "99.9": s.high },
        "finite": s.count, "nan": s.nans, "infinite": s.infinities,
    })
}

/// The histogram as lines of text: lower edge, bar, share.
fn bars(histogram: &Histogram, whole: bool) -> String {
    let total = histogram.counts.iter().sum::<u64>().max(1) as f64;
    let top = histogram.counts.iter().max().map_or(1.0, |&n| (1.0 + n as f64).ln());
    let edge = |k: usize| histogram.min + k as f64 * histogram.width();
    let edges: Vec<String> = (0..histogram.counts.len())
        .map(|k| if whole { (edge(k).ceil() + 0.0).to_string() } else { number(edge(k)) })
        .collect();
    let width = edges.iter().map(String::len).max().unwrap_or(0);
    let mut text = String::new();
    for (edge, &count) in edges.iter().zip(&histogram.counts) {
        let length = (BAR * (1.0 + count as f64).ln() / top).round() as usize;
        let share = 100.0 * count as f64 / total;
        let share = match count {
            0 => String::new(),
            _ if share < 0.01 => " <0.01 %".into(),
            _ => format!(" {share:.2} %"),
        };
        text += &format!("  {edge:>width$} |{}{share}\n", "#".repeat(length));
    }
    text
}

fn mib(bytes: usize) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..1_000_000 => format!("{:.0} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / (1 << 20) as f64),
    }
}
