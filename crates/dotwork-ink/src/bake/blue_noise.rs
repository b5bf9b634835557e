//! The `blue-noise` bake: one progressive, even order of points over a whole surface.
//!
//! Each point is the candidate farthest from all earlier points (farthest-point order, Eldar et al., "The farthest
//! point strategy for progressive image sampling", 1997), so that every prefix is evenly spread and the distance at
//! acceptance, the point's *radius*, falls along the order. (Below full regularity the radius is a random share of that
//! distance.) Exact greedy selection is made parallel by local maxima: a candidate that lies outside the distance of
//! every candidate that ranks higher would be chosen before anything that could change it, and changes nothing that
//! would be chosen before it.
//!
//! Steps. Distances fall by √2 from stage to stage. A stage draws fresh candidates uniform by area, keeps those at
//! least the stage's last distance from all earlier points, and accepts local maxima in rounds. Stage `k`, its
//! candidates and its ties depend on `k`, the seed and the surface alone, so a larger bake begins with the points of a
//! smaller one, and a later refinement of a region finds the same points.
//!
//! Cost: about 12 candidates for each point, each compared with the points around it; memory about
//! 100 bytes a point at the last stage.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use dotwork_drawing::hash::{hash2, unit};
use glam::Vec3;
use rayon::prelude::*;

use super::buckets::{BLOCK_CELLS, Grid, Site, Starts};
use crate::stock::Baked;
use crate::surface::{StageDraw, Surface, hash_of};

/// Distances fall by this factor from stage to stage.
const STAGE_FACTOR: f64 = std::f64::consts::SQRT_2;

/// First distance of the first stage, over the square root of the area. A stage's candidates are all drawn even where
/// few points are wanted of it: with this value stages end at 156,000 stipples times powers of two, a little above
/// the numbers that people ask for.
const FIRST_DISTANCE: f64 = 0.588;

/// Candidates for each square of the stage's last distance, over all of the surface. More give a more even order.
const CANDIDATES: f64 = 3.4;

/// Fewest candidates of a stage: small stages need more choice.
const MIN_CANDIDATES: f64 = 2000.0;

/// Distances beyond this multiple of the stage's first distance count as equal: cells can be that small.
const CLAMP: f32 = 1.12;

/// At regularity 0 a point's radius is its distance times a random factor down to this.
const LOOSEST: f32 = 0.4;

/// Most stages: distances then have fallen by 2³⁰.
const MAX_STAGES: u32 = 60;

/// Most stipples a bake makes.
pub const MAX_STIPPLES: usize = 50_000_000;

/// What a bake is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Number of stipples; the bake has exactly this many unless the surface is degenerate.
    pub stipples: usize,
    /// 0 looser and hand-like … 1 as even as possible.
    pub regularity: f32,
    /// Seed of every random choice.
    pub seed: u32,
}

impl Default for BakeSettings {
    fn default() -> Self {
        BakeSettings { stipples: 100_000, regularity: 1.0, seed: 0 }
    }
}

/// A candidate that may still be accepted.
#[derive(Clone, Copy)]
struct Candidate {
    site: Site,
    /// Squared distance to the nearest point so far, as ordered bits.
    d2: f32,
    index: u64,
    element: u32,
    weights: [f32; 2],
}

/// The points accepted so far, in structure-of-arrays form.
#[derive(Default)]
pub(super) struct Accepted {
    pub site: Vec<Site>,
    pub radius: Vec<f32>,
    /// What [`id_of`] makes of stage and candidate.
    pub id: Vec<u64>,
    pub element: Vec<u32>,
    pub weights: Vec<[f32; 2]>,
}

impl Accepted {
    fn truncate(&mut self, n: usize) {
        self.site.truncate(n);
        self.radius.truncate(n);
        self.id.truncate(n);
        self.element.truncate(n);
        self.weights.truncate(n);
    }
}

/// How much later than its distance allows a point enters: looser orders leave gaps, as a hand does.
#[derive(Clone, Copy)]
struct Looseness {
    spread: f32,
    seed: u32,
}

impl Looseness {
    /// Factor on the radius of candidate `index`, at most 1.
    fn factor(&self, index: u64) -> f32 {
        1.0 - self.spread * unit(hash_of(index, self.seed))
    }
}

/// The stage's numbers.
pub(super) struct Stage {
    number: u32,
    pub draw: StageDraw,
    /// Last distance.
    pub t1: f32,
    grid: Grid,
    looseness: Looseness,
    /// Distances are compared up to this.
    pub reach: f32,
}

