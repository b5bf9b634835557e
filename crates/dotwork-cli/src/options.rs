//! What the options mean for a style and for a scene.

use std::path::Path;

use dotwork::ink::PRESETS;
use dotwork::{LoadOptions, Pose, Scene, Settings, Stipples, Style, UpAxis, preset, read_style};

use crate::args::{BakeMethod, InputArgs, PoseArgs, SceneArgs, StyleArgs};
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
        let load = args.input.load();
        let options = Options { args, style, load };
        options.apply(&mut Scene::default())?;
        Ok(options)
    }

    /// As [`Options::new`], with a pose of what moves.
    pub fn with_pose(args: &'a SceneArgs, pose: &PoseArgs) -> Result<Options<'a>, Failure> {
        let mut options = Options::new(args)?;
        if pose.clip.is_some() || pose.time.is_some() {
            let time = Some(pose.time.unwrap_or(0.0));
            options.load.pose = Some(Pose { clip: pose.clip.clone(), time });
        }
        Ok(options)
    }

    /// Refuses a pose that nothing in the scene can take.
    pub fn check_pose(&self, scene: &Scene) -> Result<(), Failure> {
        let posed = scene.objects.iter().any(|o| o.source.as_ref().is_some_and(|s| s.pose.is_some()));
        if self.load.pose.is_some() && !posed {
            return Err(Failure::Run("--clip and --time: no input has an animation".into()));
        }
        Ok(())
    }

    /// The style of an object whose own style is `own`.
    pub fn style(&self, own: &Style) -> Style {
        let mut style = self.style.as_ref().unwrap_or(own).clone();
        self.finish(&mut style);
        style
    }

    /// Puts camera, light, page, seed and stipples into a scene, over what it has.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Failure> {
        let args = self.args;
        let settings = Settings {
            camera: args.camera.clone(),
            ortho: args.ortho.then_some(true),
            zoom: args.zoom,
            up: args.up,
            light: args.light.map(|l| [l.azimuth, l.elevation]),
            light_frame: args.light_frame,
            size_px: args.size,
            paper_mm: args.page,
            margin: args.margin,
            dpi: args.dpi,
            stipples: args.stipples,
            seed: args.seed,
            scale_bar: args.scale_bar,
            timeline: None,
            pens_mm: if args.pen.is_some() {
                Some(Vec::new())
            } else {
                Some(args.pens.clone()).filter(|pens| !pens.is_empty())
            },
        };
        settings.apply(scene).map_err(|e| Failure::Usage(format!("--{}: {}", e.setting, e.reason)))
    }

    /// The style that takes the place of those that a scene's objects name, if one is asked for.
    pub fn base(&self) -> Option<&Style> {
        self.style.as_ref()
    }

    /// Puts what options say of single keys over a style.
    pub fn finish(&self, style: &mut Style) {
        set_keys(style, &self.args.style);
        if let Some(pen) = self.args.pen {
            style.use_pen(pen);
        }
        if let Some(paper) = self.args.paper {
            style.paper = paper;
        }
        match self.args.bake {
            Some(BakeMethod::BlueNoise) => style.bake = dotwork::ink::BakeMethod::BlueNoise,
            Some(BakeMethod::Voxel) => style.bake = dotwork::ink::BakeMethod::Voxel,
            Some(BakeMethod::Face) => style.bake = dotwork::ink::BakeMethod::Face,
            Some(BakeMethod::Hierarchy) => style.bake = dotwork::ink::BakeMethod::Hierarchy,
            None => {}
        }
    }

    /// Whether an option says who makes the order of the stipples.
    pub fn asks_bake(&self) -> bool {
        self.args.bake.is_some() || self.args.style.set.iter().any(|set| set.trim_start().starts_with("bake"))
    }

    /// How inputs are read.
    pub fn load(&self) -> &LoadOptions {
        &self.load
    }

    /// The value at which volumes have their surface.
    pub fn iso(&self) -> Option<f64> {
        self.args.input.iso
    }

    /// The axis that points up, if one is asked for.
    pub fn up(&self) -> Option<UpAxis> {
        self.args.up
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

impl InputArgs {
    /// How inputs are read.
    pub fn load(&self) -> LoadOptions {
        let (transfer, transfer_name) = match self.transfer.as_deref() {
            None => (None, None),
            Some(text) => match text.rsplit_once('#') {
                // A file may have that character in its name.
                Some((file, name)) if !Path::new(text).exists() => (Some(file.into()), Some(name.into())),
                _ => (Some(text.into()), None),
            },
        };
        LoadOptions {
            raw: self.raw.clone(),
            series: self.series.clone(),
            labels: self.labels.clone(),
            label: None,
            transfer,
            transfer_name,
            ..LoadOptions::default()
        }
    }
}

/// The style that `--style` and `--set` ask for; without them the default one.
pub fn chosen_style(args: &StyleArgs) -> Result<Style, Failure> {
    chosen_style_over(args, Style::default())
}

/// The style that `--style` and `--set` ask for; `own`, if `--style` names none.
pub fn chosen_style_over(args: &StyleArgs, own: Style) -> Result<Style, Failure> {
    let mut style = named_style(args)?.unwrap_or(own);
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
