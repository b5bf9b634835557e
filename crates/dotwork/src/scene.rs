//! The scene: what is drawn, from where, in what light and on what page.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use dotwork_drawing::{Camera, Light, Page, Strokes, View, Warnings};
use dotwork_ink::{BakeSettings, MAX_STIPPLES, MeshSurface, Stock, Style, blue_noise};
use dotwork_mesh::{Mesh, MeshError, MeshOptions, RawMesh};
use dotwork_volume::{Space, Unit, Volume};
use glam::Vec3;

use crate::artist::Artist;
use crate::scale_bar::ScaleBar;

/// Most stipples that [`Stipples::Auto`] bakes for one object.
pub const MAX_AUTO_STIPPLES: usize = 4_000_000;

/// Smallest and largest [`Camera::zoom`] that can be asked for.
pub const ZOOM: (f32, f32) = (1e-3, 1e6);

/// An object farther from the first than this many of its own radii stays in its own coordinates: relative to the
/// first one's origin, single precision would leave too few places across it.
const FARTHEST: f64 = 1e5;

/// Stipples of the first, small bake that tells how many are needed.
const PILOT_STIPPLES: usize = 16_384;

/// How many stipples are baked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stipples {
    /// As many as the darkest tone of this page and this view needs.
    #[default]
    Auto,
    /// This many for each object.
    Count(usize),
}

impl fmt::Display for Stipples {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stipples::Auto => f.write_str("auto"),
            Stipples::Count(n) => write!(f, "{n}"),
        }
    }
}

impl FromStr for Stipples {
    type Err = String;

    /// Reads `auto`, or a number from 1 to [`MAX_STIPPLES`].
    fn from_str(s: &str) -> Result<Self, String> {
        match s.parse::<usize>() {
            _ if s == "auto" => Ok(Stipples::Auto),
            Ok(n) if (1..=MAX_STIPPLES).contains(&n) => Ok(Stipples::Count(n)),
            _ => Err(format!("'{s}' is neither auto nor a number from 1 to {MAX_STIPPLES}")),
        }
    }
}

/// Where an object came from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// The path of the file as it was given, or `demo:NAME`.
    pub file: String,
    /// XXH64 of the bytes of all its files; `None` for demos.
    pub checksum: Option<u64>,
    /// How the bytes of a file without a header are laid out (`256x256x128:u8`).
    pub raw: Option<String>,
    /// The series of DICOM files that was asked for.
    pub series: Option<String>,
    /// The value whose isosurface was taken from a volume.
    pub iso: Option<f64>,
}

/// What is known about the space in which an object lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct World {
    /// What the axes mean.
    pub space: Space,
    /// The unit of length.
    pub unit: Unit,
}

/// A surface with its style and, once baked, its stipples.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name, unique in the scene by convention; see [`Scene::add`].
    pub name: String,
    /// Where it came from, if from a file.
    pub source: Option<Source>,
    /// The space in which it lies.
    pub world: World,
    /// Its surface.
    pub mesh: Arc<Mesh>,
    /// The prepared volume that its surface was found in.
    pub volume: Option<Arc<Volume>>,
    /// How it is drawn.
    pub style: Style,
    /// Its stipples; `None` until baked.
    pub stock: Option<Arc<Stock>>,
}

impl Object {
    /// Puts a mesh in order and takes it as an object. What was changed is said in `warnings`.
    ///
    /// # Errors
    /// See [`MeshError`]: no triangles, indices out of range, coordinates that are not numbers, no area.
    pub fn new(
        name: impl Into<String>,
        raw: RawMesh,
        style: Style,
        warnings: &mut Warnings,
    ) -> Result<Object, MeshError> {
        let options = MeshOptions { crease_angle: style.crease_angle, ..MeshOptions::default() };
        let mesh = Arc::new(Mesh::build(raw, &options, warnings)?);
        Ok(Object {
            name: name.into(),
            source: None,
            world: World::default(),
            mesh,
            volume: None,
            style,
            stock: None,
        })
    }