/// The distance at which stage `number` begins; it ends where the next one begins.
pub(super) fn first_distance(area: f64, number: u32) -> f64 {
    FIRST_DISTANCE * area.sqrt() / STAGE_FACTOR.powi(number as i32)
}

/// The largest distance that stage `number` tells apart from larger ones, and so its points' largest radius.
pub(super) fn reach(area: f64, number: u32) -> f32 {
    CLAMP * first_distance(area, number) as f32
}

/// Stages of [`MAX_STIPPLES`], and as many candidates as an id can tell apart.
const MAX_INDEX: u64 = 1 << 34;

/// A stipple's id, below 2³⁸: the stage in its high bits, the candidate in its low 32. From stage 28 on, where there are
/// more candidates than that, both ones at its top and the stage in the two bits below them.
fn id_of(stage: u32, index: u64) -> u64 {
    if index < 1 << 32 {
        u64::from(stage) << 32 | index
    } else {
        3 << 36 | u64::from(stage & 3) << 34 | index
    }
}

/// How much a point's radius may fall short of its distance, as a share.
pub(super) fn spread(regularity: f32) -> f32 {
    (1.0 - LOOSEST) * (1.0 - regularity.clamp(0.0, 1.0))
}

impl Stage {
    pub fn new(surface: &impl Surface, settings: &BakeSettings, number: u32, earlier: usize) -> Stage {
        let area = surface.area();
        let t1 = first_distance(area, number + 1);
        let count = (CANDIDATES * area / (t1 * t1)).max(MIN_CANDIDATES).min(MAX_INDEX as f64) as u64;
        let spread = spread(settings.regularity);
        let reach = reach(area, number);
        Stage {
            number,
            draw: StageDraw { count, seed: hash2(number, settings.seed) },
            t1: t1 as f32,
            grid: Grid::new(surface.min_corner(), reach, earlier),
            looseness: Looseness { spread, seed: hash2(number, !settings.seed) },
            reach,
        }
    }
}

/// Bakes `settings.stipples` points on `surface` in blue-noise order.
///
/// The result is the same for any number of threads. `progress` is called with a share 0…1 of the points and may be
/// called from the calling thread only.
pub fn blue_noise(surface: &impl Surface, settings: &BakeSettings, mut progress: impl FnMut(f32)) -> Baked {
    let wanted = settings.stipples.min(MAX_STIPPLES);
    let area = surface.area();
    let mut points = Accepted::default();
    let mut number = 0;
    while number < MAX_STAGES {
        let stage = Stage::new(surface, settings, number, points.site.len());
        // Later stages accept distances up to this one, so all points above it are known after this stage.
        let complete = reach(area, number + 1);
        let end = predict_end(&points.radius, wanted).filter(|&end| end > complete);
        let before = points.site.len();
        run_stage(surface, &stage, end.unwrap_or(0.0).max(stage.t1), &everywhere(&stage), &mut points);
        number += 1;
        if let Some(end) = end {
            if points.radius.iter().filter(|&&r| r >= end).count() >= wanted {
                break;
            }
            // The prediction fell short, which the count's ripple makes rare: run the stage to its own end.
            points.truncate(before);
            run_stage(surface, &stage, stage.t1, &everywhere(&stage), &mut points);
        }
        if points.radius.iter().filter(|&&r| r > complete).count() >= wanted {
            break;
        }
        progress((points.site.len() as f32 / wanted as f32).min(1.0));
    }
    finish(surface.area(), settings.seed, &points, wanted)
}

/// The distance at which `wanted` points will have been accepted, a little low; `None` while that is stages away.
///
/// The number of points at distance `d` is self-similar: half as many at `√2 d`, to within a fraction of a percent.
fn predict_end(radii: &[f32], wanted: usize) -> Option<f32> {
    let half = wanted / 2;
    if half < 500 || radii.len() <= half {
        return None;
    }
    let mut radii = radii.to_vec();
    let (_, &mut r, _) = radii.select_nth_unstable_by(half, |a, b| b.total_cmp(a));
    Some(0.99 * r / STAGE_FACTOR as f32)
}

/// Which candidates of a stage are drawn.
pub(super) struct Part {
    /// In chunks, rising.
    pub ranges: Vec<Range<u64>>,
    /// Of these, those between two corners.
    pub corners: [Vec3; 2],
}

/// Candidates that a task looks at.
const CHUNK: u64 = 1 << 14;

/// All candidates of a stage.
fn everywhere(stage: &Stage) -> Part {
    Part { ranges: chunks(0..stage.draw.count).collect(), corners: [Vec3::NEG_INFINITY, Vec3::INFINITY] }
}

