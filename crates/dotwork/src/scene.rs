//! The scene: what is drawn, from where, in what light and on what page.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use dotwork_drawing::{Camera, Light, Page, Strokes, View, Warnings};
use dotwork_ink::bake::{reference_scale, voxel};
use dotwork_ink::lines::{Criteria, VoxelCurves};
use dotwork_ink::tone::{FactorHistogram, factor_histograms};
use dotwork_ink::{
    BakeMethod, BakeSettings, Factors, HierarchySettings, MAX_STIPPLES, MeshSurface, Stock, Style,
    blue_noise, hierarchy,
};
use dotwork_mesh::{Bounds, ClipRegion, Mesh, MeshError, MeshOptions, RawMesh};
use dotwork_volume::{Space, Unit, Volume};
use glam::{DVec3, Vec3};

use crate::artist::Artist;
use crate::curves;
use crate::placement::Placement;
use crate::scale_bar::ScaleBar;
use crate::voxels;

/// Most stipples that [`Stipples::Auto`] bakes for one object.
pub const MAX_AUTO_STIPPLES: usize = 4_000_000;

/// Smallest and largest [`Camera::zoom`] that can be asked for.
pub const ZOOM: (f32, f32) = (1e-3, 1e6);

/// An object farther from the first than this many of its own radii stays in its own coordinates: relative to the
/// first one's origin, single precision would leave too few places across it.
const FARTHEST: f64 = 1e5;

/// Stipples of the first, small bake that tells how many are needed.
const PILOT_STIPPLES: usize = 16_384;

