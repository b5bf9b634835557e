//! What the options mean for a style and for a scene.

use dotwork::drawing::{Page, UpAxis};
use dotwork::ink::PRESETS;
use dotwork::volume::Space;
use dotwork::{Length, LoadOptions, Scene, Stipples, Style, preset, read_style};

use crate::args::{BakeMethod, SceneArgs, StyleArgs};
use crate::report::Failure;

/// Options checked: the style is read, the page can be drawn.
pub struct Options<'a> {
    args: &'a SceneArgs,
    /// The style asked for by `--style`.
    style: Option<Style>,
    /// How inputs are read.
    load: LoadOptions,
}

impl<'a> Options<'a> {
    /// Checks everything that can be checked before an input is read.
    pub fn new(args: &'a SceneArgs) -> Result<Options<'a>, Failure> {
        let style = named_style(&args.style)?;
        let load = LoadOptions { raw: args.input.raw.clone(), series: args.input.series.clone() };
        let options = Options { args, style, load };
        options.apply(&mut Scene::default())?;
        Ok(options)
    }

    /// The style of an object whose own style is `own`.
    pub fn style(&self, own: &Style) -> Style {
        let mut style = self.style.as_ref().unwrap_or(own).clone();
        set_keys(&mut style, &self.args.style);
        if let Some(pen) = self.args.pen {
            style.use_pen(pen);
        }
        if let Some(paper) = self.args.paper {
            style.paper = paper;
        }
        match self.args.bake {
            Some(BakeMethod::BlueNoise) => style.bake = dotwork::ink::BakeMethod::BlueNoise,
            Some(BakeMethod::Voxel) => style.bake = dotwork::ink::BakeMethod::Voxel,
            None => {}
        }
        style
    }

    /// Puts camera, light, page, seed and stipples into a scene, over what it has.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        let args = self.args;
        let space = scene.world().space;
        let camera = &mut scene.camera;
        camera.ortho |= args.ortho;
        camera.zoom = args.zoom.unwrap_or(camera.zoom);
        camera.up = args.up.unwrap_or(camera.up);
        if let Some(direction) = &args.camera {
            // Checked when it was parsed; only the patient's directions may not fit this scene.
            if space == Space::Patient && camera.up == UpAxis::Z {
                camera.set_patient_direction(direction).map_err(Failure::Usage)?;
            } else if camera.set_direction(direction).is_err() && !scene.objects.is_empty() {
                return Err(Failure::Usage(format!(
                    "--camera {direction} needs a volume that declares its orientation, and z up"
                )));
            }
        }
        if let Some(l) = args.light {
            (scene.light.azimuth, scene.light.elevation) = (l.azimuth, l.elevation);
        }
        scene.light.frame = args.light_frame.unwrap_or(scene.light.frame);
        scene.seed = args.seed.unwrap_or(scene.seed);
        scene.stipples = args.stipples.unwrap_or(scene.stipples);
        scene.page = self.page(scene.page).map_err(Failure::Usage)?;
        if let Some(bar) = args.scale_bar {
            scene.scale_bar = Some(bar);
        }
        if !args.pens.is_empty() {
            scene.pens = args.pens.clone();
            scene.pens.sort_by(f32::total_cmp);
            scene.pens.dedup();
        }
        if args.pen.is_some() {
            scene.pens.clear();
        }
        // Before an input is read nothing is known of its size and, for plates, of its view.
        if !scene.objects.is_empty() {
            scene.scale_bar_strokes().map_err(|e| Failure::Usage(format!("--scale-bar: {e}")))?;
        }
        Ok(())
    }

    /// The page asked for, over the page there is. A margin that is not asked for keeps its millimetres.
    fn page(&self, old: Page) -> Result<Page, String> {
        let args = self.args;
        let dpi = args.dpi.unwrap_or(old.dpi);
        let margin = args.margin.unwrap_or(Length::mm(old.margin_px * old.mm_per_px()));
        let mut page = match (args.page, args.size) {
            (Some((width, height)), _) => Page::millimetres(width, height, dpi)?,
            (None, Some([width, height])) => Page { dpi, ..Page::pixels(width, height)? },
            (None, None) => Page { dpi, margin_px: 0.0, ..old },
        };
        // An old margin in pixels that did not change stays exactly as it was.
        let unchanged = args.margin.is_none() && dpi == old.dpi;
        page.margin_px = if unchanged { old.margin_px } else { margin.to_px(&page) };
        page.checked()
    }

    /// How inputs are read.
    pub fn load(&self) -> &LoadOptions {
        &self.load
    }

    /// The value at which volumes have their surface.
    pub fn iso(&self) -> Option<f64> {
        self.args.input.iso
    }

    /// The seed, if one is asked for.
    pub fn seed(&self) -> Option<u32> {
        self.args.seed
    }

    /// The number of stipples, if one is asked for.
    pub fn stipples(&self) -> Option<Stipples> {
        self.args.stipples
    }
}

/// The style that `--style` and `--set` ask for; without them the default one.
pub fn chosen_style(args: &StyleArgs) -> Result<Style, Failure> {
    let mut style = named_style(args)?.unwrap_or_default();
    set_keys(&mut style, args);
    Ok(style)
}

fn named_style(args: &StyleArgs) -> Result<Option<Style>, Failure> {
    args.style.as_deref().map(style_by_name).transpose()
}

fn set_keys(style: &mut Style, args: &StyleArgs) {
    for pair in &args.set {
        // Checked when it was parsed.
        let _ = style.set_pair(pair);
    }
}

/// The style with this name, or in this file.
pub fn style_by_name(name: &str) -> Result<Style, Failure> {
    if let Some(style) = preset(name) {
        return Ok(style);
    }
    if name.to_ascii_lowercase().ends_with(".toml") {
        return Ok(read_style(name)?.style);
    }
    let names: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
    let names = names.join(", ");
    Err(Failure::Usage(format!(
        "there is no style '{name}'; the styles are {names}, or a style file FILE.toml"
    )))
}