pub(super) fn chunks(range: Range<u64>) -> impl Iterator<Item = Range<u64>> {
    let end = range.end;
    range.step_by(CHUNK as usize).map(move |from| from..(from + CHUNK).min(end))
}

/// Accepts this stage's points down to distance `end`, after the `points` of earlier stages.
pub(super) fn run_stage(surface: &impl Surface, stage: &Stage, end: f32, part: &Part, points: &mut Accepted) {
    let candidates = draw_candidates(surface, stage, end, part, points);
    let grid = Grid::new(surface.min_corner(), stage.reach, candidates.len());
    let buckets: Vec<u32> = candidates.par_iter().map(|c| grid.bucket(grid.cell(c.site.position))).collect();
    let (starts, places) = Starts::sort(&grid, &buckets);
    let mut sorted = candidates.clone();
    for (c, &at) in candidates.iter().zip(&places) {
        sorted[at as usize] = *c;
    }
    drop((candidates, places));
    let d2: Vec<AtomicU32> = sorted.par_iter().map(|c| AtomicU32::new(c.d2.to_bits())).collect();
    let mut live = buckets;
    live.par_sort_unstable();
    live.dedup();

    let search =
        Search { stage, grid: &grid, starts: &starts, candidates: &sorted, d2: &d2, end2: end * end };
    while !live.is_empty() {
        // Read: which candidates are local maxima, and which buckets are still alive?
        let found: Vec<(Vec<u32>, Vec<u32>)> = live
            .par_chunks(1024)
            .map(|chunk| {
                let (mut accepted, mut alive) = (Vec::new(), Vec::with_capacity(chunk.len()));
                for &bucket in chunk {
                    if let Some(champion) = search.champion(bucket) {
                        alive.push(bucket);
                        if search.is_local_maximum(champion) {
                            accepted.push(champion as u32);
                        }
                    }
                }
                (accepted, alive)
            })
            .collect();
        for (accepted, _) in &found {
            for &a in accepted {
                let c = &sorted[a as usize];
                points.site.push(c.site);
                let distance = f32::from_bits(d2[a as usize].load(Relaxed)).sqrt();
                points.radius.push(distance * stage.looseness.factor(c.index));
                points.id.push(id_of(stage.number, c.index));
                points.element.push(c.element);
                points.weights.push(c.weights);
            }
        }
        // Write: the accepted points come nearer to the candidates around them.
        found
            .par_iter()
            .for_each(|(accepted, _)| accepted.iter().for_each(|&a| search.lower_around(a as usize)));
        live.clear();
        live.extend(found.iter().flat_map(|(_, alive)| alive));
    }
}

/// Draws the stage's candidates and keeps those at least `end` away from all earlier points, with their distance.
fn draw_candidates(
    surface: &impl Surface,
    stage: &Stage,
    end: f32,
    part: &Part,
    points: &Accepted,
) -> Vec<Candidate> {
    let grid = &stage.grid;
    let buckets: Vec<u32> = points.site.par_iter().map(|s| grid.bucket(grid.cell(s.position))).collect();
    let (starts, places) = Starts::sort(grid, &buckets);
    let mut sorted = points.site.clone();
    for (s, &at) in points.site.iter().zip(&places) {
        sorted[at as usize] = *s;
    }
    let reach2 = stage.reach * stage.reach;
    let end2 = end * end;
    let [low, high] = part.corners;
    let chunks: Vec<Vec<Candidate>> = part
        .ranges
        .par_iter()
        .map(|range| {
            let mut kept = Vec::with_capacity((range.end - range.start) as usize / 3);
            // Candidates follow each other in space along a winding path: the points around the cells met lately are
            // kept at hand, one cell for each place inside a block.
            let mut near: [(Vec<Site>, [i32; 3]); BLOCK_CELLS as usize] =
                std::array::from_fn(|_| (Vec::new(), [i32::MIN; 3]));
            surface.visit(stage.draw, range.clone(), &mut |index, place| {
                if !(place.position.cmpge(low).all() && place.position.cmple(high).all()) {
                    return;
                }
                let site = Site::new(place.position, place.normal);
                let cell = grid.cell(site.position);
                let (near, near_cell) = &mut near[Grid::inside(cell) as usize];
                if cell != *near_cell {
                    *near_cell = cell;
                    near.clear();
                    starts.around(grid, cell, |run| {
                        // Runs are short: a loop beats a call that copies.
                        for site in &sorted[run] {
                            near.push(*site);
                        }
                        true
                    });
                }
                let mut d2 = reach2;
                for s in near.iter() {
                    let d = s.distance_squared(site.position);
                    if d < d2 && s.compatible(site.normal) {
                        d2 = d;
                        if d2 < end2 {
                            return;
                        }
                    }
                }
                kept.push(Candidate { site, d2, index, element: place.element, weights: place.weights });
            });
            kept
        })
        .collect();
    let mut all = Vec::with_capacity(chunks.iter().map(Vec::len).sum());
    for chunk in chunks {
        all.extend_from_slice(&chunk);
    }
    all
}

