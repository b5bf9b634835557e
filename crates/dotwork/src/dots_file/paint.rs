//! The paint of a surface in a `.dots` file: its materials and their pictures.

use std::sync::Arc;

use dotwork_io::dots::{Reader, Writer};
use dotwork_mesh::{Alpha, Material, Paint, Picture, Wrap};
use toml::{Table, Value};

use super::settings::number;

const WRAPS: [(&str, Wrap); 3] = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];

/// Writes the paint of object `k`, and gives what belongs in the text on its surface.
pub(super) fn write(file: &mut Writer, k: usize, paint: &Paint) -> Value {
    file.section_u32(&format!("{k}/paint/material"), &paint.material);
    file.section_f32(&format!("{k}/paint/corners"), paint.corners.as_flattened().as_flattened());
    let mut pictures: Vec<&Arc<Picture>> = Vec::new();
    let mut materials = Vec::new();
    for material in paint.materials.iter() {
        let mut table = Table::new();
        table.insert("factor".into(), Value::Array(material.factor.map(number).to_vec()));
        match material.alpha {
            Alpha::Opaque => {}
            Alpha::Mask(least) => {
                table.insert("mask".into(), number(least));
            }
            Alpha::Blend => {
                table.insert("blend".into(), Value::Boolean(true));
            }
        }
        if let Some(picture) = &material.picture {
            let known = pictures.iter().position(|p| Arc::ptr_eq(p, picture));
            let index = known.unwrap_or(pictures.len());
            if known.is_none() {
                pictures.push(picture);
            }
            table.insert("picture".into(), Value::Integer(index as i64));
            let word = |wrap: Wrap| WRAPS.iter().find(|(_, w)| *w == wrap).map_or("repeat", |(word, _)| word);
            let wrap = material.wrap.map(|w| Value::String(word(w).into()));
            table.insert("wrap".into(), Value::Array(wrap.to_vec()));
            table.insert("nearest".into(), Value::Boolean(material.nearest));
        }
        materials.push(Value::Table(table));
    }
    for (n, picture) in pictures.iter().enumerate() {
        let pixels: Vec<u32> = picture.pixels().iter().map(|&p| u32::from_le_bytes(p)).collect();
        file.section_u32(&format!("{k}/paint/picture {n}"), &pixels);
    }
    let sizes = pictures.iter().map(|p| Value::Array(p.size().map(|s| Value::Integer(s as i64)).to_vec()));
    let mut table = Table::new();
    table.insert("pictures".into(), Value::Array(sizes.collect()));
    table.insert("material".into(), Value::Array(materials));
    Value::Table(table)
}

/// The paint of object `k` with so many triangles, if it has any.
///
/// # Errors
/// What is missing or impossible.
pub(super) fn read(
    file: &Reader,
    k: usize,
    surface: &Value,
    triangles: usize,
) -> Result<Option<Arc<Paint>>, String> {
    let Some(text) = surface.get("paint") else { return Ok(None) };
    let broken = |what: &str| format!("its paint: {what}");
    let list = |key: &str| text.get(key).and_then(Value::as_array).ok_or_else(|| broken("a list is missing"));
    let mut pictures = Vec::new();
    for (n, size) in list("pictures")?.iter().enumerate() {
        let side = |i: usize| size.get(i).and_then(Value::as_integer).and_then(|v| usize::try_from(v).ok());
        let pixels = file.u32s(&format!("{k}/paint/picture {n}")).map_err(|e| e.to_string())?;
        let pixels = pixels.into_iter().map(u32::to_le_bytes).collect();
        let picture = Picture::new(side(0).unwrap_or(0), side(1).unwrap_or(0), pixels);
        pictures.push(Arc::new(picture.ok_or_else(|| broken("a picture has other pixels than it says"))?));
    }
    let materials: Result<Vec<Material>, String> = list("material")?
        .iter()
        .map(|m| material(m, &pictures).ok_or_else(|| broken("a material is impossible")))
        .collect();
    let section = |what: &str| format!("{k}/paint/{what}");
    for (what, width) in [("material", 1), ("corners", 6)] {
        file.expect_length(&section(what), triangles.saturating_mul(width)).map_err(|e| e.to_string())?;
    }
    let corners = file.f32s(&section("corners")).map_err(|e| e.to_string())?;
    let corners = corners.as_chunks::<2>().0.as_chunks::<3>().0.to_vec();
    let material = file.u32s(&section("material")).map_err(|e| e.to_string())?;
    let paint = Paint { materials: Arc::new(materials?), material, corners };
    if !paint.fits(triangles) {
        return Err(broken("a triangle has a material that is not there"));
    }
    Ok(Some(Arc::new(paint)))
}

fn material(text: &Value, pictures: &[Arc<Picture>]) -> Option<Material> {
    let share = |v: &Value| v.as_float().map(|v| v as f32).filter(|v| (0.0..=1.0).contains(v));
    let factor: Option<Vec<f32>> = text.get("factor")?.as_array()?.iter().map(share).collect();
    let alpha = match (text.get("mask"), text.get("blend")) {
        (Some(least), _) => Alpha::Mask(least.as_float()? as f32),
        (None, Some(_)) => Alpha::Blend,
        (None, None) => Alpha::Opaque,
    };
    let mut material = Material { factor: factor?.try_into().ok()?, alpha, ..Material::default() };
    if let Some(picture) = text.get("picture") {
        let index = usize::try_from(picture.as_integer()?).ok()?;
        material.picture = Some(pictures.get(index)?.clone());
        let wrap = |i: usize| {
            let word = text.get("wrap")?.get(i)?.as_str()?;
            WRAPS.iter().find(|(w, _)| *w == word).map(|(_, wrap)| *wrap)
        };
        material.wrap = [wrap(0)?, wrap(1)?];
        material.nearest = text.get("nearest")?.as_bool()?;
    }
    Some(material)
}
