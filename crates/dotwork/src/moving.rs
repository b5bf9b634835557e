//! Objects that move: the pose in which their stipples were baked, and any other.

use std::str::FromStr;
use std::sync::Arc;

use dotwork_drawing::{Standpoint, Warnings};
use dotwork_ink::Stock;
use dotwork_mesh::{Mesh, MeshError, MeshOptions, Motion, MovingMesh, RawMesh, area_of};
use glam::{DMat3, DVec3, Vec3};

use crate::placement::Placement;

/// How many poses are tried for the one in which the surface is largest.
const POSES_TRIED: usize = 24;

/// A surface grown by less than this is baked at rest.
const GROWN: f64 = 1.02;

/// A pose of an object: a time of one of its animations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// The animation, by its name or number; `None` where there is none.
    pub clip: Option<String>,
    /// Seconds; `None`: as it stands at rest.
    pub time: Option<f64>,
}

/// What happens to the density of stipples as a surface is stretched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Density {
    /// It stays a function of light and scale: stipples come up where the surface grows.
    #[default]
    Keep,
    /// It follows: the same stipples lie farther apart, which shows how the surface is deformed.
    Follow,
}

impl FromStr for Density {
    type Err = String;

    /// Reads `keep` or `follow`.
    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "keep" => Ok(Density::Keep),
            "follow" => Ok(Density::Follow),
            _ => Err(format!("'{s}' is neither keep nor follow")),
        }
    }
}

/// What moves an object, and its mesh put in order for all poses.
#[derive(Clone, Debug)]
pub struct Moving {
    motion: Arc<dyn Motion>,
    /// From the motion's places, which are relative to `from`, to the world.
    linear: DMat3,
    shift: DVec3,
    from: DVec3,
    /// The surface in the pose in which its stipples are baked: the reference.
    raw: RawMesh,
    mesh: MovingMesh,
    clip: Option<usize>,
    reference: Option<f64>,
}

impl Moving {
    /// A surface at rest, `raw`, which `placement` has put in its place after its reader gave it the origin `from`.
    pub(crate) fn new(
        motion: Arc<dyn Motion>,
        raw: RawMesh,
        placement: &Placement,
        from: [f64; 3],
        options: &MeshOptions,
        warnings: &mut Warnings,
    ) -> Result<Moving, MeshError> {
        let (linear, shift) = placement.parts();
        let mesh = MovingMesh::build(raw.clone(), options, warnings)?;
        let from = DVec3::from_array(from);
        Ok(Moving { motion, linear, shift, from, raw, mesh, clip: None, reference: None })
    }

    /// What moves it.
    pub fn motion(&self) -> &Arc<dyn Motion> {
        &self.motion
    }

    /// The animation that it plays, by its number; `None`: it stands at rest.
    pub fn clip(&self) -> Option<usize> {
        self.clip
    }

    /// The time at which its stipples are baked; `None`: at rest.
    pub fn reference(&self) -> Option<f64> {
        self.reference
    }

    /// The surface as it is baked.
    pub fn reference_mesh(&self) -> &Arc<Mesh> {
        self.mesh.reference()
    }

    /// How long its animation lasts, seconds.
    pub fn seconds(&self) -> f64 {
        self.clip.map_or(0.0, |clip| self.motion.clips()[clip].seconds)
    }

    /// The animation of that name, or of that number from 0.
    ///
    /// # Errors
    /// Lists those that there are.
    pub fn find(&self, name: &str) -> Result<usize, String> {
        let clips = self.motion.clips();
        let by_name = clips.iter().position(|c| c.name == name);
        let by_number = || name.parse::<usize>().ok().filter(|&k| k < clips.len());
        let by_any_case = || clips.iter().position(|c| c.name.eq_ignore_ascii_case(name));
        by_name.or_else(by_any_case).or_else(by_number).ok_or_else(|| match clips {
            [] => format!("there is no animation '{name}': it has none"),
            _ => {
                let names: Vec<&str> = clips.iter().map(|c| c.name.as_str()).collect();
                format!("there is no animation '{name}'; it has {}", names.join(", "))
            }
        })
    }

    /// Where all vertices are at a time, relative to the origin of the mesh.
    fn place(&self, time: Option<f64>, positions: &mut Vec<[f32; 3]>) {
        let clip = self.clip.filter(|_| time.is_some());
        self.motion.place(clip, time.unwrap_or(0.0), positions);
        let origin = DVec3::from_array(self.raw.origin);
        if self.linear == DMat3::IDENTITY && self.shift + self.from == origin {
            return;
        }
        for p in positions {
            let world = self.linear * (DVec3::from_array(p.map(f64::from)) + self.from) + self.shift;
            *p = (world - origin).as_vec3().to_array();
        }
    }