    /// Draws this object in another style from now on.
    ///
    /// Normals follow a new crease angle; stipples stay, so a new regularity shows only in the next bake.
    ///
    /// # Errors
    /// As [`Object::new`], for a mesh that did not come from there.
    pub fn restyle(&mut self, style: Style) -> Result<(), MeshError> {
        if style.crease_angle != self.style.crease_angle {
            let old = &self.mesh;
            let raw = RawMesh {
                positions: old.positions.iter().map(|p| p.to_array()).collect(),
                triangles: old.triangles.clone(),
                origin: old.origin,
                polygons: old.triangles.len(),
                colors: old.colors.clone(),
                // One a vertex: they may be better than those of the triangles.
                normals: match old.normals.len() == old.positions.len() {
                    true => old.normals.iter().map(|n| n.to_array()).collect(),
                    false => Vec::new(),
                },
            };
            let options = MeshOptions { crease_angle: style.crease_angle, ..MeshOptions::default() };
            let mesh = Mesh::build(raw, &options, &mut Warnings::new())?;
            // A mesh in order keeps its triangles; stipples of any other have lost their places.
            let kept = mesh.triangles == old.triangles && mesh.positions == old.positions;
            self.stock =
                self.stock.take().filter(|_| kept).map(|s| Arc::new(Stock::on_mesh(s.baked.clone(), &mesh)));
            self.mesh = Arc::new(mesh);
        }
        self.style = style;
        Ok(())
    }

    /// Takes coordinates relative to `origin` from now on, so that the object lies where it should beside others.
    /// False if it is too far away for that; then it stays as it is.
    fn move_origin(&mut self, origin: [f64; 3]) -> bool {
        let shift = [0, 1, 2].map(|k| self.mesh.origin[k] - origin[k]);
        if shift == [0.0; 3] {
            return true;
        }
        let farthest = FARTHEST * f64::from(self.mesh.bounding_sphere().1);
        // Written so that a shift that is no number fails as well.
        if !shift.iter().all(|s| s.abs() <= farthest) {
            return false;
        }
        let mesh = Arc::make_mut(&mut self.mesh);
        for p in &mut mesh.positions {
            *p = Vec3::from_array([0, 1, 2].map(|k| (f64::from(p[k]) + shift[k]) as f32));
        }
        mesh.origin = origin;
        self.stock = self.stock.take().map(|s| Arc::new(Stock::on_mesh(s.baked.clone(), mesh)));
        true
    }

    /// Bakes `count` stipples.
    fn bake(&mut self, count: usize, seed: u32, progress: &mut dyn FnMut(f32)) {
        let settings = BakeSettings { stipples: count, regularity: self.style.regularity, seed };
        let baked = blue_noise(&MeshSurface::new(&self.mesh), &settings, progress);
        self.stock = Some(Arc::new(Stock::on_mesh(baked, &self.mesh)));
    }
}

/// Everything a drawing depends on.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The objects, drawn in this order. Their coordinates must be relative to the same [`Mesh::origin`], as
    /// [`Scene::add`] sees to.
    pub objects: Vec<Object>,
    /// Where the eye stands.
    pub camera: Camera,
    /// Where the light comes from.
    pub light: Light,
    /// The page.
    pub page: Page,
    /// How many stipples are baked.
    pub stipples: Stipples,
    /// Seed of every random choice.
    pub seed: u32,
    /// A scale bar; left out of the drawing where [`Scene::scale_bar_strokes`] has an error, as in perspective.
    pub scale_bar: Option<ScaleBar>,
    /// Diameters in millimetres of the pens that files are written for; empty: dots of any size.
    pub pens: Vec<f32>,
}

impl Scene {
    /// A scene with one object and everything else at its default.
    pub fn of(object: Object) -> Scene {
        Scene { objects: vec![object], ..Scene::default() }
    }

    /// Adds an object; if its name is taken it becomes `NAME-2`, `NAME-3`, …. Its coordinates become relative to the
    /// first object's origin, so that both lie where their files say. False if it lies too far from the first for
    /// that (over 100,000 times its own size): it is then drawn about its own origin, as if that were the first one's.
    pub fn add(&mut self, mut object: Object) -> bool {
        let taken = |name: &str| self.objects.iter().any(|o| o.name == name);
        if taken(&object.name) {
            let free = (2..).map(|k| format!("{}-{k}", object.name)).find(|name| !taken(name));
            object.name = free.unwrap_or_default();
        }
        self.push(object)
    }

