//! From inputs and options to a scene.

use std::path::{Path, PathBuf};

use dotwork::{Loaded, Object, Plate, Scene, Style, Warnings, load_with};

use crate::options::Options;
use crate::report::{Failure, Report};

/// Reads all inputs into one scene. A `.dots` file that is the only input brings its camera, light and page too.
pub fn open(inputs: &[PathBuf], options: &Options, report: &mut Report) -> Result<Scene, Failure> {
    let mut scene = Scene::default();
    for input in inputs {
        let mut warnings = Warnings::new();
        match load_with(input, options.load(), &mut warnings)? {
            Loaded::Plate(plate) if inputs.len() == 1 => {
                scene = redraw(*plate, options, &mut warnings, report)?;
            }
            Loaded::Plate(_) => {
                let input = input.display();
                return Err(Failure::Usage(format!(
                    "{input}: a plate is drawn again alone, without other inputs"
                )));
            }
            loaded @ (Loaded::Mesh(_) | Loaded::Volume(_)) => {
                let mesh = loaded.into_mesh(options.iso(), &mut warnings)?;
                if scene.objects.is_empty() {
                    mesh.turn_camera(&mut scene);
                }
                scene.add(mesh.into_object(options.style(&Style::default()), &mut warnings)?);
            }
            Loaded::Scene(mut baked) => {
                check_bake(input, &baked, options)?;
                for mut object in std::mem::take(&mut baked.objects) {
                    restyle(input, &mut object, options, &mut warnings)?;
                    scene.add(object);
                }
                if inputs.len() == 1 {
                    scene = Scene { objects: scene.objects, ..*baked };
                }
            }
        }
        report.warn(Some(input), &warnings);
    }
    options.apply(&mut scene)?;
    Ok(scene)
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
        object.restyle(style).map_err(|e| Failure::Run(e.to_string()))?;
    }
    options.apply(&mut scene)?;
    let same = (scene.camera, scene.page, scene.seed, scene.stipples)
        == (drawn.camera, drawn.page, drawn.seed, drawn.stipples)
        && scene.objects.iter().zip(&drawn.objects).all(|(a, b)| a.style == b.style);
    if same {
        report.progress("baking", |progress| scene.bake_counts(&counts, progress));
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

/// Puts the options' style over a baked object's own. The stipples keep the regularity that they were baked with.
fn restyle(
    input: &Path,
    object: &mut Object,
    options: &Options,
    warnings: &mut Warnings,
) -> Result<(), Failure> {
    let mut style = options.style(&object.style);
    let (baked, wanted) = (object.style.regularity, style.regularity);
    if wanted != baked {
        warnings.say(format!(
            "was baked with regularity {baked} and keeps it; {wanted} needs another dotwork bake"
        ));
        style.regularity = baked;
    }
    object.restyle(style).map_err(|e| Failure::Run(format!("{}: {e}", input.display())))
}
