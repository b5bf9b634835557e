//! The JSON of a glTF file, as far as geometry needs it. Indices are checked where they are used.
//!
//! Texts borrow from the file, so that embedded buffers are not copied. Missing members cost memory though (a node of
//! two bytes, `{}`, becomes one of a hundred), so lists whose items may be next to nothing are limited; the items of
//! all others have members that must be there, which keeps them within some five times their text.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

use super::container::Parts;
use crate::error::{ReadErrorKind, one_line};

/// The most nodes, scenes or extensions that a file may have.
const MOST_ITEMS: usize = 1 << 19;

/// The longest report of a JSON error, in characters.
const LONGEST_REPORT: usize = 160;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Json<'a> {
    #[serde(borrow)]
    asset: Asset<'a>,
    #[serde(borrow, default, deserialize_with = "limited")]
    pub(super) extensions_used: Vec<Text<'a>>,
    #[serde(borrow, default, deserialize_with = "limited")]
    pub(super) extensions_required: Vec<Text<'a>>,
    pub(super) scene: Option<u32>,
    #[serde(default, deserialize_with = "limited")]
    pub(super) scenes: Vec<Scene>,
    #[serde(default, deserialize_with = "limited")]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) skins: Vec<Skin>,
    #[serde(borrow, default, deserialize_with = "limited")]
    pub(super) animations: Vec<Animation<'a>>,
    #[serde(borrow, default, deserialize_with = "limited")]
    pub(super) cameras: Vec<Camera<'a>>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(borrow, default)]
    pub(super) buffers: Vec<Buffer<'a>>,
    #[serde(borrow, default, deserialize_with = "limited")]
    pub(super) materials: Vec<Material<'a>>,
    #[serde(default, deserialize_with = "limited")]
    pub(super) textures: Vec<Texture>,
    #[serde(default, deserialize_with = "limited")]
    pub(super) samplers: Vec<Wrapping>,
    #[serde(borrow, default, deserialize_with = "limited")]
    pub(super) images: Vec<Image<'a>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset<'a> {
    #[serde(borrow)]
    version: Text<'a>,
    #[serde(borrow)]
    min_version: Option<Text<'a>>,
}

impl Asset<'_> {
    /// Later versions 2.x may be read unless the file says otherwise.
    fn is_readable(&self) -> bool {
        self.min_version.as_ref().unwrap_or(&self.version).0.starts_with("2.")
    }
}

#[derive(Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<u32>,
}

#[derive(Deserialize)]
pub(super) struct Node {
    #[serde(default)]
    pub(super) children: Vec<u32>,
    pub(super) mesh: Option<u32>,
    pub(super) skin: Option<u32>,
    pub(super) camera: Option<u32>,
    /// Column by column.
    pub(super) matrix: Option<Box<[f64; 16]>>,
    pub(super) translation: Option<Box<[f64; 3]>>,
    /// A quaternion, x y z w.
    pub(super) rotation: Option<Box<[f64; 4]>>,
    pub(super) scale: Option<Box<[f64; 3]>>,
    #[serde(default)]
    pub(super) weights: Vec<f32>,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub(super) primitives: Vec<Primitive>,
    #[serde(default)]
    pub(super) weights: Vec<f32>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<u32>,
    pub(super) material: Option<u32>,
    /// What the indices make; triangles if not said.
    pub(super) mode: Option<u32>,
    #[serde(default)]
    pub(super) targets: Vec<Target>,
}

/// A material, as far as its base colour goes.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material<'a> {
    #[serde(rename = "pbrMetallicRoughness")]
    pub(super) base: Option<Box<BaseColor>>,
    #[serde(borrow)]
    pub(super) alpha_mode: Option<Text<'a>>,
    pub(super) alpha_cutoff: Option<f32>,
    pub(super) extensions: Option<Box<MaterialExtensions>>,
}

#[derive(Deserialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(super) glossy: Option<BaseColor>,
}

#[derive(Deserialize)]
pub(super) struct BaseColor {
    #[serde(rename = "baseColorFactor", alias = "diffuseFactor")]
    pub(super) factor: Option<[f32; 4]>,
    #[serde(rename = "baseColorTexture", alias = "diffuseTexture")]
    pub(super) texture: Option<TextureOf>,
}

/// Which texture, and where on it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureOf {
    pub(super) index: u32,
    #[serde(default)]
    pub(super) tex_coord: u32,
    pub(super) extensions: Option<TextureExtensions>,
}

#[derive(Deserialize)]
pub(super) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureTransform {
    pub(super) offset: Option<[f32; 2]>,
    pub(super) rotation: Option<f32>,
    pub(super) scale: Option<[f32; 2]>,
    pub(super) tex_coord: Option<u32>,
}

#[derive(Deserialize)]
pub(super) struct Texture {
    pub(super) sampler: Option<u32>,
    pub(super) source: Option<u32>,
}

/// A sampler of a texture.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Wrapping {
    pub(super) wrap_s: Option<u32>,
    pub(super) wrap_t: Option<u32>,
    pub(super) mag_filter: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image<'a> {
    #[serde(borrow)]
    pub(super) uri: Option<Text<'a>>,
    pub(super) buffer_view: Option<u32>,
}

/// The attributes that place and colour vertices.
#[derive(Clone, Copy, Deserialize, PartialEq, Eq, Hash)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub(super) position: Option<u32>,
    #[serde(rename = "COLOR_0")]
    pub(super) color: Option<u32>,
    #[serde(rename = "TEXCOORD_0")]
    pub(super) texcoord_0: Option<u32>,
    #[serde(rename = "TEXCOORD_1")]
    pub(super) texcoord_1: Option<u32>,
    #[serde(rename = "JOINTS_0")]
    pub(super) joints_0: Option<u32>,
    #[serde(rename = "WEIGHTS_0")]
    pub(super) weights_0: Option<u32>,
    #[serde(rename = "JOINTS_1")]
    pub(super) joints_1: Option<u32>,
    #[serde(rename = "WEIGHTS_1")]
    pub(super) weights_1: Option<u32>,
}