    /// As [`Scene::add`], under the name that the object has.
    pub(crate) fn push(&mut self, mut object: Object) -> bool {
        let together = self.objects.first().is_none_or(|first| object.move_origin(first.mesh.origin));
        self.objects.push(object);
        together
    }

    /// Centre and radius of a sphere around all objects, object units.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let spheres: Vec<(Vec3, f32)> = self.objects.iter().map(|o| o.mesh.bounding_sphere()).collect();
        match spheres[..] {
            [] => (Vec3::ZERO, 1.0),
            [one] => one,
            _ => {
                let low = spheres.iter().fold(Vec3::MAX, |m, (c, r)| m.min(*c - *r));
                let high = spheres.iter().fold(Vec3::MIN, |m, (c, r)| m.max(*c + *r));
                let center = 0.5 * (low + high);
                (center, spheres.iter().map(|(c, r)| c.distance(center) + r).fold(0.0, f32::max))
            }
        }
    }

    /// The view of the camera on this scene and page.
    pub fn view(&self) -> View {
        let (center, radius) = self.bounding_sphere();
        self.camera.view(center, radius, &self.page)
    }

    /// What is known about the space of the objects: of the first that knows.
    pub fn world(&self) -> World {
        let mut world = World::default();
        for object in &self.objects {
            if world.space == Space::Unknown {
                world.space = object.world.space;
            }
            if world.unit == Unit::Unknown {
                world.unit = object.world.unit;
            }
        }
        world
    }

    /// The strokes of the scale bar; `None` if none is asked for.
    ///
    /// # Errors
    /// As [`ScaleBar::strokes`].
    pub fn scale_bar_strokes(&self) -> Result<Option<Strokes>, String> {
        let bar = self.scale_bar.as_ref();
        bar.map(|bar| bar.strokes(&self.view(), &self.page, self.world().unit)).transpose()
    }

    /// Bakes what has not been baked. `progress` is called with a share 0…1.
    ///
    /// With [`Stipples::Auto`] a small bake first measures how dense this view's darkest tones are.
    pub fn bake(&mut self, progress: impl FnMut(f32)) {
        let missing: Vec<usize> =
            (0..self.objects.len()).filter(|&k| self.objects[k].stock.is_none()).collect();
        if missing.is_empty() {
            return;
        }
        let counts: Vec<usize> = match self.stipples {
            Stipples::Count(n) => missing.iter().map(|_| n).collect(),
            Stipples::Auto => {
                for &k in &missing {
                    self.objects[k].bake(PILOT_STIPPLES, self.seed, &mut |_| ());
                }
                let mut artist = Artist::new();
                missing
                    .iter()
                    .map(|&k| artist.stipples_needed(self, k).clamp(PILOT_STIPPLES, MAX_AUTO_STIPPLES))
                    .collect()
            }
        };
        self.bake_some(&missing, &counts, progress);
    }

    /// Bakes `counts[k]` stipples for object `k`, whatever [`Scene::stipples`] says. `progress` is called with a share
    /// 0…1.
    pub fn bake_counts(&mut self, counts: &[usize], progress: impl FnMut(f32)) {
        let all: Vec<usize> = (0..self.objects.len().min(counts.len())).collect();
        self.bake_some(&all, counts, progress);
    }

    /// Bakes `counts[i]` stipples for object `which[i]`.
    fn bake_some(&mut self, which: &[usize], counts: &[usize], mut progress: impl FnMut(f32)) {
        let whole = counts.iter().sum::<usize>().max(1) as f32;
        let mut done = 0.0;
        for (&k, &count) in which.iter().zip(counts) {
            let share = count as f32 / whole;
            self.objects[k].bake(count, self.seed, &mut |p| progress(done + share * p));
            done += share;
        }
        progress(1.0);
    }

    /// Bakes what has not been baked and draws one picture. For more than one, keep an [`Artist`].
    pub fn draw(&mut self) -> dotwork_drawing::Drawing {
        self.bake(|_| ());
        Artist::new().draw(self)
    }
}
