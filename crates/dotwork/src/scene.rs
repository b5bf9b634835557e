//! The scene: what is drawn, from where, in what light and on what page.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use dotwork_drawing::{Camera, Light, Page, Standpoint, Strokes, View, Warnings};
use dotwork_ink::bake::voxel;
use dotwork_ink::lines::{Criteria, VoxelCurves};
use dotwork_ink::tone::{FactorHistogram, factor_histograms};
use dotwork_ink::{
    BakeMethod, BakeSettings, Elements, Factors, HierarchySettings, MAX_STIPPLES, MeshSurface, Stock, Style,
    blue_noise, hierarchy,
};
use dotwork_mesh::{Bounds, ClipRegion, Mesh, MeshError, MeshOptions, Motion, RawMesh};
use dotwork_render::Needed;
use dotwork_volume::{Space, Unit, Volume};
use glam::{DVec3, Vec3};

use crate::artist::Artist;
use crate::curves;
use crate::endless::Endless;
use crate::faces;
use crate::moving::{Density, Moving, Pose};
use crate::placement::Placement;
use crate::scale_bar::ScaleBar;
use crate::timeline::Timeline;
use crate::voxels;

/// Most stipples that [`Stipples::Auto`] bakes for one object.
pub const MAX_AUTO_STIPPLES: usize = 4_000_000;

/// Smallest and largest [`Camera::zoom`] that can be asked for.
pub const ZOOM: (f32, f32) = (1e-3, 1e6);

/// An object farther from the first than this many of its own radii stays in its own coordinates: relative to the
/// first one's origin, single precision would leave too few places across it.
const FARTHEST: f64 = 1e5;

/// Where a view needs more stipples than this, but on a small part of the surface only, [`Stipples::Auto`] bakes no more
/// than [`SEEN_TIMES`] those that are seen, or this many.
const ENOUGH_STIPPLES: usize = 150_000;

