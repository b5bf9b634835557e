//! Films: what a scene is at each frame.
//!
//! A film is a number of frames at a rate; frame `n` shows the scene at `n / fps` seconds. What may move: objects, by the
//! animations of their files; camera and light, by the [`Timeline`] of the scene; the camera on a turntable; or it is a
//! camera of a file. [`Film::set_up`] prepares a scene for all frames at once: stipples for the largest area that each
//! surface reaches and the densest tones of any frame, and one sphere that the camera fits, so that nothing breathes.

use std::ops::Range;

use glam::{DVec3, Vec3};

use crate::moving::Density;
use crate::scene::Scene;

/// Most frames of a film.
pub const MAX_FRAMES: u32 = 1_000_000;

/// Moments that a scene is judged at before it is baked.
const JUDGED: usize = 12;

/// Times at which the extent of what moves is taken.
const MEASURED: usize = 240;

/// What is asked of a film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmOptions {
    /// Frames a second; `None`: 24.
    pub fps: Option<f64>,
    /// The frames that are drawn; `None`: all of the turntable, the longest animation or the timeline.
    pub frames: Option<Range<u32>>,
    /// Frames for which a drawing is held; 0 counts as 1.
    pub hold: u32,
    /// The camera goes once round in this many frames.
    pub turntable: Option<u32>,
    /// The animation that objects play, by its name or number; `None`: their first, but none on a turntable.
    pub clip: Option<String>,
    /// The camera of a file through which the scene is seen, by its name or number; the empty name is the first.
    pub camera: Option<String>,
}

/// A film of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    fps: f64,
    frames: Range<u32>,
    hold: u32,
    turntable: Option<u32>,
    /// Objects move.
    plays: bool,
    /// The object and its camera through which the scene is seen.
    camera: Option<(usize, usize)>,
}

impl Film {
    /// The film that is asked for, of a scene that is not set up yet: its objects begin to play.
    ///
    /// # Errors
    /// Nothing moves; an animation or a camera that no object has, with those that there are; numbers out of range.
    pub fn new(options: &FilmOptions, scene: &mut Scene) -> Result<Film, String> {
        let fps = options.fps.unwrap_or(24.0);
        if !(0.01..=1000.0).contains(&fps) {
            return Err(format!("{fps} frames a second; from 0.01 to 1000 can be drawn"));
        }
        let plays = options.clip.is_some() || options.turntable.is_none();
        let mut seconds = 0f64;
        let mut playing = false;
        let mut refused = None;
        for object in scene.objects.iter_mut().filter(|_| plays) {
            let Some(moving) = &object.moving else { continue };
            // A scene file says which of an object's animations is meant.
            let own = object.source.as_ref().and_then(|s| s.pose.as_ref()?.clip.as_ref());
            let clip = match options.clip.as_ref().or(own) {
                Some(name) => moving.find(name),
                None if moving.motion().clips().is_empty() => continue,
                None => Ok(0),
            };
            match clip {
                Ok(clip) => {
                    object.play(Some(clip), None).map_err(|e| format!("{}: {e}", object.name))?;
                    seconds = seconds.max(object.moving.as_ref().map_or(0.0, |m| m.seconds()));
                    playing = true;
                }
                Err(reason) => {
                    refused.get_or_insert(format!("{}: {reason}", object.name));
                }
            }
        }
        if let (Some(name), false) = (&options.clip, playing) {
            let nothing = || format!("there is no animation '{name}': nothing in the scene has any");
            return Err(refused.unwrap_or_else(nothing));
        }
        let camera = options.camera.as_ref().map(|name| find_camera(scene, name)).transpose()?;
        let seconds = seconds.max(scene.timeline.end());
        let all = match options.turntable {
            Some(0) => return Err("a turntable of 0 frames".into()),
            Some(n) => n,
            None => (seconds * fps).round().clamp(1.0, f64::from(MAX_FRAMES)) as u32,
        };
        let moves = playing || options.turntable.is_some() || !scene.timeline.is_empty() || camera.is_some();
        if !moves && options.frames.is_none() {
            return Err(
                "nothing moves: no input has an animation, and neither --turntable nor keys of camera or \
                        light in a scene file are given"
                    .into(),
            );
        }
        let frames = options.frames.clone().unwrap_or(0..all);
        if frames.is_empty() || frames.end > MAX_FRAMES {
            return Err(format!("frames {}..{}: none, or more than {MAX_FRAMES}", frames.start, frames.end));
        }
        let turntable = options.turntable;
        Ok(Film { fps, frames, hold: options.hold.max(1), turntable, plays: playing, camera })
    }

    /// Frames a second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// The frames that are drawn.
    pub fn frames(&self) -> Range<u32> {
        self.frames.clone()
    }

    /// The frame whose drawing frame `n` shows: itself, unless drawings are held.
    pub fn shown(&self, n: u32) -> u32 {
        (n - n % self.hold).max(self.frames.start)
    }

    /// The frames from `n` on that show the same drawing.
    pub fn held(&self, n: u32) -> Range<u32> {
        n..((n - n % self.hold).saturating_add(self.hold)).min(self.frames.end)
    }

    /// Seconds at frame `n`.
    pub fn time(&self, n: u32) -> f64 {
        f64::from(n) / self.fps
    }

