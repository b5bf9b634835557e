//! Who neighbours whom in a mesh, each with a weight: what filters over surfaces go along.

use std::ops::Range;

use rayon::prelude::*;

/// Neighbours of all vertices in one list, each with its weight.
pub(crate) struct Neighbours {
    /// Where those of vertex `v` begin; one more at the end.
    starts: Vec<u32>,
    links: Vec<(u32, f32)>,
}

impl Neighbours {
    /// Neighbours by the edges of a mesh, in the order of its triangles: each edge of a vertex leaves it in one of its
    /// triangles. Where a mesh is open, an edge of its border is known to one of its ends only. `weight(v, to, n)` is that
    /// of the neighbour `to` of `v`, which has `n`.
    pub(crate) fn new(
        vertices: usize,
        triangles: &[[u32; 3]],
        weight: impl Fn(usize, usize, usize) -> f32 + Sync,
    ) -> Neighbours {
        let mut starts = vec![0u32; vertices + 1];
        for t in triangles {
            t.iter().for_each(|&v| starts[v as usize + 1] += 1);
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut links = vec![(0u32, 0f32); 3 * triangles.len()];
        let mut next = starts.clone();
        for &[a, b, c] in triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let place = &mut next[from as usize];
                links[*place as usize].0 = to;
                *place += 1;
            }
        }
        // In tasks that end where a vertex does.
        let mut tasks = Vec::with_capacity(vertices.div_ceil(GRAIN));
        let mut rest = &mut links[..];
        for first in (0..vertices).step_by(GRAIN) {
            let last = (first + GRAIN).min(vertices);
            let (own, later) = rest.split_at_mut((starts[last] - starts[first]) as usize);
            tasks.push((first..last, own));
            rest = later;
        }
        tasks.into_par_iter().for_each(|(range, mut own)| {
            for v in range {
                let (links, later) = own.split_at_mut((starts[v + 1] - starts[v]) as usize);
                let count = links.len();
                links.iter_mut().for_each(|(to, w)| *w = weight(v, *to as usize, count));
                own = later;
            }
        });
        Neighbours { starts, links }
    }

    /// How many vertices there are.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The neighbours of a vertex and their weights.
    #[inline]
    pub(crate) fn of(&self, v: usize) -> &[(u32, f32)] {
        let range: Range<usize> = self.starts[v] as usize..self.starts[v + 1] as usize;
        &self.links[range]
    }
}

/// Vertices in one task.
const GRAIN: usize = 4096;
