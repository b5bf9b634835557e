//! What a glTF file holds besides the mesh that is read from it: for people who ask what is in a file.

use dotwork_drawing::Warnings;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny};

use super::container;
use super::json::{each_item, limited};
use crate::error::one_line;

/// Names and numbers shown of a list at most.
const SHOWN: usize = 12;

/// Characters shown of a name, and of a longer text.
const NAME: usize = 60;
const TEXT: usize = 120;

/// The JSON as far as it is counted. Values that do not matter take no memory.
#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
struct Counted {
    asset: Asset,
    scenes: Vec<IgnoredAny>,
    nodes: Vec<IgnoredAny>,
    #[serde(deserialize_with = "limited")]
    meshes: Vec<Mesh>,
    materials: Vec<IgnoredAny>,
    images: Vec<IgnoredAny>,
    cameras: Vec<IgnoredAny>,
    skins: Beginning<Skin>,
    animations: Beginning<Animation>,
    #[serde(deserialize_with = "limited")]
    accessors: Vec<Accessor>,
    extensions_used: Beginning<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Asset {
    version: String,
    generator: String,
    copyright: String,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Mesh {
    primitives: Primitives,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Primitive {
    targets: Vec<IgnoredAny>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Skin {
    joints: Vec<IgnoredAny>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Animation {
    name: String,
    #[serde(deserialize_with = "limited")]
    samplers: Vec<Sampler>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Sampler {
    input: usize,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Accessor {
    max: Beginning<f64>,
}

/// The first items of a list, and how many it has: what is not shown takes no memory.
struct Beginning<T> {
    items: Vec<T>,
    count: usize,
}

impl<T> Default for Beginning<T> {
    fn default() -> Self {
        Beginning { items: Vec::new(), count: 0 }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Beginning<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut list = Beginning::default();
        each_item(deserializer, |item| {
            if list.count < SHOWN {
                list.items.push(item);
            }
            list.count += 1;
            Ok(())
        })?;
        Ok(list)
    }
}

/// How many primitives a mesh has, and the most morph targets of any: a small file may have millions.
#[derive(Default)]
struct Primitives {
    count: usize,
    targets: usize,
}

impl<'de> Deserialize<'de> for Primitives {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut primitives = Primitives::default();
        each_item(deserializer, |primitive: Primitive| {
            primitives.count += 1;
            primitives.targets = primitives.targets.max(primitive.targets.len());
            Ok(())
        })?;
        Ok(primitives)
    }
}

impl<T> Beginning<T> {
    /// The items in words, and how many more there are.
    fn listed(&self, words: impl Fn((usize, &T)) -> String) -> String {
        let mut text = self.items.iter().enumerate().map(words).collect::<Vec<_>>().join(", ");
        if self.count > self.items.len() {
            text += &format!(", and {} more", self.count - self.items.len());
        }
        text
    }
}

/// Names and values, for people; nothing if the JSON is not that of a glTF file.
pub(crate) fn facts(bytes: &[u8]) -> Vec<(String, String)> {
    let parts = container::split(bytes, &mut Warnings::new()).ok();
    let counted = parts.and_then(|parts| serde_json::from_slice::<Counted>(parts.json).ok());
    let Some(counted) = counted else { return Vec::new() };
    let mut facts = Vec::new();
    let mut fact = |name: &str, value: String| {
        if !value.is_empty() {
            facts.push((name.to_string(), one_line(&value)));
        }
    };
    let start = |text: &str, length| text.chars().take(length).collect::<String>();
    let Asset { version, generator, copyright } = &counted.asset;
    fact("version", start(version, NAME));
    fact("made by", start(generator, TEXT));
    fact("copyright", start(copyright, TEXT));
    let primitives: usize = counted.meshes.iter().map(|m| m.primitives.count).sum();
    let count = |n: usize, one: &str, many: &str| match n {
        0 => None,
        1 => Some(format!("1 {one}")),
        n => Some(format!("{n} {many}")),
    };
    let parts = [
        count(counted.scenes.len(), "scene", "scenes"),
        count(counted.nodes.len(), "node", "nodes"),
        count(counted.meshes.len(), "mesh", "meshes"),
        count(primitives, "primitive", "primitives"),
        count(counted.materials.len(), "material", "materials"),
        count(counted.images.len(), "image", "images"),
        count(counted.cameras.len(), "camera", "cameras"),
    ];
    fact("contents", parts.into_iter().flatten().collect::<Vec<_>>().join(", "));
    let joints = |n: usize| count(n, "joint", "joints").unwrap_or_else(|| "no joints".into());
    fact("skins", counted.skins.listed(|(_, skin)| joints(skin.joints.len())));
    let targets = counted.meshes.iter().map(|m| m.primitives.targets).max();
    fact("morph targets", targets.filter(|&n| n > 0).map_or(String::new(), |n| n.to_string()));
    let seconds = |animation: &Animation| {
        let end = |s: &Sampler| counted.accessors.get(s.input)?.max.items.first().copied();
        animation.samplers.iter().filter_map(end).filter(|t| t.is_finite()).fold(0.0, f64::max)
    };
    let animation = |(k, animation): (usize, &Animation)| {
        let name = if animation.name.is_empty() { k.to_string() } else { start(&animation.name, NAME) };
        format!("{name} ({:.3} s)", seconds(animation))
    };
    fact("animations", counted.animations.listed(animation));
    fact("extensions", counted.extensions_used.listed(|(_, name)| start(name, NAME)));
    facts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_counted() {
        let json =
            br#"{"asset":{"version":"2.0","generator":"a\nb"},"nodes":[{},{}],"skins":[{"joints":[0,1]}],
            "meshes":[{"primitives":[{"targets":[{},{}]}]}],
            "accessors":[{},{"max":[2.5]}],"animations":[{"name":"Walk","samplers":[{"input":1}]},{}]}"#;
        let facts = facts(json);
        let value = |name: &str| facts.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str());
        assert_eq!(value("contents"), Some("2 nodes, 1 mesh, 1 primitive"));
        assert_eq!(value("made by"), Some("a\\nb"));
        assert_eq!(value("skins"), Some("2 joints"));
        assert_eq!(value("morph targets"), Some("2"));
        assert_eq!(value("animations"), Some("Walk (2.500 s), 1 (0.000 s)"));
        assert_eq!(value("extensions"), None);
    }

    #[test]
    fn long_lists_and_names_are_shortened() {
        let many = |item: &str| vec![item; 100].join(",");
        let json = format!(
            r#"{{"asset":{{"version":"2.{0}"}},"extensionsUsed":["{0}",{1}],"animations":[{2}],
            "skins":[{{"joints":[1]}},{2}],"accessors":[{{"max":[{3}]}}]}}"#,
            "x".repeat(5000),
            many("\"a\""),
            many("{}"),
            many("1"),
        );
        let facts = facts(json.as_bytes());
        assert_eq!(facts.len(), 4);
        assert!(facts.iter().all(|(_, value)| value.len() < 300), "{facts:?}");
        let value = |name: &str| facts.iter().find(|(n, _)| n == name).unwrap().1.as_str();
        assert!(value("skins").starts_with("1 joint, no joints, "));
        assert!(value("skins").ends_with(", and 89 more"));
        assert!(value("animations").ends_with("11 (0.000 s), and 88 more"));
    }

    #[test]
    fn anything_else_has_no_facts() {
        for bytes in [&b""[..], b"{", b"[]", b"{\"nodes\":3}", b"glTF", b"\xff\xfe"] {
            assert!(facts(bytes).is_empty());
        }
    }
}
