//! `.dots` files: a baked scene, complete.
//!
//! A `.dots` file is a whole input: surfaces, stipples, styles, camera, light and page. Drawing it gives the very bytes
//! that drawing its sources gives. The box is [`dotwork_io::dots`]; these are the sections in it:
//!
//! | section | holds |
//! |---|---|
//! | `settings` | TOML: version of dotwork, `seed`, `stipples`, `camera`, `light`, `page`, and per `object` its `name`, `source`, `checksum`, `style` |
//! | `surfaces` | TOML: per object `origin`, `closed`, `area` |
//! | `K/positions`, `K/normals` | of object `K` (from 0): three `f32` each |
//! | `K/triangles`, `K/corner_normals` | three `u32` each; the latter only where normals are split |
//! | `K/colors` | a `u32` a vertex, where vertices have colours: red, green, blue and opacity from the lowest byte |
//! | `K/paint/material`, `K/paint/corners`, `K/paint/picture N` | where triangles have materials: a `u32` a triangle, six `f32` a triangle (two for each corner), and for each picture a `u32` a pixel as in `K/colors`; `surfaces` has `paint` with `material` tables and the `pictures`' widths and heights |
//! | `K/radius`, `K/id`, `K/element`, `K/weights` | the bake: `f32`, `u64`, `u32`, two `f32` each |
//! | `K/neighbours` | where the bake is a hierarchy: four `u32` each, stipples before this one, 2³² − 1 for none |
//! | `K/voxels/positions`, `K/voxels/normals`, `K/voxels/magnitudes`, `K/voxels/values` | instead of these, where the bake is one of voxels: three `f32` each, then one; `surfaces` has `voxels` with `edges`, `n_max`, `slab`, `seed`, `reference` |
//! | `K/faces/areas`, `K/faces/numbers` | beside these, where the bake is one of faces: an `f32` a triangle each; `surfaces` has `faces` with `n_max`, `wanted`, `seed`, `reference` |
//! | `K/curves/voxels`, `K/curves/normals`, `K/curves/magnitudes`, `K/curves/laplacians` | where silhouette curves are drawn from voxels, those that may be part of them: numbers in the grid (`u32`, rising), three `f32`, then one; `surfaces` has `curves` with the grid's `dims`, `origin`, `edges`, and `t_log`, `t_grad`, `least` |
//!
//! A file may become no more than its length allows: four stipples of voxels and one voxel of curves for each byte, texts of
//! twice its length. Sections are packed, unless that would make a file too short for what it holds.
//!
//! Places of stipples are not stored: they follow from the bake and the surface, or from the voxels. What is read is
//! checked before it is used, so that a file made by someone else gives an error at worst; and a short file takes no
//! more memory than a scene of its size may: what sections unpack to, texts, the stipples of voxels and the voxels of curves are limited.

mod curves;
mod faces;
mod paint;
mod settings;
mod voxels;

use std::path::Path;
use std::sync::Arc;

use dotwork_export::write_atomic;
use dotwork_ink::lines::VoxelCurves;
use dotwork_ink::{Baked, Stock};
use dotwork_io::dots::{DotsError, Reader, Writer};
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;
use toml::{Table, Value};

use crate::endless::Endless;
use crate::files::FileError;
use crate::scene::{Object, Scene};

pub use settings::{Described, settings_text};

pub(crate) use settings::read as read_settings;

/// Coordinates beyond this are refused, as in meshes: their squares must stay inside `f32`.
const MAX_COORDINATE: f32 = 1e15;

/// Rounding of weights and unit vectors that is let pass.
const ROUNDING: f32 = 1e-4;

/// Ids of stipples stay below this; the object's number stands above.
const MAX_ID: u64 = 1 << 38;

