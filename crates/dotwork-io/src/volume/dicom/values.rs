//! From stored samples to those of the volume: padding made low, one scaling for all, white made high, holes filled.

use dotwork_drawing::Warnings;
use dotwork_volume::{Sample, Samples, Scaling, with_samples};

use crate::error::ReadErrorKind;
use crate::volume::dicom::image::{Color, Layout};
use crate::volume::dicom::stack::Mix;
use crate::volume::fill::zeroed;
use crate::volume::reduce::FromF64;

/// What the samples of one slice mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meaning {
    pub(super) scaling: Scaling,
    /// Samples that stand for nothing, from and to.
    pub(super) padding: Option<[f64; 2]>,
}

/// Turns MONOCHROME1 round. Scaled samples are measurements: their values stay, whatever they are to look like.
pub(super) fn turn(
    samples: &mut Samples,
    layout: &Layout,
    meanings: &mut [Meaning],
    warnings: &mut Warnings,
) {
    if layout.color != Color::WhiteIsLow || !meanings.iter().all(|m| m.scaling.is_identity()) {
        return;
    }
    // The other end of the range: 2ⁿ − 1 − s, or −1 − s with a sign. A stored sample never leaves it.
    let sum = if layout.is_signed() { -1.0 } else { (2f64).powi(layout.stored as i32) - 1.0 };
    with_samples!(samples, v => v.iter_mut().for_each(|s| *s = FromF64::from_f64(sum - s.to_f64())));
    for m in meanings {
        m.padding = m.padding.map(|[from, to]| [sum - to, sum - from]);
    }
    warnings.say("white is 0 in this DICOM (MONOCHROME1): turned round");
}

/// Gives all slices of `per_slice` samples one scaling: their own if they share it, otherwise values as `float32`.
/// Samples of padding get the lowest value of the others.
pub(super) fn unify(
    mut samples: Samples,
    per_slice: usize,
    meanings: &[Meaning],
    warnings: &mut Warnings,
) -> Result<(Samples, Scaling), ReadErrorKind> {
    let scaling = meanings[0].scaling;
    let padded = meanings.iter().any(|m| m.padding.is_some());
    if meanings.iter().all(|m| m.scaling == scaling) {
        if padded {
            let count = with_samples!(&mut samples, v => lower(v, per_slice, meanings, scaling.slope < 0.0));
            say_padding(count, warnings);
        }
        return Ok((samples, scaling));
    }
    warnings.say("the scaling differs from slice to slice: values stored as float32");
    let mut values = zeroed(f32::TYPE, samples.len())?;
    let Samples::F32(out) = &mut values else { return Ok((samples, scaling)) };
    let mut low = f32::INFINITY;
    with_samples!(&samples, v => {
        for ((out, v), m) in out.chunks_mut(per_slice).zip(v.chunks(per_slice)).zip(meanings) {
            for (o, s) in out.iter_mut().zip(v) {
                let sample = s.to_f64();
                let value = m.scaling.value(sample) as f32;
                *o = if is_padding(m.padding, sample) { f32::NAN } else { value };
                low = low.min(*o);
            }
        }
    });
    if padded && low.is_finite() {
        let empty = out.iter_mut().filter(|v| v.is_nan());
        say_padding(
            empty.fold(0, |n, v| {
                *v = low;
                n + 1
            }),
            warnings,
        );
    }
    Ok((values, Scaling::default()))
}

fn is_padding(padding: Option<[f64; 2]>, sample: f64) -> bool {
    padding.is_some_and(|[from, to]| from <= sample && sample <= to)
}

fn say_padding(count: u64, warnings: &mut Warnings) {
    warnings.counted("voxels of padding set to the lowest value of the others", count, None);
}

/// Sets samples of padding to the lowest of the others, the highest if `negative`; returns how many there were.
fn lower<T: Sample + PartialOrd>(v: &mut [T], per_slice: usize, meanings: &[Meaning], negative: bool) -> u64 {
    let mut low: Option<T> = None;
    for (v, m) in v.chunks(per_slice).zip(meanings) {
        for &s in v.iter().filter(|s| !is_padding(m.padding, s.to_f64())) {
            if low.is_none_or(|l| if negative { s > l } else { s < l }) {
                low = Some(s);
            }
        }
    }
    let Some(low) = low else { return 0 };
    let mut count = 0;
    for (v, m) in v.chunks_mut(per_slice).zip(meanings) {
        for s in v.iter_mut().filter(|s| is_padding(m.padding, s.to_f64())) {
            *s = low;
            count += 1;
        }
    }
    count
}

/// Makes the slices of a grid from those that there are.
pub(super) fn mix(samples: &Samples, per_slice: usize, mixes: &[Mix]) -> Result<Samples, ReadErrorKind> {
    let mut mixed = zeroed(samples.sample_type(), per_slice * mixes.len())?;
    fn typed<T: FromF64>(out: &mut [T], v: &[T], per_slice: usize, mixes: &[Mix]) {
        for (out, m) in out.chunks_exact_mut(per_slice).zip(mixes) {
            let slice = |i: usize| &v[i * per_slice..(i + 1) * per_slice];
            if m.t == 0.0 {
                out.copy_from_slice(slice(m.from));
                continue;
            }
            for ((o, a), b) in out.iter_mut().zip(slice(m.from)).zip(slice(m.to)) {
                *o = T::from_f64(a.to_f64() * (1.0 - m.t) + b.to_f64() * m.t);
            }
        }
    }
    macro_rules! each {
        ($($variant:ident)*) => {
            match (&mut mixed, samples) {
                $((Samples::$variant(out), Samples::$variant(v)) => typed(out, v, per_slice, mixes),)*
                // Both have one type.
                _ => {}
            }
        };
    }
    each!(U8 I8 U16 I16 U32 I32 U64 I64 F32 F64);
    Ok(mixed)
}