    /// Plays an animation, and bakes at `reference` seconds of it; at rest where that is `None`.
    pub(crate) fn play(
        &self,
        clip: Option<usize>,
        reference: Option<f64>,
        options: &MeshOptions,
    ) -> Result<Moving, MeshError> {
        let mut moving = Moving { clip, reference, ..self.clone() };
        let mut positions = Vec::new();
        moving.place(reference, &mut positions);
        moving.raw.positions = positions;
        moving.rebuilt(options)
    }

    /// The time of an animation at which the surface is largest, so that there are stipples for all of it; `None`: it
    /// hardly grows.
    pub(crate) fn largest(&self, clip: usize, times: impl Iterator<Item = f64> + Clone) -> Option<f64> {
        let moving = Moving { clip: Some(clip), ..self.clone() };
        let mut positions = Vec::new();
        let mut area = |time: Option<f64>| {
            moving.place(time, &mut positions);
            area_of(&positions, &moving.raw.triangles)
        };
        let step = times.clone().count().div_ceil(POSES_TRIED).max(1);
        let mut largest = (area(None) * GROWN, None);
        for time in times.step_by(step) {
            let here = area(Some(time));
            if here > largest.0 {
                largest = (here, Some(time));
            }
        }
        largest.1
    }

    /// The same with its mesh put in order anew.
    pub(crate) fn rebuilt(self, options: &MeshOptions) -> Result<Moving, MeshError> {
        let mesh = MovingMesh::build(self.raw.clone(), options, &mut Warnings::new())?;
        Ok(Moving { mesh, ..self })
    }

    /// Takes coordinates relative to `origin` from now on.
    pub(crate) fn move_origin(&mut self, origin: [f64; 3], options: &MeshOptions) -> Result<(), MeshError> {
        let shift = DVec3::from_array(self.raw.origin) - DVec3::from_array(origin);
        for p in &mut self.raw.positions {
            *p = (DVec3::from_array(p.map(f64::from)) + shift).as_vec3().to_array();
        }
        self.raw.origin = origin;
        self.mesh = MovingMesh::build(self.raw.clone(), options, &mut Warnings::new())?;
        Ok(())
    }

    /// The surface at a time, and its stipples.
    pub(crate) fn pose(
        &self,
        time: Option<f64>,
        stock: Option<&Stock>,
        density: Density,
    ) -> (Arc<Mesh>, Option<Arc<Stock>>) {
        if time == self.reference {
            let mesh = self.reference_mesh().clone();
            let stock = stock.map(|s| Arc::new(s.posed(&mesh, None)));
            return (mesh, stock);
        }
        let mut positions = Vec::new();
        self.place(time, &mut positions);
        let mesh = self.mesh.posed(&positions);
        let stretch = (density == Density::Keep).then(|| self.mesh.stretch(&mesh));
        let stock = stock.map(|s| {
            let mut posed = s.posed(&mesh, stretch.as_deref());
            if density == Density::Keep && !s.baked.neighbours.is_empty() {
                posed.stretch_by_neighbours(&s.posed(self.reference_mesh(), None));
            }
            Arc::new(posed)
        });
        (Arc::new(mesh), stock)
    }

    /// How many times as large each triangle of the surface in a pose is as in the reference.
    pub(crate) fn stretch(&self, posed: &Mesh) -> Vec<f32> {
        self.mesh.stretch(posed)
    }

    /// Lowest and highest corner of the surface at a time, object units; the farthest distance from `center` of any
    /// vertex if that is given.
    pub(crate) fn extent(&self, time: Option<f64>, center: Option<Vec3>) -> ([Vec3; 2], f32) {
        let mut positions = Vec::new();
        self.place(time, &mut positions);
        let posed = self.mesh.places(&positions);
        let corners = posed.clone().fold([Vec3::MAX, Vec3::MIN], |[low, high], p| [low.min(p), high.max(p)]);
        let farthest = center.map_or(0.0, |c| posed.map(|p| p.distance(c)).fold(0.0, f32::max));
        (corners, farthest)
    }

    /// What one of its cameras sees at a time.
    pub(crate) fn standpoint(&self, camera: usize, time: Option<f64>) -> Option<Standpoint> {
        let clip = self.clip.filter(|_| time.is_some());
        let seen = self.motion.standpoint(camera, clip, time.unwrap_or(0.0))?;
        let eye = self.linear * seen.eye + self.shift;
        let turned = |v: Vec3| (self.linear * v.as_dvec3()).normalize_or_zero().as_vec3();
        let scale = self.linear.determinant().abs().cbrt() as f32;
        let lens = match seen.lens {
            dotwork_drawing::Lens::Parallel(half) => dotwork_drawing::Lens::Parallel(half * scale),
            lens => lens,
        };
        Some(Standpoint { eye, back: turned(seen.back), up: turned(seen.up), lens })
    }
}