/// Writes a scene as a `.dots` file, all of it or nothing. Objects that are not baked are left out.
///
/// ```no_run
/// use dotwork::{Style, Warnings, open, save_dots};
///
/// let mut scene = open("bunny.ply", &Style::default(), &mut Warnings::new())?;
/// scene.bake(|_| ());
/// save_dots("bunny.dots", &scene)?;
/// # Ok::<(), dotwork::FileError>(())
/// ```
///
/// # Errors
/// [`FileError::Write`]: what the system refuses.
pub fn save_dots(path: impl AsRef<Path>, scene: &Scene) -> Result<(), FileError> {
    let bytes = encode_dots(scene);
    Ok(write_atomic(path.as_ref(), |w| w.write_all(&bytes))?)
}

/// A scene as the bytes of a `.dots` file.
pub fn encode_dots(scene: &Scene) -> Vec<u8> {
    let mut file = Writer::new();
    let settings = settings_text(scene);
    file.text("settings", &settings);
    let mut surfaces = Vec::new();
    let baked = scene.objects.iter().filter_map(|o| Some((o, o.stock.as_deref()?)));
    for (k, (object, stock)) in baked.enumerate() {
        let mesh = &object.mesh;
        let bake = &stock.baked;
        let mut surface = Table::new();
        surface.insert("origin".into(), Value::Array(mesh.origin.iter().map(|&v| Value::Float(v)).collect()));
        surface.insert("closed".into(), Value::Boolean(mesh.closed));
        surface.insert("area".into(), Value::Float(bake.area));
        let section = |what: &str| format!("{k}/{what}");
        file.section_f32(&section("positions"), &flat(&mesh.positions));
        file.section_u32(&section("triangles"), mesh.triangles.as_flattened());
        file.section_f32(&section("normals"), &flat(&mesh.normals));
        if mesh.corner_normals != mesh.triangles {
            file.section_u32(&section("corner_normals"), mesh.corner_normals.as_flattened());
        }
        if !mesh.colors.is_empty() {
            let colors: Vec<u32> = mesh.colors.iter().map(|&c| u32::from_le_bytes(c)).collect();
            file.section_u32(&section("colors"), &colors);
        }
        if let Some(paint) = &mesh.paint {
            surface.insert("paint".into(), paint::write(&mut file, k, paint));
        }
        if let Some(elements) = stock.elements.as_ref().filter(|elements| !elements.are_faces()) {
            surface.insert("voxels".into(), voxels::write(&mut file, k, elements));
        } else {
            file.section_f32(&section("radius"), &bake.radius);
            file.section_u64(&section("id"), &bake.id);
            file.section_u32(&section("element"), &bake.element);
            file.section_f32(&section("weights"), bake.weights.as_flattened());
            if !bake.neighbours.is_empty() {
                file.section_u32(&section("neighbours"), bake.neighbours.as_flattened());
            }
        }
        if let Some(faces) = stock.elements.as_ref().and_then(|e| faces::write(&mut file, k, e)) {
            surface.insert("faces".into(), faces);
        }
        if let Some(curves) = curves_of(object) {
            surface.insert("curves".into(), curves::write(&mut file, k, curves));
        }
        surfaces.push(Value::Table(surface));
    }
    let mut table = Table::new();
    table.insert("object".into(), Value::Array(surfaces));
    let surfaces = table.to_string();
    let longest_text = settings.len().max(surfaces.len());
    file.text("surfaces", &surfaces);
    let bytes = file.finish();
    let elements = scene.objects.iter().filter_map(|o| o.stock.as_deref()?.elements.as_ref());
    let baked = scene.objects.iter().filter(|o| o.stock.is_some());
    let curves = curves::least_length(baked.filter_map(curves_of));
    let least =
        voxels::least_length(elements).max(curves).max(longest_text.div_ceil(settings::TEXT_PER_BYTE));
    if bytes.len() >= least {
        return bytes;
    }
    // Packed it would be refused as hostile; as it is, a section is long enough for what it becomes.
    file.finish_plain()
}

/// The curves that an object draws.
fn curves_of(object: &Object) -> Option<&VoxelCurves> {
    object.curves.as_deref().filter(|_| object.draws_curves())
}

