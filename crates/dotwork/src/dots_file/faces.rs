//! The faces of a bake in a `.dots` file: what does not follow from the mesh and the stipples.

use dotwork_ink::{Baked, Carrier, Elements, Faces, Stock};
use dotwork_io::dots::{DotsError, Reader, Writer};
use dotwork_mesh::Mesh;
use rayon::prelude::*;
use toml::{Table, Value};

use super::settings::number;

/// Writes the faces of object `k`, and gives what belongs in the text on its surface; `None` if the elements are others.
pub(super) fn write(file: &mut Writer, k: usize, elements: &Elements) -> Option<Value> {
    let Carrier::Faces { number: numbers } = &elements.carrier else { return None };
    file.section_f32(&format!("{k}/faces/areas"), &elements.area);
    file.section_f32(&format!("{k}/faces/numbers"), numbers);
    let mut table = Table::new();
    table.insert("n_max".into(), number(elements.n_max));
    table.insert("wanted".into(), number(elements.wanted));
    table.insert("seed".into(), Value::Integer(elements.seed.into()));
    if let Some(reference) = elements.reference {
        table.insert("reference".into(), number(reference));
    }
    Some(Value::Table(table))
}

/// The stock of object `k` of a file: its stipples, checked, with its faces.
///
/// # Errors
/// What is missing or impossible.
pub(super) fn read(
    file: &Reader,
    k: usize,
    text: &Value,
    baked: Baked,
    mesh: &Mesh,
) -> Result<Stock, DotsError> {
    let section = |what: &str| format!("{k}/faces/{what}");
    let broken = |what: &str| file.invalid(format!("object {k}: {what}"));
    let float = |key: &str| {
        let v = text.get(key).and_then(Value::as_float).map(|v| v as f32);
        v.filter(|v| *v > 0.0 && v.is_finite())
            .ok_or_else(|| broken(&format!("'{key}' of its faces is missing or impossible")))
    };
    let reference = match text.get("reference") {
        None => None,
        Some(_) => Some(float("reference")?),
    };
    let seed = text.get("seed").and_then(Value::as_integer).and_then(|v| u32::try_from(v).ok());
    for what in ["areas", "numbers"] {
        file.expect_length(&section(what), mesh.triangles.len())?;
    }
    let faces = Faces {
        area: file.f32s(&section("areas"))?,
        number: file.f32s(&section("numbers"))?,
        n_max: float("n_max")?,
        wanted: float("wanted")?,
        seed: seed.ok_or_else(|| broken("'seed' of its faces is missing or impossible"))?,
        reference,
    };
    if !faces.area.par_iter().all(|a| *a >= 0.0 && a.is_finite()) {
        return Err(broken("an area of its faces is no size"));
    }
    if !faces.number.par_iter().all(|u| (0.0..1.0).contains(u)) {
        return Err(broken("a number of its faces is not a share from 0 to 1"));
    }
    Ok(Stock::of_faces(baked, mesh, faces))
}
