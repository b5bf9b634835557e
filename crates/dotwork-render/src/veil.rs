//! What translucent matter lies between a place and the eye.
//!
//! A place deep in a translucent body is drawn with fewer dots: its tone is multiplied by the transmittance
//! `exp(−∫ opacity)` along the line of sight (Lu's volumes have none; this is Levoy's and Max's absorption, with an
//! opacity that is a step at the surface). The bodies are closed surfaces, so the integral needs no marching through a
//! volume: every crossing of the line of sight with a surface enters or leaves matter, and up to depth `d` the optical
//! depth is `Σ wᵢ (d − zᵢ)` over the crossings before it, w the body's opacity per unit of length, positive where the
//! line enters. A buffer keeps all crossings of each pixel (an A-buffer, Carpenter 1984). What hides is therefore the
//! very surface that dots sit on, and the sum varies smoothly with the view.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use dotwork_drawing::View;
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// Triangles a task draws.
const CHUNK: usize = 1024;

/// The buffer has at most this many pixels along the longer side of the page: transmittance is smooth.
const MOST_PIXELS: f32 = 1024.0;

/// Crossings above which the buffer is made coarser: a gigabyte while it is made.
const MOST_CROSSINGS: u64 = 1 << 26;

/// A crossing of a line of sight with a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Crossing {
    depth: f32,
    /// Opacity per unit of length, positive where the line enters matter.
    weight: f32,
}

/// All crossings of a frame.
#[derive(Default)]
pub(crate) struct Veil {
    width: usize,
    height: usize,
    /// Pixels of the buffer for one of the page.
    scale: f32,
    /// Where each pixel's crossings begin; one more at the end.
    start: Vec<u32>,
    crossings: Vec<Crossing>,
    /// Counters of the pass at work.
    count: Vec<AtomicU32>,
    projected: Vec<Vec3>,
}

/// A body and its opacity per object unit of length.
#[derive(Clone, Copy)]
pub(crate) struct Body<'a> {
    pub mesh: &'a Mesh,
    pub opacity: f32,
}

impl Veil {
    /// Itself, if anything was drawn.
    pub fn thinning(&self) -> Option<&Veil> {
        (!self.crossings.is_empty()).then_some(self)
    }

    /// Forgets everything.
    fn clear(&mut self) {
        self.crossings.clear();
        self.start.clear();
    }

    /// Draws bodies for a page of `width` × `height` pixels. Open surfaces are left out: they hold no matter.
    pub fn draw(&mut self, bodies: &[Body], view: &View, width: u32, height: u32) {
        self.draw_within(bodies, view, width, height, MOST_CROSSINGS);
    }

    fn draw_within(&mut self, bodies: &[Body], view: &View, width: u32, height: u32, most: u64) {
        self.clear();
        let closed: Vec<&Body> = bodies.iter().filter(|b| b.mesh.closed && b.opacity > 0.0).collect();
        if closed.is_empty() || width == 0 || height == 0 {
            return;
        }
        self.scale = (MOST_PIXELS / width.max(height) as f32).min(1.0);
        let all = loop {
            self.width = (width as f32 * self.scale).ceil() as usize;
            self.height = (height as f32 * self.scale).ceil() as usize;
            let all = self.count_crossings(&closed, view);
            if all <= most || self.width * self.height == 1 {
                break all;
            }
            self.scale *= 0.5;
        };
        // Counts fit what holds them.
        let Ok(all) = u32::try_from(all) else { return };
        let pixels = self.width * self.height;
        let mut total = 0u32;
        self.start.reserve(pixels + 1);
        for count in &mut self.count {
            self.start.push(total);
            // From now on the counter is the place of the pixel's next crossing.
            total += std::mem::replace(count.get_mut(), total);
        }
        self.start.push(total);
        let slots: Vec<[AtomicU32; 2]> =
            (0..all).into_par_iter().map(|_| [AtomicU32::new(0), AtomicU32::new(0)]).collect();
        for body in &closed {
            self.project(body.mesh, view);
            let count = &self.count;
            self.visit(body, |pixel, crossing| {
                let slot = &slots[count[pixel].fetch_add(1, Relaxed) as usize];
                slot[0].store(crossing.depth.to_bits(), Relaxed);
                slot[1].store(crossing.weight.to_bits(), Relaxed);
            });
        }
        self.crossings = slots
            .into_par_iter()
            .map(|[depth, weight]| Crossing {
                depth: f32::from_bits(depth.into_inner()),
                weight: f32::from_bits(weight.into_inner()),
            })
            .collect();
        // Threads came in any order; the nearest first is one order only.
        let mut rest = &mut self.crossings[..];
        let mut rows = Vec::with_capacity(self.height);
        for row in self.start[..pixels].chunks(self.width) {
            let first = row[0];
            let last = rows.len() + 1;
            let end = self.start[last * self.width];
            let (own, after) = rest.split_at_mut((end - first) as usize);
            rows.push((first, row, end, own));
            rest = after;
        }
        rows.into_par_iter().for_each(|(first, row, end, own)| {
            for (k, &from) in row.iter().enumerate() {
                let to = row.get(k + 1).copied().unwrap_or(end);
                own[(from - first) as usize..(to - first) as usize]
                    .sort_unstable_by(|a, b| a.depth.total_cmp(&b.depth).then(a.weight.total_cmp(&b.weight)));
            }
        });
    }

