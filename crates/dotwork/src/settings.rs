//! Settings that are put over those of a scene: by the options of a command, or by a scene file.

use dotwork_drawing::{Length, LightFrame, Page, UpAxis};
use dotwork_volume::Space;

use crate::scale_bar::ScaleBar;
use crate::scene::{Scene, Stipples, ZOOM};
use crate::timeline::Timeline;

/// What is to change of a scene's camera, light and page; what is `None` stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Where the eye is: `AZ,EL[,DIST]` or a name, as [`dotwork_drawing::Camera::set_direction`] reads them; the names
    /// of the patient's directions for volumes with an orientation.
    pub camera: Option<String>,
    /// Parallel projection.
    pub ortho: Option<bool>,
    /// Enlargement about the middle of the page.
    pub zoom: Option<f32>,
    /// Which axis points up.
    pub up: Option<UpAxis>,
    /// Azimuth and elevation of the light, degrees.
    pub light: Option<[f32; 2]>,
    /// What the light's angles start from.
    pub light_frame: Option<LightFrame>,
    /// Width and height of the page in pixels; [`Settings::paper_mm`] comes first.
    pub size_px: Option<[u32; 2]>,
    /// Width and height of the page in millimetres.
    pub paper_mm: Option<(f32, f32)>,
    /// Margin on all sides. One that is not asked for keeps its millimetres.
    pub margin: Option<Length>,
    /// Resolution, pixels an inch.
    pub dpi: Option<f32>,
    /// How many stipples are baked.
    pub stipples: Option<Stipples>,
    /// Seed of every random choice.
    pub seed: Option<u32>,
    /// A scale bar.
    pub scale_bar: Option<ScaleBar>,
    /// Diameters of the pens, millimetres.
    pub pens_mm: Option<Vec<f32>>,
    /// How camera and light move in a film.
    pub timeline: Option<Timeline>,
}

/// Why settings do not fit a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{setting}: {reason}")]
pub struct SettingsError {
    /// The setting: `camera`, `zoom`, `page` or `scale-bar`.
    pub setting: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

impl Settings {
    /// Puts these settings over those of `scene`. Without objects in it, what depends on them is not checked yet.
    ///
    /// # Errors
    /// A direction that this scene does not have, a zoom out of range, a page that cannot be drawn, a scale bar that
    /// does not fit the view; the scene is then partly changed.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), SettingsError> {
        let wrong = |setting| move |reason: String| SettingsError { setting, reason };
        let space = scene.world().space;
        let camera = &mut scene.camera;
        camera.ortho = self.ortho.unwrap_or(camera.ortho);
        camera.zoom = self.zoom.unwrap_or(camera.zoom);
        if !(ZOOM.0..=ZOOM.1).contains(&camera.zoom) {
            return Err(wrong("zoom")(format!("takes a number from {} to {}", ZOOM.0, ZOOM.1)));
        }
        camera.up = self.up.unwrap_or(camera.up);
        if let Some(direction) = &self.camera {
            if space == Space::Patient && camera.up == UpAxis::Z {
                camera.set_patient_direction(direction).map_err(wrong("camera"))?;
            } else if let Err(reason) = camera.set_direction(direction) {
                // Only the patient's directions wait for a scene that has them.
                let mut patient = *camera;
                patient.set_patient_direction(direction).map_err(|_| wrong("camera")(reason))?;
                if !scene.objects.is_empty() {
                    let reason =
                        format!("{direction} needs a volume that declares its orientation, and z up");
                    return Err(wrong("camera")(reason));
                }
            }
        }
        if let Some([azimuth, elevation]) = self.light {
            (scene.light.azimuth, scene.light.elevation) = (azimuth, elevation);
        }
        scene.light.frame = self.light_frame.unwrap_or(scene.light.frame);
        scene.seed = self.seed.unwrap_or(scene.seed);
        scene.stipples = self.stipples.unwrap_or(scene.stipples);
        scene.page = self.page(scene.page).map_err(wrong("page"))?;
        if let Some(bar) = self.scale_bar {
            scene.scale_bar = Some(bar);
        }
        if let Some(pens) = &self.pens_mm {
            scene.pens = pens.clone();
            scene.pens.sort_by(f32::total_cmp);
            scene.pens.dedup();
        }
        if let Some(timeline) = &self.timeline {
            scene.timeline = timeline.clone();
        }
        // Before there are objects nothing is known of the view.
        if !scene.objects.is_empty() {
            scene.scale_bar_strokes().map_err(wrong("scale-bar"))?;
        }
        Ok(())
    }

    /// The page asked for, over the page there is.
    fn page(&self, old: Page) -> Result<Page, String> {
        let dpi = self.dpi.unwrap_or(old.dpi);
        let margin = self.margin.unwrap_or(Length::mm(old.margin_px * old.mm_per_px()));
        let mut page = match (self.paper_mm, self.size_px) {
            (Some((width, height)), _) => Page::millimetres(width, height, dpi)?,
            (None, Some([width, height])) => Page { dpi, ..Page::pixels(width, height)? },
            (None, None) => Page { dpi, margin_px: 0.0, ..old },
        };
        // An old margin in pixels that did not change stays exactly as it was.
        let unchanged = self.margin.is_none() && dpi == old.dpi;
        page.margin_px = if unchanged { old.margin_px } else { margin.to_px(&page) };
        page.checked()
    }
}
