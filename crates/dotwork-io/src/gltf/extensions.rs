//! What a file needs beyond glTF 2.0.

use dotwork_drawing::Warnings;

use super::json::Json;
use crate::error::{ReadErrorKind, one_line};

/// Extensions that geometry can do without or is read with: quantization is read; the others say how a surface looks.
const HARMLESS: [&str; 9] = [
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "EXT_lights_image_based",
];

/// Refuses what the file cannot be drawn without, and says what is left out.
pub(super) fn check(json: &Json, warnings: &mut Warnings) -> Result<(), ReadErrorKind> {
    for extension in &json.extensions_required {
        let name = &*extension.0;
        if HARMLESS.contains(&name) || name.starts_with("KHR_materials_") {
            continue;
        }
        let what = match name {
            "KHR_draco_mesh_compression" => " (Draco compression)",
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => " (meshopt compression)",
            "EXT_mesh_gpu_instancing" => " (instances)",
            _ => "",
        };
        let name: String = one_line(name).chars().take(60).collect();
        return Err(ReadErrorKind::Extension(format!("{name}{what}")));
    }
    if json.extensions_used.iter().any(|e| e.0 == "EXT_mesh_gpu_instancing") {
        warnings.say("instances of EXT_mesh_gpu_instancing are not read: each such mesh is drawn once");
    }
    Ok(())
}