    /// At most `count` frames, evenly over the film, its first and last among them.
    fn some(&self, count: usize) -> impl Iterator<Item = u32> + Clone + use<> {
        let (start, last) = (self.frames.start, self.frames.end - 1);
        let count = (count as u32).min(last - start + 1).max(1);
        let steps = (count - 1).max(1);
        (0..count).map(move |k| start + (u64::from(last - start) * u64::from(k) / u64::from(steps)) as u32)
    }

    /// Makes a scene ready for all frames: the pose in which each surface is baked, the sphere that the camera fits, and
    /// the stipples. `progress` is called with a share 0…1.
    ///
    /// # Errors
    /// A surface without area in the pose in which it is largest.
    pub fn set_up(&self, scene: &mut Scene, progress: impl FnMut(f32)) -> Result<(), String> {
        if self.plays {
            for object in &mut scene.objects {
                let Some((moving, clip)) = object.moving.clone().and_then(|m| Some((m.clone(), m.clip()?)))
                else {
                    continue;
                };
                let times = self.some(MEASURED).map(|n| self.time(n));
                // Dots that follow are as dense as asked where the surface is at rest.
                let keeps = scene.density == Density::Keep;
                if let Some(time) = moving.largest(clip, times).filter(|_| keeps) {
                    object.play(Some(clip), Some(time)).map_err(|e| format!("{}: {e}", object.name))?;
                }
            }
            scene.sphere = Some(self.sphere(scene));
        }
        let moments: Vec<u32> = self.some(JUDGED).collect();
        let moments: Vec<_> = moments.iter().map(|&n| move |s: &mut Scene| self.moment(s, n)).collect();
        let moments: Vec<&dyn Fn(&mut Scene)> = moments.iter().map(|m| m as &dyn Fn(&mut Scene)).collect();
        scene.bake_for(&moments, progress);
        Ok(())
    }

    /// A sphere around all objects in all frames, in the world.
    fn sphere(&self, scene: &Scene) -> (DVec3, f64) {
        let times: Vec<f64> = self.some(MEASURED).map(|n| self.time(self.shown(n))).collect();
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for object in &scene.objects {
            match &object.moving {
                Some(moving) if moving.clip().is_some() => {
                    for &time in &times {
                        let ([a, b], _) = moving.extent(Some(time), None);
                        (low, high) = (low.min(a), high.max(b));
                    }
                }
                _ => {
                    let bounds = object.mesh.bounds();
                    (low, high) = (low.min(bounds.min), high.max(bounds.max));
                }
            }
        }
        let center = (low + high) * 0.5;
        let mut radius = 0f32;
        for object in &scene.objects {
            match &object.moving {
                Some(moving) if moving.clip().is_some() => {
                    for &time in &times {
                        radius = radius.max(moving.extent(Some(time), Some(center)).1);
                    }
                }
                _ => radius = radius.max(object.mesh.farthest_from(center)),
            }
        }
        (center.as_dvec3() + scene.origin(), f64::from(radius))
    }

    /// Makes of a scene that was set up what it is at frame `n`.
    pub fn moment(&self, scene: &mut Scene, n: u32) {
        let shown = self.shown(n);
        let time = self.time(shown);
        let timeline = std::mem::take(&mut scene.timeline);
        timeline.apply(time, &mut scene.camera, &mut scene.light);
        scene.timeline = timeline;
        if let Some(frames) = self.turntable {
            let turned = f64::from(shown % frames) * 360.0 / f64::from(frames);
            scene.camera.azimuth = (f64::from(scene.camera.azimuth) + turned) as f32;
        }
        let density = scene.density;
        for object in scene.objects.iter_mut().filter(|_| self.plays) {
            if object.moving.as_ref().is_some_and(|m| m.clip().is_some()) {
                object.pose(Some(time), density);
            }
        }
        if let Some((object, camera)) = self.camera {
            let moving = scene.objects[object].moving.as_ref();
            scene.standpoint = moving.and_then(|m| m.standpoint(camera, Some(time)));
        }
    }

    /// What a scene that was set up is at frame `n`.
    pub fn scene_at(&self, scene: &Scene, n: u32) -> Scene {
        let mut now = scene.clone();
        self.moment(&mut now, n);
        now
    }
}

/// The camera of that name, or of that number from 0, with the object that has it.
fn find_camera(scene: &Scene, name: &str) -> Result<(usize, usize), String> {
    let all = || {
        scene.objects.iter().enumerate().flat_map(|(k, o)| {
            let names = o.moving.as_ref().map_or(&[][..], |m| m.motion().cameras());
            names.iter().enumerate().map(move |(c, name)| (k, c, name.as_str()))
        })
    };
    let found = match name {
        "" => all().next(),
        _ => all().find(|c| c.2 == name).or_else(|| name.parse().ok().and_then(|n| all().nth(n))),
    };
    found.map(|(object, camera, _)| (object, camera)).ok_or_else(|| match all().next() {
        None => "no input has a camera".into(),
        Some(_) => {
            let names: Vec<&str> = all().map(|c| c.2).collect();
            format!("there is no camera '{name}'; there are {}", names.join(", "))
        }
    })
}
