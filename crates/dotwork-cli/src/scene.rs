//! From inputs and options to a scene.

use std::path::{Path, PathBuf};

use dotwork::ink::{BakeMethod, PARAMS};
use dotwork::{LoadOptions, Loaded, Object, Plate, Scene, Style, Warnings, load_with};

use crate::options::Options;
use crate::output;
use crate::report::{Failure, Report};

/// Keys that say what of a volume becomes a surface: a bake holds the surface.
const OF_VOLUMES: [&str; 7] = ["feature", "surface", "window", "smooth", "cap", "keep", "crop"];

/// Reads all inputs into one scene, which is to become `output`. A `.dots` file that is the only input brings its
/// camera, light and page too; beside others it brings its seed, which is that of its stipples.
pub fn open(
    inputs: &[PathBuf],
    output: &Path,
    options: &Options,
    report: &mut Report,
) -> Result<Scene, Failure> {
    let mut scene = Scene::default();
    let mut seed = None;
    let load = LoadOptions { watch: report.watch(), ..options.load().clone() };
    for input in inputs {
        let mut warnings = Warnings::new();
        match load_with(input, &load, &mut warnings)? {
            Loaded::Plate(plate) if inputs.len() == 1 => {
                // What it was drawn from is an input too.
                output::keep(&plate.inputs(), output)?;
                scene = redraw(*plate, options, &mut warnings, report)?;
            }
            Loaded::Plate(_) => {
                let input = input.display();
                return Err(Failure::Usage(format!(
                    "{input}: a plate is drawn again alone, without other inputs"
                )));
            }
            Loaded::SceneFile(file) if inputs.len() == 1 => {
                output::keep(&file.inputs(), output)?;
                let (made, notes) =
                    file.scene(options.base(), &|style| options.finish(style), &mut warnings)?;
                for note in notes {
                    report.summary(&format!("{}: {note}", input.display()));
                }
                scene = made;
            }
            Loaded::SceneFile(_) => {
                let input = input.display();
                return Err(Failure::Usage(format!(
                    "{input}: a scene file is drawn alone, without other inputs; it may include others"
                )));
            }
            loaded @ (Loaded::Mesh(_) | Loaded::Volume(_)) => {
                let style = options.style(&Style::default());
                for mesh in loaded.into_meshes(&style, options.iso(), &mut warnings)? {
                    for note in &mesh.notes {
                        report.summary(&format!("{}: {note}", input.display()));
                    }
                    if scene.objects.is_empty() {
                        mesh.turn_camera(&style, options.up(), &mut scene);
                    }
                    let style = mesh.style(style.clone());
                    let object = mesh.into_object(style, &mut warnings)?;
                    add(&mut scene, object, &mut warnings);
                }
            }
            Loaded::Scene { scene: mut baked, .. } => {
                check_bake(input, &baked, options)?;
                for mut object in std::mem::take(&mut baked.objects) {
                    restyle(input, &mut object, options, &mut warnings)?;
                    add(&mut scene, object, &mut warnings);
                }
                if inputs.len() == 1 {
                    scene = Scene { objects: scene.objects, ..*baked };
                } else {
                    scene.seed = *seed.get_or_insert(baked.seed);
                    if scene.seed != baked.seed {
                        warnings.say(format!(
                            "was baked with seed {}, an input before it with {}; a plate holds only the latter",
                            baked.seed, scene.seed
                        ));
                    }
                }
            }
        }
        report.warn(Some(input), &warnings);
    }
    report.rest();
    options.apply(&mut scene)?;
    Ok(scene)
}

/// Adds an object, and says so if it cannot lie where it should.
fn add(scene: &mut Scene, object: Object, warnings: &mut Warnings) {
    if !scene.add(object) {
        warnings.say("lies so far from the first input that it is drawn about its own middle instead");
    }
}

/// The scene of a plate: baked as it was drawn, unless options change what has to be baked.
fn redraw(
    plate: Plate,
    options: &Options,
    warnings: &mut Warnings,
    report: &Report,
) -> Result<Scene, Failure> {
    let (mut scene, counts) = plate.unbaked(warnings)?;
    let drawn = scene.clone();
    for object in &mut scene.objects {
        let style = options.style(&object.style);
        object.restyle(style).map_err(|e| Failure::Run(format!("{}: {e}", object.name)))?;
    }
    options.apply(&mut scene)?;
    let same = (scene.camera, scene.light, scene.page, scene.seed, scene.stipples)
        == (drawn.camera, drawn.light, drawn.page, drawn.seed, drawn.stipples)
        && scene.objects.iter().zip(&drawn.objects).all(|(a, b)| a.style == b.style);
    if same {
        report.progress("stipples", |progress| scene.bake_counts(&counts, progress));
    }
    Ok(scene)
}

/// Refuses options that would need another bake.
fn check_bake(input: &Path, baked: &Scene, options: &Options) -> Result<(), Failure> {
    let refuse = |what: String, option: String| {
        let input = input.display();
        Err(Failure::Run(format!("{input}: was baked with {what}; {option} needs another dotwork bake")))
    };
    if let Some(seed) = options.seed().filter(|&s| s != baked.seed) {
        return refuse(format!("seed {}", baked.seed), format!("--seed {seed}"));
    }
    if let Some(n) = options.stipples().filter(|&n| n != baked.stipples) {
        return refuse(format!("{} stipples", baked.stipples), format!("--stipples {n}"));
    }
    Ok(())
}

/// Puts the options' style over a baked object's own. The stipples keep the regularity that they were baked with, and
/// those of a hierarchy, or that are to become one, who made them.
fn restyle(
    input: &Path,
    object: &mut Object,
    options: &Options,
    warnings: &mut Warnings,
) -> Result<(), Failure> {
    let mut style = options.style(&object.style);
    let of_volume = object.source.as_ref().is_some_and(|source| source.iso.is_some());
    let (mut baked, mut wanted) = (Vec::new(), Vec::new());
    let hierarchy = [object.style.bake, style.bake].contains(&BakeMethod::Hierarchy);
    let shapes = |name| {
        OF_VOLUMES.contains(&name)
            || ["clip", "regularity"].contains(&name)
            || hierarchy && ["bake", "randomize"].contains(&name)
    };
    for param in PARAMS.iter().filter(|p| shapes(p.name)) {
        let (old, new) = (param.get(&object.style), param.get(&style));
        if new == old {
            continue;
        }
        // Another style brings the defaults of all that it says nothing about.
        let asked = param.name == "regularity"
            || param.name == "bake" && options.asks_bake()
            || new != param.default();
        if asked && (of_volume || !OF_VOLUMES.contains(&param.name)) {
            baked.push(format!("{} {old}", param.name));
            wanted.push(format!("{} {new}", param.name));
        }
        style.set(param.name, &old).map_err(Failure::Run)?;
    }
    if !baked.is_empty() {
        let (baked, wanted) = (baked.join(", "), wanted.join(", "));
        warnings.say(format!("was baked with {baked} and keeps it; {wanted} needs another dotwork bake"));
    }
    object.restyle(style).map_err(|e| Failure::Run(format!("{}: {e}", input.display())))
}
