//! What waits for its turn, by steps of a length: a radix queue with as many places as floats have steps.

/// Vertices or triangles that wait for their turn, by the step of a length.
pub(super) struct Queues {
    of_step: Vec<Vec<u32>>,
}

impl Queues {
    /// All things of which `step` says the step, at most `last`.
    pub(super) fn new(last: u16, step: &[u16]) -> Queues {
        let mut counts = vec![0usize; usize::from(last) + 1];
        step.iter().for_each(|&s| counts[usize::from(s)] += 1);
        let mut of_step: Vec<Vec<u32>> = counts.into_iter().map(Vec::with_capacity).collect();
        for (v, &s) in step.iter().enumerate() {
            of_step[usize::from(s)].push(v as u32);
        }
        Queues { of_step }
    }

    /// The `k`-th that waits for `step`.
    #[inline(always)]
    pub(super) fn get(&self, step: u16, k: usize) -> Option<u32> {
        self.of_step[usize::from(step)].get(k).copied()
    }

    /// Lets one more wait for `step`.
    #[inline(always)]
    pub(super) fn push(&mut self, step: u16, v: u32) {
        self.of_step[usize::from(step)].push(v);
    }

    /// Gives the memory of a step that is done back.
    pub(super) fn clear(&mut self, step: u16) {
        self.of_step[usize::from(step)] = Vec::new();
    }
}
