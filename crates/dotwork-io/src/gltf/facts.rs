//! What a glTF file holds besides the mesh that is read from it: for people who ask what is in a file.

use dotwork_drawing::Warnings;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::container;
use crate::error::one_line;

/// Names and numbers shown of a list at most.
const SHOWN: usize = 12;

/// The JSON as far as it is counted. Values that do not matter take no memory.
#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
struct Counted {
    asset: Asset,
    scenes: Vec<IgnoredAny>,
    nodes: Vec<IgnoredAny>,
    meshes: Vec<Mesh>,
    materials: Vec<IgnoredAny>,
    images: Vec<IgnoredAny>,
    cameras: Vec<IgnoredAny>,
    skins: Vec<Skin>,
    animations: Vec<Animation>,
    accessors: Vec<Accessor>,
    extensions_used: Vec<String>,
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
    primitives: Vec<Primitive>,
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
    max: Option<Vec<f64>>,
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
    let Asset { version, generator, copyright } = &counted.asset;
    fact("version", version.clone());
    fact("made by", generator.chars().take(120).collect());
    fact("copyright", copyright.chars().take(120).collect());
    let primitives: usize = counted.meshes.iter().map(|m| m.primitives.len()).sum();
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
    let joints: Vec<String> = counted.skins.iter().map(|s| format!("{} joints", s.joints.len())).collect();
    fact("skins", listed(&joints));
    let targets = counted.meshes.iter().flat_map(|m| &m.primitives).map(|p| p.targets.len()).max();
    fact("morph targets", targets.filter(|&n| n > 0).map_or(String::new(), |n| n.to_string()));
    let animations: Vec<String> = counted
        .animations
        .iter()
        .enumerate()
        .map(|(k, animation)| {
            let name = if animation.name.is_empty() { k.to_string() } else { animation.name.clone() };
            let ends = animation.samplers.iter().filter_map(|s| {
                counted.accessors.get(s.input)?.max.as_ref()?.first().copied().filter(|t| t.is_finite())
            });
            format!("{} ({:.3} s)", name.chars().take(60).collect::<String>(), ends.fold(0.0, f64::max))
        })
        .collect();
    fact("animations", listed(&animations));
    fact("extensions", listed(&counted.extensions_used));
    facts
}

fn listed(items: &[String]) -> String {
    let mut text = items.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    if items.len() > SHOWN {
        text += &format!(", and {} more", items.len() - SHOWN);
    }
    text
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
    fn anything_else_has_no_facts() {
        for bytes in [&b""[..], b"{", b"[]", b"{\"nodes\":3}", b"glTF", b"\xff\xfe"] {
            assert!(facts(bytes).is_empty());
        }
    }
}