/// See [`ENOUGH_STIPPLES`].
const SEEN_TIMES: f64 = 4.0;

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
    /// Which of the faces that a clip cut open this is, from 0; `None` for the surface itself.
    pub cut: Option<u32>,
    /// Which label of a segmentation it is.
    pub label: Option<i64>,
    /// Where it was put, as a scene file says.
    pub placement: Placement,
    /// The pose in which it is drawn, if it moves; `None`: at rest.
    pub pose: Option<Pose>,
    /// The time of that animation at which it was baked; `None`: at rest.
    pub baked_at: Option<f64>,
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
    /// What moves it.
    pub moving: Option<Arc<Moving>>,
    /// The prepared volume that its surface was found in.
    pub volume: Option<Arc<Volume>>,
    /// Lowest and highest corner of its surface before it was clipped and placed, if it is that of a volume: what the
    /// shares in the style's `clip` count in.
    pub whole: Option<[DVec3; 2]>,
    /// How it is drawn.
    pub style: Style,
    /// Its stipples; `None` until baked.
    pub stock: Option<Arc<Stock>>,
    /// The stipples that it was drawn with, where a view asked for more than it has; see [`Artist::as_drawn`].
    pub shown: Option<Arc<Stock>>,
    /// How its stipples can be continued; `None` until baked, and for stipples that cannot.
    pub(crate) endless: Option<Endless>,
    /// The voxels of its silhouette curves; `None` until baked, and where its style or the lack of a volume asks for none.
    pub curves: Option<Arc<VoxelCurves>>,
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
        // What brings its own normals knows its sides too: an isosurface.
        let orient = raw.normals.is_empty();
        let options = MeshOptions { crease_angle: style.crease_angle, orient, ..MeshOptions::default() };
        let mesh = Arc::new(Mesh::build(raw, &options, warnings)?);
        Ok(Object::of_mesh(name.into(), mesh, style))
    }

    /// As [`Object::new`], of a mesh that `motion` moves; `raw` is at rest, with the coordinates that the motion gives.
    ///
    /// # Errors
    /// As [`Object::new`].
    pub fn moving(
        name: impl Into<String>,
        raw: RawMesh,
        motion: Arc<dyn Motion>,
        style: Style,
        warnings: &mut Warnings,
    ) -> Result<Object, MeshError> {
        let from = raw.origin;
        Object::placed(name.into(), raw, (motion, from), &Placement::default(), style, warnings)
    }

    /// As [`Object::moving`], where `placement` has put the mesh away from where the motion, whose places are relative
    /// to an origin, would have it.
    pub(crate) fn placed(
        name: String,
        raw: RawMesh,
        (motion, from): (Arc<dyn Motion>, [f64; 3]),
        placement: &Placement,
        style: Style,
        warnings: &mut Warnings,
    ) -> Result<Object, MeshError> {
        let moving = Moving::new(motion, raw, placement, from, &moving_options(&style), warnings)?;
        let object = Object::of_mesh(name, moving.reference_mesh().clone(), style);
        Ok(Object { moving: Some(Arc::new(moving)), ..object })
    }

    pub(crate) fn of_mesh(name: String, mesh: Arc<Mesh>, style: Style) -> Object {
        Object {
            name,
            source: None,
            world: World::default(),
            mesh,
            moving: None,
            volume: None,
            whole: None,
            style,
            stock: None,
            shown: None,
            endless: None,
            curves: None,
        }
    }

    /// Plays an animation from now on, to be baked in the pose that it has at `reference` seconds; at rest where that is
    /// `None`. It then stands in that pose. What does not move stays as it is.
    ///
    /// # Errors
    /// As [`Object::new`], for a pose without area.
    pub fn play(&mut self, clip: Option<usize>, reference: Option<f64>) -> Result<(), MeshError> {
        let Some(moving) = &self.moving else { return Ok(()) };
        let moving = moving.play(clip, reference, &moving_options(&self.style))?;
        self.mesh = moving.reference_mesh().clone();
        self.stock = None;
        self.set_pose(&moving, reference);
        self.moving = Some(Arc::new(moving));
        Ok(())
    }

    /// Takes the pose that its animation has at a time, with its stipples.
    pub fn pose(&mut self, time: Option<f64>, density: Density) {
        let Some(moving) = self.moving.clone() else { return };
        (self.mesh, self.stock) = moving.pose(time, self.stock.as_deref(), density);
        self.set_pose(&moving, time);
    }

    /// Plays the animation of that name or number, the first where none is named, and is baked in the pose of a time.
    /// What does not move stays as it is.
    ///
    /// # Errors
    /// There is no such animation; the list of those that there are. A pose without area.
    pub fn take_pose(&mut self, clip: Option<&str>, time: Option<f64>) -> Result<(), String> {
        let Some(moving) = &self.moving else { return Ok(()) };
        let clip = match clip {
            Some(name) => Some(moving.find(name)?),
            None => (!moving.motion().clips().is_empty()).then_some(0),
        };
        self.play(clip, time.filter(|_| clip.is_some())).map_err(|e| e.to_string())
    }

    fn set_pose(&mut self, moving: &Moving, time: Option<f64>) {
        if let Some(source) = &mut self.source {
            let name = moving.clip().map(|clip| moving.motion().clips()[clip].name.clone());
            source.baked_at = moving.reference();
            let moved = time.is_some() || moving.reference().is_some();
            source.pose = moved.then_some(Pose { clip: name, time });
        }
    }

    /// Draws this object in another style from now on.
    ///
    /// Normals follow a new crease angle; stipples stay, so a new regularity shows only in the next bake. Stipples of
    /// a hierarchy are dropped, and made anew by the next bake, where `bake` or `randomize` change. Stipples of
    /// a voxel or face bake are dropped by what makes them another bake (`bake`, `k_max`, `factors`; of voxels `slab`,
    /// `gradient_min`, `clip`; of faces `rank`), so that the next one makes them anew; but without its volume, as from a
    /// `.dots` file, an object keeps the voxels' that it has, unless it is asked for those of its faces.
    /// So are the voxels of its curves by a larger `t_log`, a smaller `t_grad` or another `clip`; they stay with any other
    /// `t_eye`.
    ///
    /// # Errors
    /// As [`Object::new`], for a mesh that did not come from there.
    pub fn restyle(&mut self, style: Style) -> Result<(), MeshError> {
        if let Some(moving) = self.moving.take_if(|_| style.crease_angle != self.style.crease_angle) {
            // Stipples stay on their triangles, if these do.
            let old = moving.reference_mesh().clone();
            let moving = Arc::unwrap_or_clone(moving).rebuilt(&moving_options(&style))?;
            self.mesh = moving.reference_mesh().clone();
            self.stock = self.stock.take().filter(|_| self.mesh.triangles == old.triangles);
            self.stock = self.stock.take().map(|s| Arc::new(s.posed(&self.mesh, None)));
            self.moving = Some(Arc::new(moving));
        } else if style.crease_angle != self.style.crease_angle {
            let old = &self.mesh;
            let raw = RawMesh {
                positions: old.positions.iter().map(|p| p.to_array()).collect(),
                triangles: old.triangles.clone(),
                origin: old.origin,
                polygons: old.triangles.len(),
                colors: old.colors.clone(),
                paint: old.paint.as_deref().cloned(),
                // One a vertex: they may be better than those of the triangles.
                normals: match old.normals.len() == old.positions.len() {
                    true => old.normals.iter().map(|n| n.to_array()).collect(),
                    false => Vec::new(),
                },
                in_order: None,
                tracks: Vec::new(),
            };
            let options =
                MeshOptions { crease_angle: style.crease_angle, orient: false, ..MeshOptions::default() };
            let mesh = Mesh::build(raw, &options, &mut Warnings::new())?;
            // A mesh in order keeps its triangles; stipples of any other have lost their places.
            let kept = mesh.triangles == old.triangles && mesh.positions == old.positions;
            self.stock = self.stock.take().and_then(|s| match &s.elements {
                Some(elements) if !elements.are_faces() => Some(s),
                _ => kept.then(|| s.following(&mesh)).flatten().map(Arc::new),
            });
            self.mesh = Arc::new(mesh);
        }
        let clip_changes = style.clip != self.style.clip;
        let (old, new) = (self.lists(&self.style), self.lists(&style));
        let either = |lists: Lists| old == lists || new == lists;
        let voxels_of = |s: &Style| (s.bake, s.k_max, s.slab, s.gradient_min, s.factors);
        let faces_of = |s: &Style| (s.k_max, s.rank, s.factors);
        let voxels = either(Lists::Voxels) && (clip_changes || voxels_of(&style) != voxels_of(&self.style));
        let faces = either(Lists::Faces) && faces_of(&style) != faces_of(&self.style);
        if old != new || voxels || faces {
            self.stock = None;
        }
        // Not so those of voxels that have lost their volume: there is nothing to make others from.
        let hierarchies = |s: &Style| (s.bake == BakeMethod::Hierarchy).then_some(s.randomize);
        let kept = self.stock.as_ref().is_some_and(|stock| stock.elements.is_some()) && self.volume.is_none();
        if hierarchies(&style) != hierarchies(&self.style) && !kept {
            self.stock = None;
        }
        self.style = style;
        if self.wants_curves() || clip_changes && self.volume.is_some() {
            self.curves = None;
        }
        Ok(())
    }

    /// What its style clips away of its volume, world units.
    fn removed(&self) -> Option<ClipRegion> {
        let region = ClipRegion::parse(self.style.clip.planes(), self.whole?).ok()?;
        let placement = self.source.as_ref().map(|source| source.placement).unwrap_or_default();
        placement.region(&region)
    }

    /// Whether its style draws the curves of its volume.
    pub(crate) fn draws_curves(&self) -> bool {
        self.style.curves && self.style.factors == Factors::Papers
    }

    /// Whether it draws curves and has a volume, but not yet the voxels for them.
    fn wants_curves(&self) -> bool {
        let criteria = Criteria::of(&self.style);
        let there = self.curves.as_ref().is_some_and(|curves| curves.holds(&criteria));
        self.draws_curves() && self.volume.is_some() && !there
    }

    /// Whose lists its stipples are in this style, or will be once they are baked.
    fn lists(&self, style: &Style) -> Lists {
        let cut = self.source.as_ref().is_some_and(|source| source.cut.is_some());
        let elements = self.stock.as_ref().and_then(|stock| stock.elements.as_ref());
        match style.bake {
            BakeMethod::Face => Lists::Faces,
            BakeMethod::Voxel if self.volume.is_some() => Lists::Voxels,
            // Those of a file without its volume stay.
            BakeMethod::Voxel if elements.is_some_and(|elements| !elements.are_faces()) => Lists::None,
            BakeMethod::Voxel if style.factors == Factors::Papers && !cut => Lists::Faces,
            BakeMethod::Voxel | BakeMethod::BlueNoise | BakeMethod::Hierarchy => Lists::None,
        }
    }

    /// Whether the number of its stipples follows from view and page.
    fn counted_by_view(&self) -> bool {
        match self.lists(&self.style) {
            Lists::Voxels => true,
            Lists::Faces => self.style.factors == Factors::Papers,
            Lists::None => false,
        }
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
        if let Some(moving) = &mut self.moving {
            let options = moving_options(&self.style);
            if Arc::make_mut(moving).move_origin(origin, &options).is_err() {
                return false;
            }
        }
        let mesh = Arc::make_mut(&mut self.mesh);
        for p in &mut mesh.positions {
            *p = Vec3::from_array([0, 1, 2].map(|k| (f64::from(p[k]) + shift[k]) as f32));
        }
        mesh.origin = origin;
        if let Some(curves) = self.curves.as_mut().map(Arc::make_mut) {
            curves.lattice.origin += DVec3::from_array(shift);
            curves.settle();
        }
        self.stock = self.stock.take().map(|s| match s.elements.as_ref().and_then(Elements::recipe) {
            // Baked again where they now are: moved stipples would differ by rounding from those of a file.
            Some((mut voxels, settings)) => {
                voxels.position.translate(Vec3::from_array(shift.map(|v| v as f32)));
                Arc::new(voxel(&voxels, &settings, &mut Warnings::new()))
            }
            None => s.following(mesh).map_or(s, Arc::new),
        });
        true
    }

    /// Bakes `count` stipples, or those of its voxels or faces, whose number may follow from view and page.
    fn bake(&mut self, count: usize, seed: u32, (view, page): (&View, &Page), progress: &mut dyn FnMut(f32)) {
        let lists = self.lists(&self.style);
        self.endless = None;
        // What moves is baked in one pose, whatever pose it has.
        let surface = self.moving.as_ref().map_or(&self.mesh, |moving| moving.reference_mesh());
        if lists == Lists::Faces {
            let stock = faces::bake(surface, &self.style, count, (view, page), seed, progress);
            self.stock = Some(Arc::new(stock.posed(&self.mesh, None)));
            return;
        }
        if let Some(volume) = self.volume.as_ref().filter(|_| lists == Lists::Voxels) {
            let iso = self.source.as_ref().and_then(|source| source.iso);
            let removed = self.removed();
            let ask =
                voxels::Ask { origin: self.mesh.origin, iso, removed, style: &self.style, view, page, seed };
            if let Some(stock) = voxels::bake(volume, &ask, progress) {
                self.stock = Some(Arc::new(stock));
                return;
            }
        }
        if self.style.bake == BakeMethod::Hierarchy {
            let settings = HierarchySettings { stipples: count, randomize: self.style.randomize, seed };
            let baked = hierarchy(surface, &settings, progress);
            self.stock = Some(Arc::new(Stock::on_mesh(baked, &self.mesh)));
            return;
        }
        self.bake_evenly(count, seed, progress);
    }

    /// Bakes `count` stipples by blue noise, whatever the style says.
    fn bake_evenly(&mut self, count: usize, seed: u32, progress: &mut dyn FnMut(f32)) {
        let settings = BakeSettings { stipples: count, regularity: self.style.regularity, seed };
        let surface = self.moving.as_ref().map_or(&self.mesh, |moving| moving.reference_mesh());
        let baked = blue_noise(&MeshSurface::new(&**surface), &settings, progress);
        self.stock = Some(Arc::new(Stock::on_mesh(baked, &self.mesh)));
        self.endless = Some(Endless::new(self.style.regularity, seed));
    }
}

