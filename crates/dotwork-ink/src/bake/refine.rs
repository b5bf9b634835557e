//! Refinement: further stages of a blue-noise bake, only where they are looked at.
//!
//! Meruvia Pastor et al. (2003, sections V-A and VI) leave it open how to fill in stipples where one comes so close that
//! the hierarchy is exhausted. Here the surface is parted into *bricks*, cubes whose side is a number of the stage's
//! distances, and a stage is run in one brick at a time: with its own candidates, which follow from the stage and the
//! place on the surface alone, against all points of the stages before it, in the brick and a rim around it. What is
//! accepted in the brick is kept. It depends on the surface, the seed and the brick, never on the view: the same place
//! always gets the same stipples, and they continue the order of the stock.
//!
//! The rim is wide enough that two neighbours, each of which sees the other's border, nearly always agree on it: greedy
//! selection lets a choice depend on others far away, but ever less. Where they differ, in about one of some thousand
//! points, two dots come closer than they should, or a gap stays.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use super::blue_noise::{
    Accepted, BakeSettings, Part, Stage, chunks, first_distance, reach, run_stage, spread,
};
use super::buckets::Site;
use crate::stock::{Baked, Stock};
use crate::surface::{MeshSurface, Surface};

/// The side of a brick in reaches of its stage: wide against its rim, narrow against a page.
const BRICK: f32 = 48.0;

/// The width of the rim in reaches.
const RIM: f32 = 6.0;

/// The last stage whose candidates can be told apart.
const LAST_STAGE: u32 = 29;

/// Points that are kept when the view has moved on.
const KEPT_POINTS: usize = 6_000_000;

/// The place of a brick in the grid of its stage.
pub type Cell = [i32; 3];

/// The stipples of a stage in a brick.
#[derive(Debug, Default)]
pub struct Brick {
    /// Those that the stock does not hold, their radii in no order.
    pub baked: Baked,
    /// All of them.
    sites: Vec<Site>,
}

/// A bake that can be continued anywhere.
pub struct Refinement {
    surface: MeshSurface<Arc<Mesh>>,
    settings: BakeSettings,
    /// The bake, whose points of all stages before `first` are complete.
    baked: Arc<Baked>,
    first: u32,
    /// The stock holds every point of at least this radius.
    complete: f32,
    /// The points of the stages before `first`, by the cell of `first` that they lie in.
    base: HashMap<Cell, Vec<Site>>,
    bricks: Mutex<Bricks>,
}

#[derive(Default)]
struct Bricks {
    known: HashMap<(u32, Cell), Kept>,
    points: usize,
    /// Counts the calls of [`Refinement::bricks`].
    time: u64,
}

struct Kept {
    brick: Arc<Brick>,
    used: u64,
}

impl Refinement {
    /// The refinement of a stock that [`blue_noise`](super::blue_noise) baked with these settings on this mesh; `None` if it
    /// has no stipples.
    pub fn new(mesh: Arc<Mesh>, stock: &Stock, settings: BakeSettings) -> Option<Refinement> {
        let baked = stock.baked.clone();
        let complete = *baked.radius.last()?;
        let surface = MeshSurface::new(mesh);
        let area = surface.area();
        let least = 1.0 - spread(settings.regularity);
        let whole = |stage: &u32| first_distance(area, *stage) as f32 * least >= complete;
        let first = (0..=LAST_STAGE + 1).take_while(whole).last()?;
        let mut refinement = Refinement {
            surface,
            settings,
            baked,
            first,
            complete,
            base: HashMap::new(),
            bricks: Mutex::default(),
        };
        let mut base: HashMap<Cell, Vec<Site>> = HashMap::new();
        let mesh = refinement.surface.mesh();
        let baked = &refinement.baked;
        for i in 0..baked.len() {
            // Stipples of later stages come again with their stage.
            if baked.id[i] >> 32 < u64::from(first) {
                let site = site(mesh, baked.element[i], baked.weights[i]);
                let cell = refinement.cell(first, Vec3::from_array(site.position));
                base.entry(cell).or_default().push(site);
            }
        }
        refinement.base = base;
        Some(refinement)
    }

    /// Whether it continues this bake with these settings.
    pub fn continues(&self, baked: &Arc<Baked>, settings: &BakeSettings) -> bool {
        let same = |s: &BakeSettings| (s.regularity.to_bits(), s.seed);
        Arc::ptr_eq(&self.baked, baked) && same(&self.settings) == same(settings)
    }

