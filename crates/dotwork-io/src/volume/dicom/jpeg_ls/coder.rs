//! The coding of lines: contexts, runs and codes (T.87, annex A).

use crate::volume::dicom::codec::Damage;
use crate::volume::dicom::jpeg_ls::early;

/// Parameters that a stream may set; 0 stands for the default.
#[derive(Clone, Copy, Default)]
pub(super) struct Preset {
    pub(super) most: i32,
    pub(super) thresholds: [i32; 3],
    pub(super) reset: i32,
}

/// What a scan computes with (T.87, table A.1).
pub(super) struct Parameters {
    near: i32,
    /// Width of the steps to which errors are rounded.
    step: i32,
    /// The highest sample.
    most: i32,
    /// How many errors are told apart.
    range: i32,
    /// Bits of an error that is written as it is.
    error_bits: u32,
    /// The longest code, bits.
    limit: u32,
    thresholds: [i32; 3],
    /// How often a context is used before it forgets half.
    reset: u32,
}

impl Parameters {
    pub(super) fn of(precision: u32, preset: &Preset, near: i32) -> Result<Parameters, Damage> {
        let wrong = || Err("JPEG-LS data with parameters that contradict each other".into());
        let full = (1 << precision) - 1;
        let most = if preset.most == 0 { full } else { preset.most };
        if most > full || near > most / 2 {
            return wrong();
        }
        let mut thresholds = default_thresholds(most, near);
        let mut least = near + 1;
        for (threshold, &set) in thresholds.iter_mut().zip(&preset.thresholds) {
            if set != 0 {
                *threshold = set;
            }
            if *threshold < least || *threshold > most.max(near + 1) {
                return wrong();
            }
            least = *threshold;
        }
        let reset = if preset.reset == 0 { 64 } else { preset.reset };
        if reset < 3 || reset > most.max(255) {
            return wrong();
        }
        let step = 2 * near + 1;
        let range = (most + 2 * near) / step + 1;
        let bits_of = |n: i32| (n as u32).next_power_of_two().trailing_zeros();
        let bits = bits_of(most + 1).max(2);
        Ok(Parameters {
            near,
            step,
            most,
            range,
            error_bits: bits_of(range),
            limit: 2 * (bits + bits.max(8)),
            thresholds,
            reset: reset as u32,
        })
    }
}

/// T.87, C.2.4.1.1.1.
fn default_thresholds(most: i32, near: i32) -> [i32; 3] {
    let basic = |i: usize| {
        let value = [3, 7, 21][i];
        if most >= 128 {
            let factor = (most.min(4095) + 128) / 256;
            let offset = [2, 3, 4][i];
            factor * (value - offset) + offset
        } else {
            value / (256 / (most + 1))
        }
    };
    let mut least = near + 1;
    [0, 1, 2].map(|i| {
        let value = basic(i) + [3, 5, 7][i] * near;
        let value = if most >= 128 { value } else { value.max([2, 3, 4][i]) };
        least = if value > most || value < least { least } else { value };
        least
    })
}

/// Bits, the highest of a byte first; after 0xff a byte has seven.
struct Bits<'a> {
    rest: std::slice::Iter<'a, u8>,
    after_full: bool,
    /// The next bits, from the top.
    cache: u64,
    count: u32,
}

impl Bits<'_> {
    /// Has 57 bits or more at hand, or all that are left.
    fn fill(&mut self) {
        while self.count <= 56 {
            let Some(&byte) = self.rest.next() else { return };
            let bits = if self.after_full { 7 } else { 8 };
            self.cache |= u64::from(byte) << (64 - bits) >> self.count;
            self.count += bits;
            self.after_full = byte == 0xff;
        }
    }

    fn take(&mut self, count: u32) -> Result<u32, Damage> {
        if self.count < count {
            self.fill();
            if self.count < count {
                return Err(early());
            }
        }
        if count == 0 {
            return Ok(0);
        }
        let bits = (self.cache >> (64 - count)) as u32;
        self.cache <<= count;
        self.count -= count;
        Ok(bits)
    }

    /// A number in the code of Golomb and Rice of order `k`, of up to `limit` bits; one that is too long for that stands
    /// as it is, in `plain` bits (T.87, A.5.3).
    fn golomb(&mut self, k: u32, limit: u32, plain: u32) -> Result<u32, Damage> {
        if self.count < 57 {
            self.fill();
        }
        let zeros = self.cache.leading_zeros();
        let longest = limit - plain - 1;
        if zeros.min(self.count) > longest {
            return Err(damaged());
        }
        if zeros >= self.count {
            return Err(early());
        }
        self.cache <<= zeros + 1;
        self.count -= zeros + 1;
        if zeros < longest { Ok(zeros << k | self.take(k)?) } else { Ok(self.take(plain)? + 1) }
    }
}