    /// Counts the crossings of each pixel, and returns how many there are.
    fn count_crossings(&mut self, bodies: &[&Body], view: &View) -> u64 {
        self.count.resize_with(self.width * self.height, AtomicU32::default);
        self.count.par_iter_mut().for_each(|c| *c.get_mut() = 0);
        for body in bodies {
            self.project(body.mesh, view);
            let count = &self.count;
            self.visit(body, |pixel, _| {
                count[pixel].fetch_add(1, Relaxed);
            });
        }
        self.count.par_iter_mut().map(|c| u64::from(*c.get_mut())).sum()
    }

    fn project(&mut self, mesh: &Mesh, view: &View) {
        let scale = self.scale;
        let project = |&p: &Vec3| {
            let (x, y, depth) = view.project(p);
            Vec3::new(x * scale, y * scale, depth)
        };
        mesh.positions.par_iter().with_min_len(4096).map(project).collect_into_vec(&mut self.projected);
    }

    /// Calls `sink` with every pixel whose centre a triangle covers, and the crossing there.
    fn visit(&self, body: &Body, sink: impl Fn(usize, Crossing) + Sync) {
        body.mesh.triangles.par_chunks(CHUNK).for_each(|triangles| {
            for triangle in triangles {
                let corners = triangle.map(|v| self.projected[v as usize]);
                self.fill(corners, body.opacity, &sink);
            }
        });
    }

    #[inline(always)]
    fn fill(&self, [a, b, c]: [Vec3; 3], opacity: f32, sink: &impl Fn(usize, Crossing)) {
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        // The first and one past the last pixel whose centre may lie inside; casts saturate.
        let x0 = (low.x - 0.5).ceil().max(0.0) as usize;
        let x1 = ((high.x - 0.5).floor() + 1.0).clamp(0.0, self.width as f32) as usize;
        let y0 = (low.y - 0.5).ceil().max(0.0) as usize;
        let y1 = ((high.y - 0.5).floor() + 1.0).clamp(0.0, self.height as f32) as usize;
        // In double precision and with a rule for edges, so that every pixel's line crosses a closed surface an even
        // number of times.
        let at = |p: Vec3| [f64::from(p.x), f64::from(p.y)];

        let [pa, pb, pc] = [a, b, c].map(at);
        let area = side_of(pa, pb, pc[0], pc[1]);
        if x0 >= x1 || y0 >= y1 || area == 0.0 {
            return;
        }
        // y points down: a triangle that faces the eye has negative area.
        let weight = if area < 0.0 { opacity } else { -opacity };
        let sign = area.signum();
        // An edge through a centre belongs to one of its two triangles: that for which it runs down, or left if level.
        let owns = |p: [f64; 2], q: [f64; 2]| {
            let (dx, dy) = ((q[0] - p[0]) * sign, (q[1] - p[1]) * sign);
            dy > 0.0 || (dy == 0.0 && dx < 0.0)
        };
        let edges = [(pb, pc), (pc, pa), (pa, pb)].map(|(p, q)| (p, q, owns(p, q)));
        for y in y0..y1 {
            for x in x0..x1 {
                let (cx, cy) = (x as f64 + 0.5, y as f64 + 0.5);
                let w = edges.map(|(p, q, _)| side_of(p, q, cx, cy) * sign);
                if (0..3).all(|k| w[k] > 0.0 || (w[k] == 0.0 && edges[k].2)) {
                    let sum = w[0] + w[1] + w[2];
                    let depth = (w[0] * f64::from(a.z) + w[1] * f64::from(b.z) + w[2] * f64::from(c.z)) / sum;
                    sink(y * self.width + x, Crossing { depth: depth as f32, weight });
                }
            }
        }
    }

    /// The share of a place's ink that comes through, 0…1: 1 where nothing lies before it. `x`, `y` and `depth`: the
    /// place as projected onto the page, lifted a little off its own surface.
    pub fn transmittance(&self, x: f32, y: f32, depth: f32) -> f32 {
        if self.crossings.is_empty() {
            return 1.0;
        }
        let (gx, gy) = (x * self.scale - 0.5, y * self.scale - 0.5);
        let (fx, fy) = (gx.floor(), gy.floor());
        let (tx, ty) = (gx - fx, gy - fy);
        let mut sum = 0.0;
        for (dy, wy) in [(0.0, 1.0 - ty), (1.0, ty)] {
            for (dx, wx) in [(0.0, 1.0 - tx), (1.0, tx)] {
                sum += wx * wy * self.through(fx + dx, fy + dy, depth);
            }
        }
        sum
    }

    /// Transmittance at a pixel's centre.
    fn through(&self, x: f32, y: f32, depth: f32) -> f32 {
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f32 && y < self.height as f32) {
            return 1.0;
        }
        let pixel = y as usize * self.width + x as usize;
        let list = &self.crossings[self.start[pixel] as usize..self.start[pixel + 1] as usize];
        let before = list.iter().take_while(|c| c.depth < depth);
        let optical: f32 = before.map(|c| c.weight * (depth - c.depth)).sum();
        (-optical.max(0.0)).exp()
    }
}