    /// The mesh, in the pose that it was baked in.
    pub fn mesh(&self) -> &Mesh {
        self.surface.mesh()
    }

    /// The first stage that the stock does not hold completely, and the last that there is.
    pub fn stages(&self) -> std::ops::RangeInclusive<u32> {
        self.first..=LAST_STAGE
    }

    /// Every point of at least this radius is in the stock, object units.
    pub fn complete(&self) -> f32 {
        self.complete
    }

    /// The largest radius of a stage's points, object units: where a frame asks for no smaller spacing, the stage has
    /// nothing to show.
    pub fn reach(&self, stage: u32) -> f32 {
        reach(self.surface.area(), stage)
    }

    /// The brick of a stage in which a place lies.
    pub fn cell(&self, stage: u32, place: Vec3) -> Cell {
        let from_corner = place - self.surface.min_corner();
        (from_corner / self.side(stage)).floor().to_array().map(|v| v as i32)
    }

    fn side(&self, stage: u32) -> f32 {
        BRICK * self.reach(stage)
    }

    /// The corners of a brick, and of it and `more` on all sides.
    fn corners(&self, stage: u32, cell: Cell, more: f32) -> [Vec3; 2] {
        let side = self.side(stage);
        let low = self.surface.min_corner() + Vec3::from_array(cell.map(|v| v as f32)) * side;
        [low - more, low + side + more]
    }

    /// The bricks of a stage that a box meets.
    fn cells(&self, stage: u32, [low, high]: [Vec3; 2]) -> impl Iterator<Item = Cell> + use<> {
        let (a, b) = (self.cell(stage, low), self.cell(stage, high));
        (a[0]..=b[0])
            .flat_map(move |x| (a[1]..=b[1]).flat_map(move |y| (a[2]..=b[2]).map(move |z| [x, y, z])))
    }

    /// What a brick must know of earlier stages: everything in this box.
    fn surroundings(&self, stage: u32, cell: Cell) -> [Vec3; 2] {
        self.corners(stage, cell, (RIM + 1.0) * self.reach(stage))
    }

    /// The stipples of a stage in some bricks, one after the other. What has been found before is kept as long as there is
    /// room for it.
    ///
    /// # Panics
    /// If there is no such stage.
    pub fn bricks(&self, stage: u32, cells: &[Cell]) -> Vec<Arc<Brick>> {
        assert!(self.stages().contains(&stage), "stage {stage}");
        let time = {
            let mut bricks = self.lock();
            bricks.time += 1;
            bricks.time
        };
        // Of each stage the bricks that this one, or a later one, looks at.
        let mut wanted: Vec<BTreeSet<Cell>> = vec![BTreeSet::new(); (stage - self.first + 1) as usize];
        wanted[(stage - self.first) as usize].extend(cells);
        for later in (self.first + 1..=stage).rev() {
            let missing: Vec<Cell> = {
                let bricks = self.lock();
                let there = |cell: &&Cell| !bricks.known.contains_key(&(later, **cell));
                wanted[(later - self.first) as usize].iter().filter(there).copied().collect()
            };
            for cell in missing {
                let around = self.surroundings(later, cell);
                for earlier in self.first..later {
                    wanted[(earlier - self.first) as usize].extend(self.cells(earlier, around));
                }
            }
        }
        for (stage, wanted) in (self.first..).zip(&wanted) {
            let missing: Vec<Cell> = {
                let mut bricks = self.lock();
                wanted
                    .iter()
                    .copied()
                    .filter(|&cell| match bricks.known.get_mut(&(stage, cell)) {
                        Some(kept) => {
                            kept.used = time;
                            false
                        }
                        None => true,
                    })
                    .collect()
            };
            let made: Vec<Brick> = missing.par_iter().map(|&cell| self.run(stage, cell)).collect();
            let mut bricks = self.lock();
            for (cell, brick) in missing.into_iter().zip(made) {
                bricks.points += brick.sites.len();
                bricks.known.insert((stage, cell), Kept { brick: Arc::new(brick), used: time });
            }
        }
        let mut bricks = self.lock();
        let found = cells.iter().map(|&cell| {
            let kept = bricks.known.get(&(stage, cell));
            kept.map_or_else(Arc::default, |kept| kept.brick.clone())
        });
        let found = found.collect();
        bricks.forget(time);
        found
    }

