//! From bytes to typed samples without a second copy: the decoder writes into the vector that the volume keeps.
//!
//! The vector is allocated zeroed in its final type, seen as bytes while it is filled, and its byte order is mended in
//! place. Memory is only taken for what the bytes at hand can hold; where nobody can know that (bzip2, files that
//! follow) the vector grows with the data.

use bytemuck::allocation::try_zeroed_vec;
use bytemuck::{AnyBitPattern, NoUninit, cast_slice_mut};
use dotwork_volume::{Sample, SampleType, Samples, with_samples};

use crate::error::ReadErrorKind;
use crate::volume::stream::Stream;

/// Bytes by which a vector of unknown length grows at least.
const STEP: usize = 1 << 20;

/// `count` zeros of a type.
///
/// # Errors
/// Too little memory.
pub(crate) fn zeroed(sample: SampleType, count: usize) -> Result<Samples, ReadErrorKind> {
    fn of<T: Sample + bytemuck::Zeroable>(count: usize) -> Option<Samples> {
        try_zeroed_vec::<T>(count).ok().map(T::wrap)
    }
    let samples = match sample {
        SampleType::U8 => of::<u8>(count),
        SampleType::I8 => of::<i8>(count),
        SampleType::U16 => of::<u16>(count),
        SampleType::I16 => of::<i16>(count),
        SampleType::U32 => of::<u32>(count),
        SampleType::I32 => of::<i32>(count),
        SampleType::U64 => of::<u64>(count),
        SampleType::I64 => of::<i64>(count),
        SampleType::F32 => of::<f32>(count),
        SampleType::F64 => of::<f64>(count),
    };
    samples.ok_or_else(|| no_memory(count, sample))
}

fn no_memory(count: usize, sample: SampleType) -> ReadErrorKind {
    ReadErrorKind::TooLarge(format!("there is no memory for {count} {} samples", sample.name()))
}

/// The memory of samples.
pub(crate) fn as_bytes_mut(samples: &mut Samples) -> &mut [u8] {
    with_samples!(samples, v => cast_slice_mut(v.as_mut_slice()))
}

/// Turns the byte order of samples of `width` bytes.
pub(crate) fn swap_bytes(bytes: &mut [u8], width: usize) {
    fn swap<const N: usize>(bytes: &mut [u8]) {
        for word in bytes.as_chunks_mut::<N>().0 {
            word.reverse();
        }
    }
    match width {
        2 => swap::<2>(bytes),
        4 => swap::<4>(bytes),
        8 => swap::<8>(bytes),
        _ => {}
    }
}

/// Samples that are being filled.
pub(crate) struct Fill {
    samples: Samples,
    /// Bytes filled.
    filled: usize,
    /// Samples wanted.
    pub(crate) count: usize,
    pub(crate) sample: SampleType,
}

impl Fill {
    /// Nothing yet of `count` samples.
    ///
    /// # Errors
    /// More than can be addressed.
    pub(crate) fn new(sample: SampleType, count: u64) -> Result<Fill, ReadErrorKind> {
        let count = usize::try_from(count)
            .ok()
            .filter(|n| n.checked_mul(sample.bytes()).is_some_and(|b| isize::try_from(b).is_ok()))
            .ok_or_else(|| ReadErrorKind::TooLarge(format!("declares {count} samples")))?;
        Ok(Fill { samples: zeroed(sample, 0)?, filled: 0, count, sample })
    }

    /// Bytes that are still to come.
    pub(crate) fn missing(&self) -> usize {
        self.count * self.sample.bytes() - self.filled
    }

    /// Takes the memory for everything at once: for a caller that knows that the bytes are there.
    pub(crate) fn allocate(&mut self) -> Result<(), ReadErrorKind> {
        if self.filled == 0 {
            self.samples = zeroed(self.sample, self.count)?;
        }
        Ok(())
    }

    /// The next `bytes` bytes, to be written by the caller.
    pub(crate) fn room(&mut self, bytes: usize) -> Result<&mut [u8], ReadErrorKind> {
        let until = self.filled + bytes.min(self.missing());
        let needed = until.div_ceil(self.sample.bytes());
        let (count, sample) = (self.count, self.sample);
        with_samples!(&mut self.samples, v => {
            if v.len() < needed {
                v.try_reserve(needed - v.len()).map_err(|_| no_memory(count, sample))?;
                v.resize(needed, Default::default());
            }
        });
        let from = std::mem::replace(&mut self.filled, until);
        Ok(&mut as_bytes_mut(&mut self.samples)[from..until])
    }

    /// Takes up to `bytes` bytes from `stream`; returns how many there were.
    pub(crate) fn take(&mut self, stream: &mut Stream, bytes: usize) -> Result<usize, ReadErrorKind> {
        let bytes = bytes.min(self.missing());
        let mut taken = 0;
        while taken < bytes {
            let allocated = self.samples.len() * self.sample.bytes();
            let ready = allocated.saturating_sub(self.filled);
            // What is not allocated yet comes in growing steps.
            let step = if ready > 0 { ready } else { STEP.max(self.filled / 2) };
            let step = step.min(bytes - taken);
            let got = stream.read(self.room(step)?)?;
            taken += got;
            if got < step {
                self.filled -= step - got;
                break;
            }
        }
        Ok(taken)
    }

    /// The next `count` samples, which must be of type `T`, to be written by the caller.
    pub(crate) fn typed<T: NoUninit + AnyBitPattern>(
        &mut self,
        count: usize,
    ) -> Result<&mut [T], ReadErrorKind> {
        // The vector is of this type and `filled` whole samples are in it, so that the cast cannot fail.
        Ok(cast_slice_mut(self.room(count * self.sample.bytes())?))
    }

    /// The samples in this machine's byte order; `big_endian` says which they came in.
    pub(crate) fn finish(mut self, big_endian: bool) -> Samples {
        if big_endian != cfg!(target_endian = "big") {
            swap_bytes(as_bytes_mut(&mut self.samples), self.sample.bytes());
        }
        self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::stream::Packing;

    #[test]
    fn fills_in_pieces_and_turns_bytes() {
        let bytes: Vec<u8> = (0..12).collect();
        for allocate in [false, true] {
            let mut fill = Fill::new(SampleType::U16, 6).unwrap();
            if allocate {
                fill.allocate().unwrap();
            }
            let mut first = Stream::new(&bytes[..5], Packing::None);
            let mut second = Stream::new(&bytes[5..], Packing::None);
            assert_eq!(fill.take(&mut first, 5).unwrap(), 5);
            assert_eq!(fill.missing(), 7);
            assert_eq!(fill.take(&mut second, 99).unwrap(), 7);
            let expected = Samples::U16(vec![0x0001, 0x0203, 0x0405, 0x0607, 0x0809, 0x0a0b]);
            assert_eq!(fill.finish(true), expected);
        }
    }

    #[test]
    fn what_cannot_be_held_is_refused() {
        assert!(Fill::new(SampleType::F64, u64::MAX / 4).is_err());
        assert!(zeroed(SampleType::F64, isize::MAX as usize / 8).is_err());
    }

    #[test]
    fn grows_with_the_data_only() {
        let mut fill = Fill::new(SampleType::U8, 1 << 50).unwrap();
        let bytes = [7; 100];
        let taken = fill.take(&mut Stream::new(&bytes, Packing::None), usize::MAX).unwrap();
        assert_eq!(taken, 100);
    }
}
