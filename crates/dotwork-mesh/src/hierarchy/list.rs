//! A short list of neighbours, nearest first.

/// Neighbours that a list holds; a mesh has six a vertex in the mean.
pub(super) const LIST: usize = 12;

/// No entry. Entries are the bits of a distance above a vertex, so that integers sort as distances do.
pub(super) const EMPTY: u64 = u64::MAX;

/// The neighbours of a vertex, nearest first, then [`EMPTY`].
pub(super) type List = [u64; LIST];

#[inline(always)]
pub(super) fn entry(distance: f32, vertex: u32) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(vertex)
}

#[inline(always)]
pub(super) fn distance(entry: u64) -> f32 {
    f32::from_bits((entry >> 32) as u32)
}

#[inline(always)]
pub(super) fn vertex(entry: u64) -> u32 {
    entry as u32
}

/// The entries of a list.
#[inline(always)]
pub(super) fn entries(list: &List) -> impl Iterator<Item = u64> {
    list.iter().copied().take_while(|&e| e != EMPTY)
}

/// Puts an entry in its place unless its vertex is there already; the farthest falls off a full list.
#[inline(always)]
pub(super) fn insert(list: &mut List, new: u64) {
    if new >= list[LIST - 1] {
        return;
    }
    let mut n = 0;
    while n < LIST && list[n] != EMPTY {
        if vertex(list[n]) == vertex(new) {
            return;
        }
        n += 1;
    }
    let mut k = n.min(LIST - 1);
    while k > 0 && list[k - 1] > new {
        list[k] = list[k - 1];
        k -= 1;
    }
    list[k] = new;
}

/// Mean distance of a list's entries; 0 for none.
#[inline(always)]
pub(super) fn mean(list: &List) -> f32 {
    let (sum, n) = entries(list).fold((0.0, 0), |(sum, n), e| (sum + distance(e), n + 1));
    if n == 0 { 0.0 } else { sum / n as f32 }
}