/// By how much the scale of a view may differ from that of a voxel bake before it is said.
const OTHER_SCALE: f32 = 2.0;

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
    /// Lowest and highest corner of its surface before it was clipped and placed, if it is that of a volume: what the
    /// shares in the style's `clip` count in.
    pub whole: Option<[DVec3; 2]>,
    /// How it is drawn.
    pub style: Style,
    /// Its stipples; `None` until baked.
    pub stock: Option<Arc<Stock>>,
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
        Ok(Object {
            name: name.into(),
            source: None,
            world: World::default(),
            mesh,
            volume: None,
            whole: None,
            style,
            stock: None,
            curves: None,
        })
    }

    /// Draws this object in another style from now on.
    ///
    /// Normals follow a new crease angle; stipples stay, so a new regularity shows only in the next bake. Stipples of
    /// a hierarchy are dropped, and made anew by the next bake, where `bake` or `randomize` change. Stipples of a voxel bake are dropped by what makes them another bake (`bake`, `k_max`, `slab`, `gradient_min`, `factors`, `clip`),
    /// so that the next one makes them anew; but without its volume, as from a `.dots` file, an object keeps those that it has.
    /// So are the voxels of its curves by a larger `t_log`, a smaller `t_grad` or another `clip`; they stay with any other
    /// `t_eye`.
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
                in_order: None,
            };
            let options =
                MeshOptions { crease_angle: style.crease_angle, orient: false, ..MeshOptions::default() };
            let mesh = Mesh::build(raw, &options, &mut Warnings::new())?;
            // A mesh in order keeps its triangles; stipples of any other have lost their places.
            let kept = mesh.triangles == old.triangles && mesh.positions == old.positions;
            self.stock = self.stock.take().and_then(|s| match s.elements {
                Some(_) => Some(s),
                None => kept.then(|| Arc::new(Stock::on_mesh(s.baked.clone(), &mesh))),
            });
            self.mesh = Arc::new(mesh);
        }
        let clip_changes = style.clip != self.style.clip;
        let bake_of = |s: &Style| (s.bake, s.k_max, s.slab, s.gradient_min, s.factors);
        let by_voxels = |s: &Style| self.volume.is_some() && s.bake == BakeMethod::Voxel;
        if (clip_changes || bake_of(&style) != bake_of(&self.style))
            && (by_voxels(&style) || by_voxels(&self.style))
        {
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

    /// Whether its stipples are, or will be, those of the voxels of its volume.
    fn by_voxels(&self) -> bool {
        self.style.bake == BakeMethod::Voxel && self.volume.is_some()
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
        if let Some(curves) = self.curves.as_mut().map(Arc::make_mut) {
            curves.lattice.origin += DVec3::from_array(shift);
            curves.settle();
        }
        self.stock = self.stock.take().map(|s| match &s.elements {
            None => Arc::new(Stock::on_mesh(s.baked.clone(), mesh)),
            // Baked again where they now are: moved stipples would differ by rounding from those of a file.
            Some(elements) => {
                let (mut voxels, settings) = elements.recipe();
                voxels.position.translate(Vec3::from_array(shift.map(|v| v as f32)));
                Arc::new(voxel(&voxels, &settings, &mut Warnings::new()))
            }
        });
        true
    }

    /// Bakes `count` stipples, or those of the voxels of its volume, whose number follows from view and page.
    fn bake(&mut self, count: usize, seed: u32, (view, page): (&View, &Page), progress: &mut dyn FnMut(f32)) {
        if let Some(volume) = self.volume.as_ref().filter(|_| self.by_voxels()) {
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
            let baked = hierarchy(&self.mesh, &settings, progress);
            self.stock = Some(Arc::new(Stock::on_mesh(baked, &self.mesh)));
            return;
        }
        self.bake_evenly(count, seed, progress);
    }

    /// Bakes `count` stipples by blue noise, whatever the style says.
    fn bake_evenly(&mut self, count: usize, seed: u32, progress: &mut dyn FnMut(f32)) {
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

    /// Centre and radius of a sphere around all objects, object units: the centre of their common box, and the distance
    /// to the farthest vertex.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
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
    /// With [`Stipples::Auto`] a small bake first measures how dense this view's darkest tones are. A volume whose style
    /// has the bake `voxel` gets as many as its voxels show in this view, whatever [`Scene::stipples`] says.
    pub fn bake(&mut self, mut progress: impl FnMut(f32)) {
        self.bake_curves();
        let missing: Vec<usize> =
            (0..self.objects.len()).filter(|&k| self.objects[k].stock.is_none()).collect();
        if missing.is_empty() {
            return;
        }
        let (by_voxels, mut by_count): (Vec<usize>, Vec<usize>) =
            missing.into_iter().partition(|&k| self.objects[k].by_voxels());
        let share = by_voxels.len() as f32 / (by_voxels.len() + by_count.len()) as f32;
        self.bake_some(&by_voxels, &vec![1; by_voxels.len()], |p| progress(share * p));
        // A volume without boundaries: its stipples lie on the surface, as many as there are on others.
        let carries = |k: &usize| self.objects[*k].stock.as_ref().is_some_and(|s| s.elements.is_some());
        by_count.extend(by_voxels.into_iter().filter(|k| !carries(k)));
        let counts: Vec<usize> = match self.stipples {
            Stipples::Count(n) => by_count.iter().map(|_| n).collect(),
            Stipples::Auto => {
                // What a place asks for does not depend on who makes the order: the pilot is the quickest.
                for &k in &by_count {
                    self.objects[k].bake_evenly(PILOT_STIPPLES, self.seed, &mut |_| ());
                }
                let mut artist = Artist::new();
                by_count
                    .iter()
                    .map(|&k| artist.stipples_needed(self, k).clamp(PILOT_STIPPLES, MAX_AUTO_STIPPLES))
                    .collect()
            }
        };
        self.bake_some(&by_count, &counts, |p| progress(share + (1.0 - share) * p));
    }

    /// Bakes `counts[k]` stipples for object `k`, whatever [`Scene::stipples`] says; a volume with the bake `voxel` gets
    /// those that this view gives it. `progress` is called with a share 0…1.
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

    /// What each of the papers' factors does to the voxels of object `k` in this view; `None` if it has none, or is not
    /// baked.
    pub fn factor_histograms(&self, k: usize) -> Option<Vec<FactorHistogram>> {
        let object = self.objects.get(k)?;
        let elements = object.stock.as_ref()?.elements.as_ref()?;
        let view = self.view();
        let light = self.light.direction(&view, self.camera.up);
        Some(factor_histograms(elements, &object.style, &view, &self.page, light))
    }

    /// What is to be said about the stipples of the baked objects in this view: `bake=voxel` where there is no volume
    /// for it, voxels whose lists had to be shortened, and a scale of more than twice or less than half of that which
    /// voxels were baked for.
    pub fn bake_warnings(&self) -> Warnings {
        let mut warnings = Warnings::new();
        let scale = reference_scale(&self.view(), &self.page);
        for object in &self.objects {
            let (Some(stock), name) = (&object.stock, &object.name) else { continue };
            let cut = object.source.as_ref().is_some_and(|source| source.cut.is_some());
            if object.draws_curves() && !cut {
                curve_warnings(object, &mut warnings);
            }
            let Some(elements) = &stock.elements else {
                if object.style.bake == BakeMethod::Voxel && !cut {
                    warnings.say(format!(
                        "{name}: there are no voxels for bake=voxel; its dots lie on its surface"
                    ));
                }
                continue;
            };
            if object.style.bake != BakeMethod::Voxel {
                warnings
                    .say(format!("{name}: its stipples are those of voxels, from a file without the volume"));
            }
            if elements.n_max < elements.wanted {
                warnings.say(format!(
                    "{name}: a voxel shows {} stipples instead of {:.0}; a smaller k_max asks for fewer",
                    elements.n_max, elements.wanted
                ));
            }
            if let Some(of_bake) = elements.reference {
                let times = scale / of_bake;
                if !(1.0 / OTHER_SCALE..=OTHER_SCALE).contains(&times) {
                    warnings.say(format!(
                        "{name}: its voxels were baked for a picture of another scale (this one is {times:.2} times that)"
                    ));
                }
            }
        }
        warnings
    }

    /// Bakes what has not been baked and draws one picture. For more than one, keep an [`Artist`].
    pub fn draw(&mut self) -> dotwork_drawing::Drawing {
        self.bake(|_| ());
        Artist::new().draw(self)
    }
}

/// What is to be said about the curves of an object that is to draw some.
fn curve_warnings(Object { name, curves, style, .. }: &Object, warnings: &mut Warnings) {
    let Some(curves) = curves else {
        warnings.say(format!("{name}: there are no voxels for curves=true"));
        return;
    };
    if !curves.holds(&Criteria::of(style)) {
        warnings.say(format!(
            "{name}: its curves have t_log up to {} and t_grad from {}, from a file without the volume",
            curves.t_log, curves.t_grad
        ));
    }
    if curves.least > curves.t_grad && curves.least > style.t_grad {
        warnings.say(format!(
            "{name}: too many voxels for curves; t_grad counts as {:.3}, a larger one or a smaller t_log asks for fewer",
            curves.least
        ));
    }
}