/// The candidates of a stage in bucket order, with the distances that the rounds lower.
struct Search<'a> {
    stage: &'a Stage,
    grid: &'a Grid,
    starts: &'a Starts,
    candidates: &'a [Candidate],
    d2: &'a [AtomicU32],
    /// Candidates ranking below this (a squared distance) are not accepted in this stage.
    end2: f32,
}

impl Search<'_> {
    /// What a candidate is ranked by, before a hash of the candidate: its squared distance.
    #[inline(always)]
    fn key(&self, i: usize) -> f32 {
        f32::from_bits(self.d2[i].load(Relaxed))
    }

    #[inline(always)]
    fn tie(&self, i: usize) -> u32 {
        hash_of(self.candidates[i].index, self.stage.draw.seed)
    }

    /// The highest-ranking candidate of a bucket that may still be accepted.
    fn champion(&self, bucket: u32) -> Option<usize> {
        let mut best = None;
        let mut best_key = self.end2;
        for i in self.starts.bucket(bucket) {
            let key = self.key(i);
            if key > best_key || (key == best_key && best.is_none_or(|b| self.tie(i) > self.tie(b))) {
                (best, best_key) = (Some(i), key);
            }
        }
        best
    }

    /// True if accepting `i` now is what the greedy order does: no candidate that ranks higher would come nearer to a
    /// point by it. (Looking only within `i`'s own distance would keep the spacing, but the radii would then depend on
    /// which of two such candidates its bucket lets go first.)
    fn is_local_maximum(&self, i: usize) -> bool {
        let key = self.key(i);
        let Site { position, normal } = self.candidates[i].site;
        self.starts.around(self.grid, self.grid.cell(position), |run| {
            for j in run {
                let other = self.key(j);
                if other >= key
                    && self.candidates[j].site.distance_squared(position) < other
                    && (other > key || self.tie(j) > self.tie(i))
                    && self.candidates[j].site.compatible(normal)
                {
                    return false;
                }
            }
            true
        })
    }

    /// Lowers the distances of the candidates around the accepted candidate `i`, and its own to zero.
    fn lower_around(&self, i: usize) {
        let Site { position, normal } = self.candidates[i].site;
        self.starts.around(self.grid, self.grid.cell(position), |run| {
            for j in run {
                let d = self.candidates[j].site.distance_squared(position);
                // Distances are not negative: their bits are ordered as they are.
                if d.to_bits() < self.d2[j].load(Relaxed) && self.candidates[j].site.compatible(normal) {
                    self.d2[j].fetch_min(d.to_bits(), Relaxed);
                }
            }
            true
        });
    }
}