/// How the mesh of an object that moves is put in order.
fn moving_options(style: &Style) -> MeshOptions {
    MeshOptions { crease_angle: style.crease_angle, ..MeshOptions::default() }
}

/// Whose lists the stipples of an object are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lists {
    /// There is one order over its surface.
    None,
    /// The voxels of its volume.
    Voxels,
    /// The faces of its surface.
    Faces,
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
    /// The sphere that the camera fits to the page, in the world: that of a whole film, so that it does not breathe.
    /// `None`: the [`Scene::bounding_sphere`] of the objects as they stand.
    pub sphere: Option<(DVec3, f64)>,
    /// An eye that something else than the camera has placed: a camera of a file.
    pub standpoint: Option<Standpoint>,
    /// What becomes of the density of stipples where a surface is stretched.
    pub density: Density,
    /// How camera and light move in a film.
    pub timeline: Timeline,
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

    /// Centre and radius of a sphere around all objects, object units: the centre of their common box, and the distance
    /// to the farthest vertex; or [`Scene::sphere`].
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        if let Some((center, radius)) = self.sphere {
            return ((center - self.origin()).as_vec3(), radius as f32);
        }
        let boxes = self.objects.iter().map(|o| o.mesh.bounds());
        let Some(all) = boxes.reduce(|a, b| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }) else {
            return (Vec3::ZERO, 1.0);
        };
        let center = all.center();
        (center, self.objects.iter().map(|o| o.mesh.farthest_from(center)).fold(0.0, f32::max))
    }

    /// The view of the camera on this scene and page.
    pub fn view(&self) -> View {
        let (center, radius) = self.bounding_sphere();
        match &self.standpoint {
            Some(seen) => seen.view(self.origin(), (center, radius), &self.page, self.camera.zoom),
            None => self.camera.view(center, radius, &self.page),
        }
    }

    /// What all coordinates are relative to, in the world.
    pub(crate) fn origin(&self) -> DVec3 {
        self.objects.first().map_or(DVec3::ZERO, |o| DVec3::from_array(o.mesh.origin))
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
    /// With [`Stipples::Auto`] a small bake first measures how dense this view's darkest tones are. A volume whose style
    /// has the bake `voxel` gets as many as its voxels show in this view, whatever [`Scene::stipples`] says; so does any
    /// object whose faces have lists and whose style has the papers' factors.
    pub fn bake(&mut self, progress: impl FnMut(f32)) {
        self.bake_for(&[], progress);
    }

    /// As [`Scene::bake`], for several moments: with [`Stipples::Auto`] as many as the moment that needs most. Each moment
    /// changes this scene into what it then is; without any it is judged as it is.
    pub fn bake_for(&mut self, moments: &[&dyn Fn(&mut Scene)], mut progress: impl FnMut(f32)) {
        self.bake_curves();
        let missing: Vec<usize> =
            (0..self.objects.len()).filter(|&k| self.objects[k].stock.is_none()).collect();
        if missing.is_empty() {
            return;
        }
        let (by_view, mut by_count): (Vec<usize>, Vec<usize>) =
            missing.into_iter().partition(|&k| self.objects[k].counted_by_view());
        let share = by_view.len() as f32 / (by_view.len() + by_count.len()) as f32;
        self.bake_some(&by_view, &vec![1; by_view.len()], |p| progress(share * p));
        // A volume without boundaries: its stipples lie on the surface, as many as there are on others.
        let carries = |k: &usize| self.objects[*k].stock.as_ref().is_some_and(|s| s.elements.is_some());
        by_count.extend(by_view.into_iter().filter(|k| !carries(k)));
        let counts: Vec<usize> = match self.stipples {
            Stipples::Count(n) => by_count.iter().map(|_| n).collect(),
            Stipples::Auto => {
                // What a place asks for does not depend on who makes the order: the pilot is the quickest.
                for &k in &by_count {
                    self.objects[k].bake_evenly(PILOT_STIPPLES, self.seed, &mut |_| ());
                }
                let mut needed = vec![PILOT_STIPPLES; by_count.len()];
                let mut judge = |scene: &Scene| {
                    let mut artist = Artist::new();
                    for (needed, &k) in needed.iter_mut().zip(&by_count) {
                        let Needed { stipples, seen } = artist.stipples_needed(scene, k);
                        // Where little of a surface is seen, more is made when it is drawn, and only there.
                        let shown = (SEEN_TIMES * seen * stipples as f64) as usize;
                        // But lists and hierarchies end.
                        let endless = scene.objects[k].style.bake == BakeMethod::BlueNoise;
                        let enough = if endless { shown.max(ENOUGH_STIPPLES) } else { usize::MAX };
                        let baked = stipples.min(enough);
                        *needed = baked.clamp(*needed, MAX_AUTO_STIPPLES);
                    }
                };
                if moments.is_empty() {
                    judge(self);
                }
                for moment in moments {
                    let mut scene = self.clone();
                    moment(&mut scene);
                    judge(&scene);
                }
                needed
            }
        };
        self.bake_some(&by_count, &counts, |p| progress(share + (1.0 - share) * p));
    }

    /// Bakes `counts[k]` stipples for object `k`, whatever [`Scene::stipples`] says; lists of voxels, and with the papers'
    /// factors those of faces, get what this view gives them. `progress` is called with a share 0…1.
    pub fn bake_counts(&mut self, counts: &[usize], progress: impl FnMut(f32)) {
        self.bake_curves();
        let all: Vec<usize> = (0..self.objects.len().min(counts.len())).collect();
        self.bake_some(&all, counts, progress);
    }

    /// Finds the voxels of curves where they are asked for and not there.
    fn bake_curves(&mut self) {
        for object in &mut self.objects {
            if let Some(volume) = object.volume.as_ref().filter(|_| object.wants_curves()) {
                let removed = object.removed();
                let curves = curves::bake(volume, object.mesh.origin, &object.style, removed.as_ref());
                object.curves = Some(Arc::new(curves));
            }
        }
    }

    /// Bakes `counts[i]` stipples for object `which[i]`.
    fn bake_some(&mut self, which: &[usize], counts: &[usize], mut progress: impl FnMut(f32)) {
        if which.is_empty() {
            return;
        }
        let (view, page) = (self.view(), self.page);
        let whole = counts.iter().sum::<usize>().max(1) as f32;
        let mut done = 0.0;
        for (&k, &count) in which.iter().zip(counts) {
            let share = count as f32 / whole;
            self.objects[k].bake(count, self.seed, (&view, &page), &mut |p| progress(done + share * p));
            done += share;
        }
        progress(1.0);
    }

    /// What each of the papers' factors does to the voxels or faces of object `k` in this view; `None` if it has no
    /// lists of them, or is not
    /// baked.
    pub fn factor_histograms(&self, k: usize) -> Option<Vec<FactorHistogram>> {
        let object = self.objects.get(k)?;
        let elements = object.stock.as_ref()?.elements.as_ref()?;
        let view = self.view();
        let light = self.light.direction(&view, self.camera.up);
        Some(factor_histograms(elements, &object.style, &view, &self.page, light))
    }

    /// Bakes what has not been baked and draws one picture. For more than one, keep an [`Artist`].
    pub fn draw(&mut self) -> dotwork_drawing::Drawing {
        self.bake(|_| ());
        Artist::new().draw(self)
    }
}