/// Twice the signed area of a point with an edge. Antisymmetric to the last bit: the edge's ends are always taken in the
/// same order, so that neighbours agree on which side a centre lies.
#[inline(always)]
fn side_of(p: [f64; 2], q: [f64; 2], x: f64, y: f64) -> f64 {
    let cross = |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    if (p[0], p[1]) <= (q[0], q[1]) { cross(p, q) } else { -cross(q, p) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::{Camera, Page, Warnings};
    use dotwork_mesh::{MeshOptions, shapes};

    fn mesh(name: &str) -> Mesh {
        Mesh::build(shapes::demo(name).unwrap(), &MeshOptions::default(), &mut Warnings::new()).unwrap()
    }

    fn view(ortho: bool) -> (View, Page) {
        let page = Page { width: 200, height: 150, ..Page::default() };
        (Camera { ortho, ..Camera::default() }.view(Vec3::ZERO, 1.0, &page), page)
    }

    #[test]
    fn a_sphere_absorbs_by_its_chord() {
        let sphere = mesh("sphere");
        for ortho in [false, true] {
            let (view, page) = view(ortho);
            let mut veil = Veil::default();
            veil.draw(&[Body { mesh: &sphere, opacity: 0.7 }], &view, page.width, page.height);
            let behind = view.distance + 2.0;
            for pixel in 0..200 * 150 {
                let (x, y) = ((pixel % 200) as f32 + 0.5, (pixel / 200) as f32 + 0.5);
                let list = &veil.crossings[veil.start[pixel] as usize..veil.start[pixel + 1] as usize];
                let weight: f32 = list.iter().map(|c| c.weight).sum();
                assert!(weight == 0.0 && list.len().is_multiple_of(2), "what is entered is left: {list:?}");
                if ortho {
                    let scale = view.px_per_unit(view.distance);
                    let square = ((x - view.cx).powi(2) + (y - view.cy).powi(2)) / (scale * scale);
                    let chord = 2.0 * (1.0 - square).max(0.0).sqrt();
                    let wanted = (-0.7 * chord).exp();
                    let found = veil.transmittance(x, y, behind);
                    assert!((found - wanted).abs() < 0.01 || square > 0.97, "{x} {y}: {found} {wanted}");
                    // Half way in, half the optical depth.
                    let middle = veil.transmittance(x, y, view.distance);
                    assert!((middle * middle - wanted).abs() < 0.01 || square > 0.97);
                    assert_eq!(veil.transmittance(x, y, view.distance - 1.5), 1.0);
                }
            }
        }
    }

    #[test]
    fn bodies_add_up_and_open_surfaces_hold_nothing() {
        let (sphere, torus, plate) = (mesh("sphere"), mesh("torus"), mesh("plate"));
        let (view, page) = view(false);
        let through = |bodies: &[Body], x: f32, y: f32| {
            let mut veil = Veil::default();
            veil.draw(bodies, &view, page.width, page.height);
            veil.transmittance(x, y, view.distance + 2.0)
        };
        let (a, b) = (Body { mesh: &sphere, opacity: 0.3 }, Body { mesh: &torus, opacity: 0.9 });
        for (x, y) in [(100.0, 75.0), (130.0, 75.0), (90.0, 40.0), (100.0, 120.0)] {
            let product = through(&[a], x, y) * through(&[b], x, y);
            assert!((through(&[a, b], x, y) - product).abs() < 0.02, "{x} {y}");
        }
        assert_eq!(through(&[Body { mesh: &plate, opacity: 1.0 }], 100.0, 75.0), 1.0);
        assert_eq!(through(&[Body { mesh: &sphere, opacity: 0.0 }], 100.0, 75.0), 1.0);
    }

    #[test]
    fn too_many_crossings_make_it_coarser() {
        let sphere = mesh("sphere");
        let (view, page) = view(true);
        let body = [Body { mesh: &sphere, opacity: 0.7 }];
        let mut veil = Veil::default();
        let wanted = (-1.4f32).exp();
        for (most, scale) in [(1_000_000, 1.0), (10_000, 0.5), (3000, 0.25), (1, 1.0 / 256.0)] {
            veil.draw_within(&body, &view, page.width, page.height, most);
            assert_eq!(veil.scale, scale, "{most}: {}", veil.crossings.len());
            let found = veil.transmittance(view.cx, view.cy, view.distance + 2.0);
            assert!(scale < 0.01 || (found - wanted).abs() < 0.01, "{most}: {found} {wanted}");
        }
    }

    #[test]
    fn the_same_on_any_number_of_threads() {
        let torus = mesh("torus");
        let (view, page) = view(false);
        let draw = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut veil = Veil::default();
            let body = Body { mesh: &torus, opacity: 1.0 };
            pool.install(|| veil.draw(&[body], &view, page.width, page.height));
            (veil.start, veil.crossings)
        };
        assert!(draw(1) == draw(3));
    }
}