/// Sorts the points into their order and cuts it to length.
fn finish(area: f64, seed: u32, points: &Accepted, wanted: usize) -> Baked {
    // Radius descending: the bits of a positive float are ordered as it is. Few radii are equal.
    let mut order: Vec<u64> = points
        .radius
        .par_iter()
        .enumerate()
        .map(|(i, radius)| u64::from(!radius.to_bits()) << 32 | i as u64)
        .collect();
    order.par_sort_unstable();
    let place = |key: &u64| *key as u32 as usize;
    // Then stage, then a hash: nothing depends on array places.
    for equal in order.chunk_by_mut(|a, b| a >> 32 == b >> 32).filter(|equal| equal.len() > 1) {
        equal.sort_unstable_by_key(|key| {
            let id = points.id[place(key)];
            (id >> 32, hash2(id as u32, seed), id as u32)
        });
    }
    order.truncate(wanted);
    Baked {
        radius: order.par_iter().map(|key| points.radius[place(key)]).collect(),
        id: order.par_iter().map(|key| points.id[place(key)]).collect(),
        element: order.par_iter().map(|key| points.element[place(key)]).collect(),
        weights: order.par_iter().map(|key| points.weights[place(key)]).collect(),
        neighbours: Vec::new(),
        area,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stock::Stock;
    use crate::surface::MeshSurface;
    use dotwork_drawing::Warnings;
    use dotwork_mesh::{Mesh, MeshOptions, RawMesh, shapes};

    fn mesh(raw: RawMesh) -> Mesh {
        Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
    }

    fn bake(mesh: &Mesh, stipples: usize, regularity: f32) -> Baked {
        blue_noise(&MeshSurface::new(mesh), &BakeSettings { stipples, regularity, seed: 7 }, |_| ())
    }

    /// Distance of each of the first `n` stipples to its nearest neighbour among them.
    fn nearest(stock: &Stock, n: usize) -> Vec<f32> {
        let at: Vec<Vec3> = (0..n).map(|i| stock.position.at(i)).collect();
        at.iter()
            .enumerate()
            .map(|(i, p)| {
                at.iter()
                    .enumerate()
                    .filter(|(j, _)| *j != i)
                    .map(|(_, q)| p.distance(*q))
                    .fold(f32::MAX, f32::min)
            })
            .collect()
    }

    #[test]
    fn any_two_stipples_keep_the_smaller_of_their_radii() {
        let mesh = mesh(shapes::torus(1.0, 0.4, 60, 30));
        for regularity in [0.0, 1.0] {
            let stock = Stock::on_mesh(bake(&mesh, 3000, regularity), &mesh);
            assert_eq!(stock.len(), 3000);
            assert!(stock.baked.radius.is_sorted_by(|a, b| a >= b));
            for i in 0..stock.len() {
                for j in 0..i {
                    let distance = stock.position.at(i).distance(stock.position.at(j));
                    if stock.facet.at(i).dot(stock.facet.at(j)) < -0.25 {
                        // The two sides of a sheet do not see each other.
                        continue;
                    }
                    // The radii fall: the later one's is the smaller. Positions are rounded once more than in the bake.
                    assert!(distance >= stock.baked.radius[i] * 0.999, "{i} {j}: {distance}");
                }
            }
        }
    }

    #[test]
    fn a_larger_bake_begins_with_a_smaller_one() {
        let mesh = mesh(shapes::sphere(4));
        let large = bake(&mesh, 30_000, 1.0);
        for n in [1, 2, 10, 500, 1999, 7000, 7100, 14_142, 29_999] {
            let small = bake(&mesh, n, 1.0);
            assert_eq!(small.id[..], large.id[..n], "{n}");
            assert_eq!(small.radius[..], large.radius[..n], "{n}");
        }
        let ids: std::collections::BTreeSet<u64> = large.id.iter().copied().collect();
        assert_eq!(ids.len(), 30_000);
        assert!(ids.iter().all(|id| *id < 1 << 38));
    }

    #[test]
    fn threads_do_not_matter() {
        let mesh = mesh(shapes::torus(1.0, 0.3, 40, 20));
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bake(&mesh, 20_000, 0.7))
        };
        assert_eq!(run(1), run(4));
    }

    #[test]
    fn regularity_runs_from_loose_to_even() {
        let mesh = mesh(shapes::plate(1, 1));
        let evenness = |regularity: f32| {
            let stock = Stock::on_mesh(bake(&mesh, 4000, regularity), &mesh);
            let hexagonal = (2.0 / (3f32.sqrt() * 2000.0)).sqrt();
            nearest(&stock, 2000).iter().sum::<f32>() / 2000.0 / hexagonal
        };
        let means = [0.0, 0.5, 1.0].map(evenness);
        // White noise has 0.47.
        assert!(means.is_sorted() && means[0] > 0.6 && means[0] < 0.75 && means[2] > 0.785, "{means:?}");
    }

    #[test]
    fn extreme_scales_and_shapes_bake() {
        for scale in [1e-9f32, 1e9] {
            let mut raw = shapes::sphere(2);
            raw.positions.iter_mut().flatten().for_each(|v| *v *= scale);
            assert_eq!(bake(&mesh(raw), 2000, 1.0).len(), 2000);
        }
        // A needle, and two specks far apart: memory follows the points, not the box.
        let needle = RawMesh {
            positions: vec![[0.0, 0.0, 0.0], [1e4, 0.0, 0.0], [5e3, 1e-3, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..RawMesh::default()
        };
        assert_eq!(bake(&mesh(needle), 3000, 1.0).len(), 3000);
        let mut specks = shapes::sphere(2);
        let n = specks.positions.len() as u32;
        let far: Vec<[f32; 3]> =
            specks.positions.iter().map(|[x, y, z]| [x + 1e5, y + 2e5, z - 1e5]).collect();
        specks.positions.extend(far);
        specks.triangles.extend(shapes::sphere(2).triangles.iter().map(|t| t.map(|v| v + n)));
        assert_eq!(bake(&mesh(specks), 20_000, 1.0).len(), 20_000);
    }
}