    /// Runs a stage in a brick; those of earlier stages around it are known.
    fn run(&self, number: u32, cell: Cell) -> Brick {
        let around = self.surroundings(number, cell);
        let mut points = Accepted::default();
        let inside = |p: [f32; 3], [low, high]: [Vec3; 2]| {
            let p = Vec3::from_array(p);
            p.cmpge(low).all() && p.cmple(high).all()
        };
        for cell in self.cells(self.first, around) {
            let here = self.base.get(&cell).map_or(&[][..], Vec::as_slice);
            points.site.extend(here.iter().filter(|s| inside(s.position, around)));
        }
        for earlier in self.first..number {
            let cells: Vec<Cell> = self.cells(earlier, around).collect();
            let bricks: Vec<Arc<Brick>> = {
                let known = &self.lock().known;
                cells.iter().filter_map(|&c| known.get(&(earlier, c))).map(|k| k.brick.clone()).collect()
            };
            for brick in bricks {
                points.site.extend(brick.sites.iter().filter(|s| inside(s.position, around)));
            }
        }
        let before = points.site.len();
        let stage = Stage::new(&self.surface, &self.settings, number, before);
        let corners = self.corners(number, cell, RIM * stage.reach);
        let ranges: Vec<_> =
            self.surface.ranges_near(stage.draw, corners).into_iter().flat_map(chunks).collect();
        if ranges.is_empty() {
            // Beside the surface.
            return Brick::default();
        }
        run_stage(&self.surface, &stage, stage.t1, &Part { ranges, corners }, &mut points);
        // Accepted ones follow the given ones, of which no more than their sites is known.
        let mut brick = Brick::default();
        for (i, site) in points.site[before..].iter().enumerate() {
            if self.cell(number, Vec3::from_array(site.position)) != cell {
                continue;
            }
            brick.sites.push(*site);
            if points.radius[i] < self.complete {
                brick.baked.radius.push(points.radius[i]);
                brick.baked.id.push(points.id[i]);
                brick.baked.element.push(points.element[i]);
                brick.baked.weights.push(points.weights[i]);
            }
        }
        brick.baked.area = self.surface.area();
        brick
    }

    fn lock(&self) -> MutexGuard<'_, Bricks> {
        // Bricks are put in whole: what a panic left behind is still right.
        self.bricks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Bricks {
    /// Forgets what was used longest ago, if there is too much.
    fn forget(&mut self, time: u64) {
        if self.points <= KEPT_POINTS {
            return;
        }
        let mut used: Vec<u64> = self.known.values().map(|k| k.used).collect();
        used.sort_unstable();
        // The older half, but nothing of these last calls.
        let limit = used[used.len() / 2].min(time.saturating_sub(64));
        self.known.retain(|_, kept| kept.used > limit);
        self.points = self.known.values().map(|k| k.brick.sites.len()).sum();
    }
}

fn site(mesh: &Mesh, element: u32, [v, w]: [f32; 2]) -> Site {
    let [a, b, c] = mesh.triangles[element as usize].map(|v| mesh.positions[v as usize]);
    let (ab, ac) = (b - a, c - a);
    Site::new(a + ab * v + ac * w, ab.cross(ac).normalize_or_zero())
}

#[cfg(test)]
mod tests {
    use dotwork_drawing::Warnings;
    use dotwork_mesh::{MeshOptions, RawMesh, shapes};

    use super::super::blue_noise;
    use super::*;

    fn mesh(raw: RawMesh) -> Arc<Mesh> {
        Arc::new(Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap())
    }

    fn bake(mesh: &Mesh, stipples: usize) -> Stock {
        let settings = BakeSettings { stipples, seed: 5, ..BakeSettings::default() };
        Stock::on_mesh(blue_noise(&MeshSurface::new(mesh), &settings, |_| ()), mesh)
    }