fn flat(vectors: &[Vec3]) -> Vec<f32> {
    vectors.iter().flat_map(|v| v.to_array()).collect()
}

/// The scene of an opened file.
pub(crate) fn read_scene(file: &Reader) -> Result<Scene, DotsError> {
    let invalid = |e: String| file.invalid(e);
    let (mut scene, described, _) =
        settings::read(&file.text("settings")?, file.length()).map_err(invalid)?;
    let surfaces = settings::toml_of(&file.text("surfaces")?, "surfaces", file.length()).map_err(invalid)?;
    let surfaces = surfaces.get("object").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    if described.is_empty() || described.len() != surfaces.len() {
        let (a, b) = (described.len(), surfaces.len());
        return Err(file.invalid(format!("it describes {a} objects with {b} surfaces")));
    }
    let mut allowance = voxels::Allowance::of(file);
    let mut curve_allowance = curves::Allowance::of(file);
    for (k, (object, surface)) in described.into_iter().zip(surfaces).enumerate() {
        let (mesh, stock) = read_object(file, k, surface, &mut allowance)?;
        let curves = match surface.get("curves") {
            Some(text) => Some(Arc::new(curves::read(file, k, text, &mut curve_allowance)?)),
            None => None,
        };
        let (mesh, stock) = (Arc::new(mesh), Some(Arc::new(stock)));
        let evenly = |s: &Arc<Stock>| s.elements.is_none() && s.baked.neighbours.is_empty();
        let by_surface = stock.as_ref().is_some_and(evenly);
        let endless = by_surface.then(|| Endless::new(object.style.regularity, scene.seed));
        let blank = Object::of_mesh(object.name, mesh, object.style);
        let (source, world) = (object.source, object.world);
        scene.objects.push(Object { source, world, stock, endless, curves, ..blank });
    }
    Ok(scene)
}

