//! Runs of voxels along x, and which of them hang together.
//!
//! Runs are joined by union–find with those that they touch in neighbouring rows, which visits each contact of two runs
//! once (Kesheng Wu, Ekow Otoo and Kenji Suzuki, *Optimizing Two-Pass Connected-Component Labeling Algorithms*, 2009,
//! has the two-pass scheme; runs in place of pixels are older). Slabs are joined in parallel and then to each other; a
//! component is named by its first run, so names do not depend on the slabs.
//!
//! Voxels are connected by faces, edges and corners (26 neighbours).

use std::ops::Range;

use rayon::prelude::*;

/// Layers that are joined in one go.
const SLAB: usize = 16;

/// Voxels `start..end` of a row.
#[derive(Clone, Copy)]
pub(crate) struct Run {
    pub(crate) start: u32,
    pub(crate) end: u32,
}

impl Run {
    /// Its voxels along x.
    pub(crate) fn voxels(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// The runs of one layer.
#[derive(Default)]
pub(crate) struct LayerRuns {
    /// Row by row, ascending.
    runs: Vec<Run>,
    /// How many there are in each row.
    counts: Vec<u32>,
}

impl LayerRuns {
    /// Adds the next row; `find` appends its runs, which do not touch each other.
    pub(crate) fn row(&mut self, find: impl FnOnce(&mut Vec<Run>)) {
        let before = self.runs.len();
        find(&mut self.runs);
        self.counts.push((self.runs.len() - before) as u32);
    }
}

/// All runs of a volume, row by row, layer by layer.
pub(crate) struct Runs {
    runs: Vec<Run>,
    /// Where the runs of row `y + ny · z` begin; one more at the end.
    rows: Vec<u32>,
    ny: usize,
    nz: usize,
}

impl Runs {
    /// Puts the runs of layers of `ny` rows together; `None` if there is no memory for them, or there are 2³² − 1.
    pub(crate) fn new(ny: usize, layers: Vec<LayerRuns>) -> Option<Runs> {
        let nz = layers.len();
        let all: usize = layers.iter().map(|layer| layer.runs.len()).sum();
        if all >= u32::MAX as usize {
            return None;
        }
        let (mut runs, mut rows) = (Vec::new(), Vec::with_capacity(ny * nz + 1));
        runs.try_reserve_exact(all).ok()?;
        rows.push(0);
        let mut up_to = 0;
        for layer in layers {
            runs.extend(layer.runs);
            rows.extend(layer.counts.into_iter().map(|n| {
                up_to += n;
                up_to
            }));
        }
        Some(Runs { runs, rows, ny, nz })
    }

    /// All of them, in order.
    pub(crate) fn all(&self) -> &[Run] {
        &self.runs
    }

    /// The runs of a row, by number.
    pub(crate) fn row(&self, y: usize, z: usize) -> Range<usize> {
        let row = y + self.ny * z;
        self.rows[row] as usize..self.rows[row + 1] as usize
    }

    /// The runs of layers `z`, by number.
    fn layers(&self, z: Range<usize>) -> Range<usize> {
        self.rows[self.ny * z.start] as usize..self.rows[self.ny * z.end] as usize
    }

    /// Joins what touches: for each run the first one of its component.
    pub(crate) fn join(&self) -> Vec<u32> {
        let mut parents: Vec<u32> = (0..self.runs.len() as u32).collect();
        let mut slabs = Vec::with_capacity(self.nz.div_ceil(SLAB));
        let mut rest = &mut parents[..];
        for z in (0..self.nz).step_by(SLAB) {
            let layers = z..self.nz.min(z + SLAB);
            let runs = self.layers(layers.clone());
            let (slab, others) = rest.split_at_mut(runs.len());
            rest = others;
            slabs.push((layers, runs.start, slab));
        }
        slabs.into_par_iter().for_each(|(layers, first, parents)| {
            let mut sets = Sets { parents, first };
            for z in layers.clone() {
                for y in 0..self.ny {
                    if y > 0 {
                        self.touch(&mut sets, self.row(y, z), self.row(y - 1, z));
                    }
                    if z > layers.start {
                        self.touch_layer_below(&mut sets, y, z);
                    }
                }
            }
        });
        let mut sets = Sets { parents: &mut parents, first: 0 };
        for z in (SLAB..self.nz).step_by(SLAB) {
            (0..self.ny).for_each(|y| self.touch_layer_below(&mut sets, y, z));
        }
        // Parents come first: one sweep makes each point to its root.
        for run in 0..parents.len() {
            parents[run] = parents[parents[run] as usize];
        }
        parents
    }

    fn touch_layer_below(&self, sets: &mut Sets<'_>, y: usize, z: usize) {
        for below in y.saturating_sub(1)..self.ny.min(y + 2) {
            self.touch(sets, self.row(y, z), self.row(below, z - 1));
        }
    }

    /// Joins the runs of two neighbouring rows that overlap or meet at a corner.
    fn touch(&self, sets: &mut Sets<'_>, a: Range<usize>, b: Range<usize>) {
        let (mut i, mut j) = (a.start, b.start);
        while i < a.end && j < b.end {
            let (p, q) = (self.runs[i], self.runs[j]);
            if p.start <= q.end && q.start <= p.end {
                sets.join(i, j);
            }
            if p.end < q.end { i += 1 } else { j += 1 }
        }
    }
}

/// Disjoint sets of runs `first..`; the smallest number of a set is its root, and no parent is larger than its child.
struct Sets<'a> {
    parents: &'a mut [u32],
    first: usize,
}

impl Sets<'_> {
    fn root(&mut self, run: usize) -> usize {
        let mut run = run - self.first;
        loop {
            let parent = self.parents[run] as usize - self.first;
            if parent == run {
                return run + self.first;
            }
            // Halve the path on the way.
            self.parents[run] = self.parents[parent];
            run = parent;
        }
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) - self.first] = a.min(b) as u32;
    }
}