    /// All stipples that a refinement of `stock` adds down to `radius` inside a box.
    fn refined(refinement: &Refinement, radius: f32, corners: [Vec3; 2]) -> Vec<(u64, f32, Vec3)> {
        let mut found = Vec::new();
        for stage in refinement.stages().take_while(|&s| refinement.reach(s) > radius) {
            let cells: Vec<Cell> = refinement.cells(stage, corners).collect();
            for brick in refinement.bricks(stage, &cells) {
                let here = Stock::on_mesh(brick.baked.clone(), refinement.mesh());
                for i in 0..here.len() {
                    let p = here.position.at(i);
                    if here.baked.radius[i] > radius && p.cmpge(corners[0]).all() && p.cmple(corners[1]).all()
                    {
                        found.push((here.baked.id[i], here.baked.radius[i], p));
                    }
                }
            }
        }
        found
    }

    #[test]
    fn a_region_gets_what_a_larger_bake_would_give() {
        let settings = BakeSettings { seed: 5, ..BakeSettings::default() };
        for (raw, corners) in [
            (shapes::plate(1, 1), [Vec3::new(0.3, 0.3, -1.0), Vec3::new(0.55, 0.5, 1.0)]),
            (shapes::torus(1.0, 0.4, 60, 30), [Vec3::new(0.9, -0.4, -0.5), Vec3::new(1.5, 0.4, 0.5)]),
        ] {
            let mesh = mesh(raw);
            let (stock, large) = (bake(&mesh, 3000), bake(&mesh, 100_000));
            let refinement = Refinement::new(mesh.clone(), &stock, settings).unwrap();
            let last = large.baked.radius[large.len() - 1];
            let found: HashMap<u64, f32> =
                refined(&refinement, last, corners).into_iter().map(|(id, radius, _)| (id, radius)).collect();
            let inside = |i: &usize| {
                let p = large.position.at(*i);
                p.cmpge(corners[0]).all() && p.cmple(corners[1]).all()
            };
            let expected: Vec<usize> = (stock.len()..large.len()).filter(inside).collect();
            let same = expected
                .iter()
                .filter(|&&i| found.get(&large.baked.id[i]) == Some(&large.baked.radius[i]))
                .count();
            assert!(expected.len() > 2500, "{}", expected.len());
            let (n, m) = (expected.len(), found.len());
            assert!(n - same <= n / 200 && m.abs_diff(n) <= n / 200, "{same} of {n}, {m} found");
        }
    }

    #[test]
    fn the_same_place_gets_the_same_stipples_however_it_is_come_to() {
        let mesh = mesh(shapes::sphere(4));
        let stock = bake(&mesh, 2000);
        let settings = BakeSettings { seed: 5, ..BakeSettings::default() };
        let make = || Refinement::new(mesh.clone(), &stock, settings).unwrap();
        let small = [Vec3::new(-0.02, 0.9, -0.02), Vec3::new(0.02, 1.1, 0.02)];
        let large = [Vec3::new(-0.3, 0.8, -0.3), Vec3::new(0.3, 1.1, 0.3)];
        let direct = refined(&make(), 0.001, small);
        let other = make();
        let (_, after) = (refined(&other, 0.004, large), refined(&other, 0.001, small));
        assert!(direct.len() > 500 && direct == after);
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(direct, alone.install(|| refined(&make(), 0.001, small)));
        // They are even, and far from those of the stock.
        let ids: BTreeSet<u64> = direct.iter().map(|d| d.0).collect();
        assert_eq!(ids.len(), direct.len());
        let near = |p: Vec3, q: Vec3, radius: f32| p.distance(q) < 0.999 * radius;
        let close = direct.iter().enumerate().filter(|(i, (_, radius, p))| {
            direct[..*i].iter().any(|(_, r, q)| near(*p, *q, radius.min(*r)))
                || (0..stock.len()).any(|k| near(*p, stock.position.at(k), *radius))
        });
        assert!(close.count() <= direct.len() / 200);
    }

    #[test]
    fn no_more_is_kept_than_there_is_room_for() {
        let mut bricks = Bricks::default();
        for k in 0..1000 {
            let sites = vec![Site::new(Vec3::ZERO, Vec3::Z); 10_000];
            let brick = Arc::new(Brick { sites, ..Brick::default() });
            bricks.known.insert((9, [k, 0, 0]), Kept { brick, used: k as u64 });
            bricks.points += 10_000;
            bricks.forget(k as u64);
            assert!(bricks.points <= KEPT_POINTS + 10_000 && bricks.known.contains_key(&(9, [k, 0, 0])));
        }
    }
}