fn read_object(
    file: &Reader,
    k: usize,
    surface: &Value,
    allowance: &mut voxels::Allowance,
) -> Result<(Mesh, Stock), DotsError> {
    let section = |what: &str| format!("{k}/{what}");
    let broken = |what: &str| file.invalid(format!("object {k}: {what}"));

    let origin = surface.get("origin").and_then(Value::as_array).and_then(|a| {
        let [x, y, z] = a.as_slice() else { return None };
        let [x, y, z] = [x.as_float()?, y.as_float()?, z.as_float()?];
        [x, y, z].iter().all(|v| v.is_finite()).then_some([x, y, z])
    });
    let origin = origin.ok_or_else(|| broken("its origin is not three numbers"))?;
    let closed =
        surface.get("closed").and_then(Value::as_bool).ok_or_else(|| broken("'closed' is missing"))?;
    let area = surface.get("area").and_then(Value::as_float).filter(|a| *a > 0.0 && a.is_finite());
    let area = area.ok_or_else(|| broken("its area is not a positive number"))?;

    let positions =
        vectors(file.f32s(&section("positions"))?).ok_or_else(|| broken("positions are not triples"))?;
    let triangles =
        triples(file.u32s(&section("triangles"))?).ok_or_else(|| broken("triangles are not triples"))?;
    let normals =
        vectors(file.f32s(&section("normals"))?).ok_or_else(|| broken("normals are not triples"))?;
    let corner_normals = match section("corner_normals") {
        name if file.has(&name) => {
            triples(file.u32s(&name)?).ok_or_else(|| broken("corner normals are not triples"))?
        }
        _ => triangles.clone(),
    };
    let colors: Vec<[u8; 4]> = match section("colors") {
        name if file.has(&name) => file.u32s(&name)?.into_iter().map(u32::to_le_bytes).collect(),
        _ => Vec::new(),
    };
    let within =
        |indices: &[[u32; 3]], n: usize| indices.as_flattened().par_iter().all(|&i| (i as usize) < n);
    let small = |v: &Vec3, max: f32| v.abs().max_element() <= max && v.is_finite();
    if !positions.par_iter().all(|p| small(p, MAX_COORDINATE)) {
        return Err(broken("a coordinate is not a number of reasonable size"));
    }
    if !normals.par_iter().all(|n| small(n, 1.0 + ROUNDING)) {
        return Err(broken("a normal is not a unit vector"));
    }
    if triangles.is_empty() || corner_normals.len() != triangles.len() {
        return Err(broken("triangles and corner normals differ in number"));
    }
    if !within(&triangles, positions.len()) || !within(&corner_normals, normals.len()) {
        return Err(broken("a triangle refers to a vertex or normal that is not there"));
    }
    if !(colors.is_empty() || colors.len() == positions.len()) {
        return Err(broken("vertices and colours differ in number"));
    }
    let paint = paint::read(file, k, surface, triangles.len()).map_err(|e| broken(&e))?;
    let mesh = Mesh { positions, triangles, normals, corner_normals, origin, closed, colors, paint };
    let radius = mesh.bounding_sphere().1;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(broken("its surface has no size"));
    }

    if let Some(text) = surface.get("voxels") {
        let stock = voxels::read(file, k, text, allowance)?;
        return Ok((mesh, stock));
    }

    let (_, count) = file.describe(&section("radius"))?;
    let count = usize::try_from(count).map_err(|_| broken("it has too many stipples"))?;
    for (what, width) in [("id", 1), ("element", 1), ("weights", 2)] {
        file.expect_length(&section(what), count.saturating_mul(width))?;
    }
    let baked = Baked {
        radius: file.f32s(&section("radius"))?,
        id: file.u64s(&section("id"))?,
        element: file.u32s(&section("element"))?,
        weights: file.f32s(&section("weights"))?.as_chunks::<2>().0.to_vec(),
        neighbours: match section("neighbours") {
            name if file.has(&name) => {
                file.expect_length(&name, count.saturating_mul(4))?;
                file.u32s(&name)?.as_chunks::<4>().0.to_vec()
            }
            _ => Vec::new(),
        },
        area,
    };
    if baked.is_empty() {
        return Err(broken("it has no stipples"));
    }
    let falling = baked.radius.par_windows(2).all(|r| r[0] >= r[1]);
    if !falling || !baked.radius.par_iter().all(|r| *r > 0.0 && r.is_finite()) {
        return Err(broken("the stipples' radii are not positive and falling"));
    }
    if !baked.element.par_iter().all(|&e| (e as usize) < mesh.triangles.len()) {
        return Err(broken("a stipple lies on a triangle that is not there"));
    }
    let inside = |&[v, w]: &[f32; 2]| v >= -ROUNDING && w >= -ROUNDING && v + w <= 1.0 + ROUNDING;
    if !baked.weights.par_iter().all(inside) {
        return Err(broken("a stipple lies outside its triangle"));
    }
    let earlier = |(i, all): (usize, &[u32; 4])| all.iter().all(|&n| n == u32::MAX || (n as usize) < i);
    if !baked.neighbours.par_iter().enumerate().all(earlier) {
        return Err(broken("a stipple has a neighbour that does not come before it"));
    }
    let mut ids = baked.id.clone();
    ids.par_sort_unstable();
    if ids.last().is_some_and(|&id| id >= MAX_ID) || ids.par_windows(2).any(|w| w[0] == w[1]) {
        return Err(broken("the stipples' ids are not unique or too large"));
    }
    let stock = match surface.get("faces") {
        None => Stock::on_mesh(baked, &mesh),
        Some(text) => faces::read(file, k, text, baked, &mesh)?,
    };
    Ok((mesh, stock))
}

fn vectors(flat: Vec<f32>) -> Option<Vec<Vec3>> {
    let (chunks, []) = flat.as_chunks::<3>() else { return None };
    Some(chunks.iter().map(|&v| Vec3::from_array(v)).collect())
}

fn triples(flat: Vec<u32>) -> Option<Vec<[u32; 3]>> {
    let (chunks, []) = flat.as_chunks::<3>() else { return None };
    Some(chunks.to_vec())
}
