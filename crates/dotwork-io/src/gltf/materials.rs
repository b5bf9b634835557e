//! Materials: the base colour of each triangle, and where its corners lie on the picture of its material.

use std::collections::HashMap;
use std::sync::Arc;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Alpha, Material, Paint, Wrap};

use super::Document;
use super::budget::{Budget, PAINT, PLACE};
use super::json::{self, BaseColor, Primitive, Shape, TextureOf};
use super::pictures::Pictures;
use crate::error::ReadErrorKind;

/// Gathers the paint of a scene as its triangles are drawn.
pub(super) struct Painter<'d, 'a> {
    document: &'d Document<'a>,
    pictures: Pictures<'d, 'a>,
    /// Of each material met: its number in `paint`, and the texture that it needs places on.
    known: HashMap<Option<u32>, (u32, Option<&'d TextureOf>)>,
    materials: Vec<Material>,
    paint: Paint,
}

impl<'d, 'a> Painter<'d, 'a> {
    pub(super) fn new(document: &'d Document<'a>) -> Self {
        let (known, materials, paint) = Default::default();
        Painter { document, pictures: Pictures::new(document), known, materials, paint }
    }

    /// Paints the triangles of a primitive, whose `count` vertices have numbers from `base` on.
    pub(super) fn paint(
        &mut self,
        primitive: &Primitive,
        triangles: &[[u32; 3]],
        base: u32,
        count: usize,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<(), ReadErrorKind> {
        // Without materials all is white.
        if self.document.json.materials.is_empty() {
            return Ok(());
        }
        budget.charge(self.document, triangles.len(), PAINT)?;
        let (material, texture) = self.material(primitive.material, warnings)?;
        let places = match texture {
            Some(texture) => self.places(primitive, texture, count, budget)?,
            None => Vec::new(),
        };
        let place = |v: u32| places.get((v - base) as usize).copied().unwrap_or_default();
        self.paint.material.resize(self.paint.material.len() + triangles.len(), material);
        self.paint.corners.extend(triangles.iter().map(|t| t.map(place)));
        Ok(())
    }

    /// The paint of all triangles; `None` if they are white.
    pub(super) fn finish(self) -> Option<Paint> {
        let white = self.materials.iter().all(|m| *m == Material::default());
        (!white).then(|| Paint { materials: Arc::new(self.materials), ..self.paint })
    }

    /// The number of a material in the paint, and its texture if it has one that is there.
    fn material(
        &mut self,
        index: Option<u32>,
        warnings: &mut Warnings,
    ) -> Result<(u32, Option<&'d TextureOf>), ReadErrorKind> {
        if let Some(&known) = self.known.get(&index) {
            return Ok(known);
        }
        let json = &self.document.json;
        let (mut material, mut texture) = (Material::default(), None);
        if let Some(index) = index {
            let Some(found) = json.materials.get(index as usize) else {
                let count = json.materials.len();
                return Err(ReadErrorKind::at_item(
                    "material",
                    index as usize,
                    format!("does not exist ({count} materials)"),
                ));
            };
            material.alpha = alpha(found);
            let base = base_color(found);
            if let Some(factor) = base.and_then(|b| b.factor) {
                material.factor = factor.map(|c| if c.is_finite() { c.clamp(0.0, 1.0) } else { 1.0 });
            }
            texture = base.and_then(|b| b.texture.as_ref());
            if let Some(texture) = texture {
                self.texture(texture.index, &mut material, warnings);
            }
            texture = texture.filter(|_| material.picture.is_some());
        }
        let known = (self.materials.len() as u32, texture);
        self.materials.push(material);
        self.known.insert(index, known);
        Ok(known)
    }

    /// Puts a texture into a material, if it can be read.
    fn texture(&mut self, index: u32, material: &mut Material, warnings: &mut Warnings) {
        let json = &self.document.json;
        let Some(texture) = json.textures.get(index as usize) else {
            let count = json.textures.len();
            warnings.say(format!("texture {index} does not exist ({count} textures): left out"));
            return;
        };
        // Only an extension knows the picture: one in another format.
        let Some(source) = texture.source else {
            warnings.say(format!("texture {index} has no picture in PNG or JPEG: left out"));
            return;
        };
        if let Some(sampler) = texture.sampler.and_then(|s| json.samplers.get(s as usize)) {
            let wrap = |code: Option<u32>| match code {
                Some(33071) => Wrap::Clamp,
                Some(33648) => Wrap::Mirror,
                _ => Wrap::Repeat,
            };
            material.wrap = [wrap(sampler.wrap_s), wrap(sampler.wrap_t)];
            material.nearest = sampler.mag_filter == Some(9728);
        }
        material.picture = self.pictures.get(source, warnings);
    }

    /// Where the vertices of a primitive lie on a texture.
    fn places(
        &self,
        primitive: &Primitive,
        texture: &TextureOf,
        count: usize,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; 2]>, ReadErrorKind> {
        let transform = texture.extensions.as_ref().and_then(|e| e.transform.as_ref());
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(texture.tex_coord);
        let accessor = match set {
            0 => primitive.attributes.texcoord_0,
            1 => primitive.attributes.texcoord_1,
            _ => None,
        };
        let Some(accessor) = accessor else { return Ok(Vec::new()) };
        budget.charge(self.document, count, PLACE)?;
        let mut places = self.document.elements(accessor, &[Shape::Vec2], Some(count))?.floats::<2>();
        if let Some(transform) = transform {
            let [x, y] = transform.offset.unwrap_or_default();
            let [sx, sy] = transform.scale.unwrap_or([1.0; 2]);
            let (sin, cos) = transform.rotation.unwrap_or(0.0).sin_cos();
            // Scaled, turned, moved, as the extension has it.
            for place in &mut places {
                let [u, v] = [place[0] * sx, place[1] * sy];
                *place = [x + cos * u + sin * v, y - sin * u + cos * v];
            }
        }
        Ok(places)
    }
}

fn base_color<'d>(material: &'d json::Material) -> Option<&'d BaseColor> {
    let glossy = material.extensions.as_ref().and_then(|e| e.glossy.as_ref());
    glossy.or(material.base.as_deref())
}

fn alpha(material: &json::Material) -> Alpha {
    match material.alpha_mode.as_ref().map(|mode| &*mode.0) {
        Some("BLEND") => Alpha::Blend,
        Some("MASK") => Alpha::Mask(material.alpha_cutoff.filter(|c| c.is_finite()).unwrap_or(0.5)),
        _ => Alpha::Opaque,
    }
}