/// A morph target.
#[derive(Clone, Copy, Deserialize, PartialEq, Eq, Hash)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Target {
    pub(super) position: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) inverse_bind_matrices: Option<u32>,
    pub(super) joints: Vec<u32>,
}

#[derive(Deserialize)]
pub(super) struct Animation<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Text<'a>>,
    #[serde(borrow)]
    pub(super) channels: Vec<Channel<'a>>,
    #[serde(borrow)]
    pub(super) samplers: Vec<Sampler<'a>>,
}

#[derive(Deserialize)]
pub(super) struct Channel<'a> {
    pub(super) sampler: u32,
    #[serde(borrow)]
    pub(super) target: ChannelTarget<'a>,
}

/// What a channel moves.
#[derive(Deserialize)]
pub(super) struct ChannelTarget<'a> {
    pub(super) node: Option<u32>,
    #[serde(borrow)]
    pub(super) path: Text<'a>,
}

/// Times and values.
#[derive(Deserialize)]
pub(super) struct Sampler<'a> {
    pub(super) input: u32,
    pub(super) output: u32,
    /// LINEAR if not said.
    #[serde(borrow)]
    pub(super) interpolation: Option<Text<'a>>,
}

#[derive(Deserialize)]
pub(super) struct Camera<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Text<'a>>,
    pub(super) perspective: Option<Perspective>,
    pub(super) orthographic: Option<Orthographic>,
}

#[derive(Clone, Copy, Deserialize)]
pub(super) struct Perspective {
    /// Vertical, radians.
    pub(super) yfov: f32,
}

#[derive(Clone, Copy, Deserialize)]
pub(super) struct Orthographic {
    /// Half the height.
    pub(super) ymag: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<u32>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) shape: Shape,
    pub(super) sparse: Option<Box<Sparse>>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Shape {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    #[serde(borrow)]
    pub(super) uri: Option<Text<'a>>,
    pub(super) byte_length: u64,
}

/// A text that borrows from the file where it has no escapes.
pub(super) struct Text<'a>(pub(super) Cow<'a, str>);

impl<'de: 'a, 'a> Deserialize<'de> for Text<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TextVisitor<'a>(PhantomData<&'a ()>);
        impl<'de: 'a, 'a> Visitor<'de> for TextVisitor<'a> {
            type Value = Text<'a>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a text")
            }

            fn visit_borrowed_str<E: Error>(self, text: &'de str) -> Result<Text<'a>, E> {
                Ok(Text(Cow::Borrowed(text)))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Text<'a>, E> {
                Ok(Text(Cow::Owned(text.to_owned())))
            }
        }
        deserializer.deserialize_str(TextVisitor(PhantomData))
    }
}

/// Hands each item of a list to `take` as it is read, which may refuse it: the list itself takes no memory.
pub(super) fn each_item<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
    take: impl FnMut(T) -> Result<(), String>,
) -> Result<(), D::Error> {
    struct List<T, F>(PhantomData<T>, F);
    impl<'de, T: Deserialize<'de>, F: FnMut(T) -> Result<(), String>> Visitor<'de> for List<T, F> {
        type Value = ();

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
            while let Some(item) = list.next_element()? {
                self.1(item).map_err(A::Error::custom)?;
            }
            Ok(())
        }
    }
    deserializer.deserialize_seq(List(PhantomData, take))
}

/// A list of at most [`MOST_ITEMS`].
pub(super) fn limited<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    let mut items = Vec::new();
    each_item(deserializer, |item| {
        if items.len() == MOST_ITEMS {
            return Err(format!("a list of more than {MOST_ITEMS} items"));
        }
        items.push(item);
        Ok(())
    })?;
    Ok(items)
}

/// Parses the JSON of a file.
pub(super) fn parse<'a>(parts: &Parts<'a>) -> Result<Json<'a>, ReadErrorKind> {
    let json: Json = serde_json::from_slice(parts.json).map_err(|error| {
        // The lists of version 1 are objects: it must be told apart before its structure is complained of.
        if let Ok(Versioned { asset }) = serde_json::from_slice(parts.json)
            && !asset.is_readable()
        {
            return OTHER_VERSION;
        }
        let report = error.to_string();
        // The place stands before the reason in our messages, and quoted content may be long.
        let reason = report.split(" at line ").next().unwrap_or(&report);
        let reason: String = one_line(reason).chars().take(LONGEST_REPORT).collect();
        let reason = format!("JSON: {reason}");
        match parts.start {
            None => ReadErrorKind::at_line(error.line() as u64, reason),
            Some(start) => {
                let line = error.line().saturating_sub(1);
                let before: usize =
                    parts.json.split_inclusive(|&b| b == b'\n').take(line).map(<[u8]>::len).sum();
                ReadErrorKind::at_byte(start + before + error.column().saturating_sub(1), reason)
            }
        }
    })?;
    if json.asset.is_readable() { Ok(json) } else { Err(OTHER_VERSION) }
}

/// The least that every version has.
#[derive(Deserialize)]
struct Versioned<'a> {
    #[serde(borrow)]
    asset: Asset<'a>,
}

const OTHER_VERSION: ReadErrorKind = ReadErrorKind::NotReadYet("a glTF file of another version than 2");