fn damaged() -> Damage {
    "the JPEG-LS data are damaged".into()
}

/// What was seen where gradients were alike.
#[derive(Clone, Copy)]
struct Context {
    /// Sum of the errors' sizes.
    a: u32,
    /// Sum of the errors, what is left of it after `c` took its share.
    b: i32,
    /// Correction of the prediction.
    c: i32,
    /// How many.
    n: u32,
}

/// What was seen where runs ended.
#[derive(Clone, Copy)]
struct RunContext {
    a: u32,
    n: u32,
    /// How many errors were negative.
    negative: u32,
}

/// Binary logarithms of the lengths of runs (T.87, A.2.1).
const RUNS: [u32; 32] =
    [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15];

pub(super) struct Coder<'a> {
    bits: Bits<'a>,
    parameters: &'a Parameters,
    contexts: [Context; 365],
    run_contexts: [RunContext; 2],
}

impl<'a> Coder<'a> {
    pub(super) fn new(data: &'a [u8], parameters: &'a Parameters) -> Coder<'a> {
        let a = ((parameters.range as u32 + 32) / 64).max(2);
        Coder {
            bits: Bits { rest: data.iter(), after_full: false, cache: 0, count: 0 },
            parameters,
            contexts: [Context { a, b: 0, c: 0, n: 1 }; 365],
            run_contexts: [RunContext { a, n: 1, negative: 0 }; 2],
        }
    }

    /// Decodes a line of one component; `above` and `line` have a neighbour at either end.
    pub(super) fn line(&mut self, above: &[i32], line: &mut [i32], run: &mut usize) -> Result<(), Damage> {
        let width = line.len() - 2;
        let mut x = 1;
        while x <= width {
            let gradients = self.gradients(above, line, x);
            if gradients != 0 {
                line[x] = self.regular(gradients, above, line, x)?;
                x += 1;
                continue;
            }
            let left = line[x - 1];
            let (length, interrupted) = self.run(width + 1 - x, run)?;
            line[x..x + length].fill(left);
            x += length;
            if interrupted {
                let kind = usize::from((left - above[x]).abs() <= self.parameters.near);
                line[x] = self.interruption(left, above[x], kind, *run)?;
                *run = run.saturating_sub(1);
                x += 1;
            }
        }
        Ok(())
    }

    /// Decodes a line of all components, pixel by pixel; a run is one of all of them.
    pub(super) fn pixels(
        &mut self,
        above: &[Vec<i32>],
        lines: &mut [Vec<i32>],
        run: &mut usize,
    ) -> Result<(), Damage> {
        let width = lines[0].len() - 2;
        let mut x = 1;
        while x <= width {
            if above.iter().zip(&*lines).any(|(a, l)| self.gradients(a, l, x) != 0) {
                for (above, line) in above.iter().zip(&mut *lines) {
                    let gradients = self.gradients(above, line, x);
                    line[x] = self.regular(gradients, above, line, x)?;
                }
                x += 1;
                continue;
            }
            let (length, interrupted) = self.run(width + 1 - x, run)?;
            for line in &mut *lines {
                let left = line[x - 1];
                line[x..x + length].fill(left);
            }
            x += length;
            if interrupted {
                for (above, line) in above.iter().zip(&mut *lines) {
                    line[x] = self.interruption(line[x - 1], above[x], 0, *run)?;
                }
                *run = run.saturating_sub(1);
                x += 1;
            }
        }
        Ok(())
    }

    /// The three gradients around a sample, each in one of nine steps, as one number; its sign is theirs.
    fn gradients(&self, above: &[i32], line: &[i32], x: usize) -> i32 {
        let [t1, t2, t3] = self.parameters.thresholds;
        let step = |d: i32| {
            let size = d.abs();
            let step = match size {
                _ if size <= self.parameters.near => 0,
                _ if size < t1 => 1,
                _ if size < t2 => 2,
                _ if size < t3 => 3,
                _ => 4,
            };
            step * d.signum()
        };
        let (a, b, c, d) = (line[x - 1], above[x], above[x - 1], above[x + 1]);
        (step(d - b) * 9 + step(b - c)) * 9 + step(c - a)
    }

    /// The order of the code for numbers whose `n` last ones sum up to `sum`.
    fn order(n: u32, sum: u32) -> u32 {
        // Both sums and numbers are far below the ends of their types: a context forgets.
        (0..).find(|k| n << k >= sum).unwrap_or(0)
    }

    fn code(&mut self, k: u32, limit: u32) -> Result<i32, Damage> {
        let code = self.bits.golomb(k, limit, self.parameters.error_bits)?;
        // Errors are known up to their range, so that no code is larger.
        if code > self.parameters.range as u32 { Err(damaged()) } else { Ok(code as i32) }
    }

    /// Decodes a sample by what is around it (T.87, A.4 to A.6).
    fn regular(&mut self, gradients: i32, above: &[i32], line: &[i32], x: usize) -> Result<i32, Damage> {
        let Parameters { near, step, most, reset, limit, .. } = *self.parameters;
        let (a, b, c) = (line[x - 1], above[x], above[x - 1]);
        // An edge above or at the left, or a plane through the three.
        let (low, high) = (a.min(b), a.max(b));
        let predicted = if c >= high {
            low
        } else if c <= low {
            high
        } else {
            a + b - c
        };
        let (index, sign) = (gradients.unsigned_abs() as usize, if gradients < 0 { -1 } else { 1 });
        let context = self.contexts[index];
        let predicted = (predicted + sign * context.c).clamp(0, most);
        let k = Self::order(context.n, context.a);
        let code = self.code(k, limit)?;
        let error = if near == 0 && k == 0 && 2 * context.b <= -(context.n as i32) {
            if code & 1 == 1 { code >> 1 } else { -(code >> 1) - 1 }
        } else if code & 1 == 1 {
            -(code >> 1) - 1
        } else {
            code >> 1
        };

        let Context { mut a, mut b, mut c, mut n } = context;
        a += error.unsigned_abs();
        b += error * step;
        if n == reset {
            (a, b, n) = (a >> 1, b >> 1, n >> 1);
        }
        n += 1;
        let count = n as i32;
        if b <= -count {
            b = (b + count).max(1 - count);
            c = (c - 1).max(-128);
        } else if b > 0 {
            b = (b - count).min(0);
            c = (c + 1).min(127);
        }
        self.contexts[index] = Context { a, b, c, n };
        Ok(self.sample(predicted, sign * error))
    }

    /// How far a run goes, of at most `room` samples, and whether another sample ends it before the line does (A.7.1).
    fn run(&mut self, room: usize, run: &mut usize) -> Result<(usize, bool), Damage> {
        let mut length = 0;
        while self.bits.take(1)? == 1 {
            let piece = 1 << RUNS[*run];
            if piece <= room - length {
                *run = (*run + 1).min(31);
            }
            length += piece.min(room - length);
            if length == room {
                return Ok((length, false));
            }
        }
        length += self.bits.take(RUNS[*run])? as usize;
        if length >= room { Err(damaged()) } else { Ok((length, true)) }
    }

    /// Decodes the sample that ends a run (A.7.2); of `kind` 1 if the neighbours at the left and above are alike.
    fn interruption(&mut self, left: i32, above: i32, kind: usize, run: usize) -> Result<i32, Damage> {
        let context = self.run_contexts[kind];
        let k = Self::order(context.n, context.a + if kind == 1 { context.n >> 1 } else { 0 });
        let code = self.code(k, self.parameters.limit - RUNS[run] - 1)?;
        let doubled = code + kind as i32;
        let odd = doubled & 1 == 1;
        let size = (doubled + 1) >> 1;
        let negative = (k != 0 || 2 * context.negative >= context.n) == odd;
        let error = if negative { -size } else { size };

        let RunContext { mut a, mut n, negative: mut below } = context;
        below += u32::from(error < 0);
        a += (code + 1 - kind as i32) as u32 >> 1;
        if n == self.parameters.reset {
            (a, n, below) = (a >> 1, n >> 1, below >> 1);
        }
        self.run_contexts[kind] = RunContext { a, n: n + 1, negative: below };
        let sign = if kind == 0 && left > above { -1 } else { 1 };
        Ok(self.sample(if kind == 1 { left } else { above }, sign * error))
    }

    /// The sample that differs by an error from what was predicted; both ends of the range are neighbours.
    fn sample(&self, predicted: i32, error: i32) -> i32 {
        let &Parameters { near, step, most, range, .. } = self.parameters;
        let mut sample = predicted + error * step;
        if sample < -near {
            sample += range * step;
        } else if sample > most + near {
            sample -= range * step;
        }
        sample.clamp(0, most)
    }
}
