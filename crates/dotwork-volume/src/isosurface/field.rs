//! The field at one grid edge: where it crosses the iso value, and which way it falls.

use glam::{DMat3, DVec3, Mat3A, Vec3A};

use crate::samples::Ordered;
use crate::volume::Volume;

/// Vertices keep this distance from the two samples of their edge, in edge lengths.
///
/// Integer samples often equal the iso value exactly. Vertices of several edges would then coincide at the sample,
/// triangles would collapse, and cleaning a mesh by welding would tear or pinch the surface. A thousandth of a voxel
/// is far below what samples can tell, and survives `f32` coordinates for some 2000 voxels a side.
pub(super) const MARGIN: f64 = 1.0 / 1024.0;

/// Which stored samples are inside: those with `value >= iso`, to the last bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Inside<T> {
    /// Samples from this one upwards.
    From(T),
    /// Samples up to this one (the slope is negative).
    UpTo(T),
}

impl<T: Ordered> Inside<T> {
    /// Finds the threshold by bisection over all samples of the type, so that rounding in `slope · s + intercept`
    /// is part of the answer; `None` if no sample reaches `iso`.
    pub(super) fn find(volume: &Volume, iso: f64) -> Option<Inside<T>> {
        let scaling = volume.scaling();
        let rising = scaling.slope > 0.0;
        let (first, last) = T::key_range();
        let key = |step: u64| if rising { first + step } else { last - step };
        let reaches = |step: u64| {
            let sample = T::from_key(key(step));
            // Unscaled integers beyond 2^53 are compared before they are rounded.
            if scaling.is_identity() {
                sample.minus_real(iso) >= 0.0
            } else {
                scaling.value(sample.to_f64()) >= iso
            }
        };
        // Values ascend from one end of the type to the other: the number of steps to the first that reaches iso.
        let (mut low, mut high) = (0, last - first);
        if !reaches(high) {
            return None;
        }
        while low < high {
            let middle = low + (high - low) / 2;
            if reaches(middle) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        let threshold = T::from_key(key(low));
        Some(if rising { Inside::From(threshold) } else { Inside::UpTo(threshold) })
    }
}

/// A volume as the surface sees it.
pub(super) struct Field<'a, T> {
    samples: &'a [T],
    dims: [usize; 3],
    /// The iso value in samples.
    iso: f64,
    /// 1 if larger samples are inside, −1 if smaller ones are.
    sign: f64,
    /// Steps from voxel to voxel in the world.
    steps: [DVec3; 3],
    /// The centre of the first voxel in mesh coordinates.
    first: DVec3,
    /// From the gradient of the samples in index space to the direction outwards in the world.
    outwards: DMat3,
    outwards_f32: Mat3A,
}

/// The neighbours of sample i along an axis, and what turns their difference into a derivative.
#[derive(Clone, Copy)]
struct Stencil {
    before: usize,
    after: usize,
    factor: f32,
}

impl Stencil {
    /// Central differences at sample number `at` of `n`, `stride` apart; one-sided ones at the ends.
    #[inline]
    fn new(at: usize, n: usize, stride: usize) -> Stencil {
        let (first, last) = (at == 0, at + 1 == n);
        Stencil {
            before: if first { 0 } else { stride },
            after: if last { 0 } else { stride },
            factor: if first | last { 1.0 } else { 0.5 },
        }
    }
}

/// A row of samples along x with what its gradients share.
#[derive(Clone, Copy)]
struct Row {
    /// Number of its first sample.
    first: usize,
    y: Stencil,
    z: Stencil,
}

/// The edges along one axis from the samples of a row.
pub(super) struct EdgeRow<'a, T, const AXIS: usize> {
    field: &'a Field<'a, T>,
    /// Samples at the lower and the upper ends; the same for x-edges. `None` outside the grid.
    rows: [Option<Row>; 2],
    /// Where its sample 0 lies.
    start: DVec3,
}

impl<'a, T: Ordered> Field<'a, T> {
    pub(super) fn new(volume: &Volume, samples: &'a [T], iso: f64, mesh_origin: DVec3) -> Field<'a, T> {
        let affine = volume.affine();
        let sign = volume.scaling().slope.signum();
        // Covectors go by the inverse transpose. Length does not matter here, so the steps are scaled to stay clear
        // of over- and underflow.
        let scale = affine.spacing().into_iter().fold(0.0, f64::max).recip();
        let outwards = (affine.linear * scale).inverse().transpose() * -sign;
        Field {
            samples,
            dims: volume.dims(),
            iso: volume.scaling().sample(iso),
            sign,
            steps: [affine.linear.x_axis, affine.linear.y_axis, affine.linear.z_axis],
            first: affine.origin - mesh_origin,
            outwards,
            outwards_f32: Mat3A::from_cols(
                outwards.x_axis.as_vec3a(),
                outwards.y_axis.as_vec3a(),
                outwards.z_axis.as_vec3a(),
            ),
        }
    }

    /// The edges along `AXIS` from the samples of row `y` in layer `z`. Numbers outside the grid wrap: −1 is
    /// `usize::MAX`.
    pub(super) fn edges<const AXIS: usize>(&self, y: usize, z: usize) -> EdgeRow<'_, T, AXIS> {
        let next = |i: usize, axis: usize| if axis == AXIS { i.wrapping_add(1) } else { i };
        let signed = |i: usize| i as isize as f64;
        EdgeRow {
            field: self,
            rows: [self.row(y, z), self.row(next(y, 1), next(z, 2))],
            start: self.first + self.steps[1] * signed(y) + self.steps[2] * signed(z),
        }
    }

    fn row(&self, y: usize, z: usize) -> Option<Row> {
        let [nx, ny, nz] = self.dims;
        (y < ny && z < nz).then(|| Row {
            first: nx * (y + ny * z),
            y: Stencil::new(y, ny, nx),
            z: Stencil::new(z, nz, nx * ny),
        })
    }

    /// How far sample `i` lies above the iso value (below it for falling scalings); −∞ for NaN.
    #[inline]
    fn height(&self, i: usize) -> f64 {
        let sample = self.samples[i];
        if sample.is_nan() { f64::NEG_INFINITY } else { self.sign * sample.minus_real(self.iso) }
    }

    /// The gradient of the samples at sample `x` of a row, per index step.
    #[inline]
    fn gradient(&self, row: &Row, x: usize) -> Vec3A {
        let i = row.first + x;
        Vec3A::new(
            self.slope(i, Stencil::new(x, self.dims[0], 1)),
            self.slope(i, row.y),
            self.slope(i, row.z),
        )
    }

    #[inline]
    fn slope(&self, i: usize, stencil: Stencil) -> f32 {
        stencil.factor * self.samples[i + stencil.after].minus_f32(self.samples[i - stencil.before])
    }

    /// The gradient in double precision. Where a neighbour is NaN or infinite, the derivative is that towards the
    /// other one, or 0.
    fn gradient_f64(&self, row: &Row, x: usize) -> DVec3 {
        let i = row.first + x;
        let slope = |stencil: Stencil| {
            let here = self.samples[i];
            let [before, after] = [i - stencil.before, i + stencil.after].map(|i| self.samples[i]);
            let central = f64::from(stencil.factor) * after.minus(before);
            let one_sided = [after.minus(here), here.minus(before)];
            // The difference to itself says nothing.
            let beside_gap = one_sided.into_iter().find(|s| s.is_finite() && *s != 0.0);
            if central.is_finite() { central } else { beside_gap.unwrap_or(0.0) }
        };
        DVec3::new(slope(Stencil::new(x, self.dims[0], 1)), slope(row.y), slope(row.z))
    }

    /// The unit vector outwards in the world if values fall towards the upper end of edges along `axis`, or towards
    /// the lower end, and do not change otherwise.
    #[cold]
    fn normal_along(&self, axis: usize, falling: bool) -> Vec3A {
        let mut gradient = DVec3::ZERO;
        gradient[axis] = if falling { -self.sign } else { self.sign };
        (self.outwards * gradient).normalize_or(DVec3::Z).as_vec3a()
    }
}

impl<T: Ordered, const AXIS: usize> EdgeRow<'_, T, AXIS> {
    /// Position and unit normal of the vertex on the edge from sample `x`, one end of which is inside.
    ///
    /// `x` may be −1 (`usize::MAX`) for an x-edge, and one of the ends outside the grid.
    #[inline]
    pub(super) fn vertex(&self, x: usize, low_is_inside: bool) -> ([f32; 3], [f32; 3]) {
        let field = self.field;
        let x_above = if AXIS == 0 { x.wrapping_add(1) } else { x };
        let [Some(row), Some(row_above)] = &self.rows else {
            return self.vertex_at_gap(x, low_is_inside, 0.0, f64::NEG_INFINITY);
        };
        if AXIS == 0 && (x >= field.dims[0] || x_above >= field.dims[0]) {
            return self.vertex_at_gap(x, low_is_inside, 0.0, f64::NEG_INFINITY);
        }
        let (low, high) = (field.height(row.first + x), field.height(row_above.first + x_above));
        // The heights have opposite signs, so nothing cancels. Halves where the difference overflows.
        let between = low - high;
        let share = if between.is_finite() { low / between } else { low / 2.0 / (low / 2.0 - high / 2.0) };
        // Infinite heights (their share is NaN or 0), and two heights of 0 after rounding.
        if !share.is_finite() || (T::FLOAT && !(low.is_finite() && high.is_finite())) {
            let (inner, outer) = if low_is_inside { (low, high) } else { (high, low) };
            return self.vertex_at_gap(x, low_is_inside, inner, outer);
        }
        let share = share.clamp(MARGIN, 1.0 - MARGIN);

        let gradient = field.gradient(row, x);
        let gradient = gradient + (field.gradient(row_above, x_above) - gradient) * share as f32;
        let normal = field.outwards_f32 * gradient;
        let squared = normal.length_squared();
        let normal = if squared.is_normal() {
            normal * squared.sqrt().recip()
        } else {
            self.normal_in_full([row, row_above], [x, x_above], share, low_is_inside)
        };
        (self.position(x, share), normal.to_array())
    }

    /// The normal where single precision overflows or vanishes, or a neighbour is NaN or infinite.
    #[cold]
    fn normal_in_full(
        &self,
        [row, row_above]: [&Row; 2],
        [x, x_above]: [usize; 2],
        share: f64,
        low_is_inside: bool,
    ) -> Vec3A {
        let [low, high] = [self.field.gradient_f64(row, x), self.field.gradient_f64(row_above, x_above)];
        let gradient = low * (1.0 - share) + high * share;
        let largest = gradient.abs().max_element();
        // Plateaus on both sides have no gradient at all.
        if largest > 0.0 && largest.is_finite() {
            (self.field.outwards * (gradient / largest)).normalize().as_vec3a()
        } else {
            self.field.normal_along(AXIS, low_is_inside)
        }
    }

    /// A vertex at the border of the grid, or beside a sample that is not finite; heights are those of the inner and
    /// the outer end. Its normal is along the edge, since there is no gradient.
    #[cold]
    fn vertex_at_gap(&self, x: usize, low_is_inside: bool, inner: f64, outer: f64) -> ([f32; 3], [f32; 3]) {
        // −∞ outside pulls the vertex to the inner sample, ∞ inside pushes it to the outer one.
        let outwards = if inner == f64::INFINITY && outer.is_finite() { 1.0 - MARGIN } else { MARGIN };
        let share = if low_is_inside { outwards } else { 1.0 - outwards };
        (self.position(x, share), self.field.normal_along(AXIS, low_is_inside).to_array())
    }

    /// The mesh position at `share` of the edge from sample `x`.
    #[inline]
    fn position(&self, x: usize, share: f64) -> [f32; 3] {
        let steps = &self.field.steps;
        (self.start + steps[0] * (x as isize as f64) + steps[AXIS] * share).as_vec3().to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::Affine;
    use crate::samples::{Sample, Samples};
    use crate::volume::Scaling;

    fn inside<T: Ordered>(slope: f64, intercept: f64, iso: f64) -> Option<Inside<T>> {
        let affine = Affine::from_spacing([1.0; 3]);
        let samples: Samples = <T as Sample>::wrap(vec![T::from_key(0)]);
        let v = Volume::new([1; 3], samples, Scaling { slope, intercept }, affine).unwrap();
        Inside::find(&v, iso)
    }

    #[test]
    fn the_threshold_is_the_first_sample_that_reaches_iso() {
        assert_eq!(inside::<u8>(1.0, 0.0, 40.0), Some(Inside::From(40)));
        assert_eq!(inside::<u8>(1.0, 0.0, 40.1), Some(Inside::From(41)));
        assert_eq!(inside::<u8>(1.0, 0.0, -7.0), Some(Inside::From(0)));
        assert_eq!(inside::<u8>(1.0, 0.0, 255.5), None);
        assert_eq!(inside::<i16>(2.0, -1000.0, 0.0), Some(Inside::From(500)));
        assert_eq!(inside::<i16>(-1.0, 0.0, 3.0), Some(Inside::UpTo(-3)));
        assert_eq!(inside::<i16>(-1.0, 0.0, 32767.5), Some(Inside::UpTo(-32768)));
        assert_eq!(inside::<i16>(-1.0, 0.0, 32768.5), None);
        assert_eq!(inside::<f32>(1.0, 0.0, 0.1), Some(Inside::From(0.1f32)));
        assert_eq!(inside::<f32>(1.0, 0.0, 0.1f32 as f64 + 1e-12), Some(Inside::From(0.1f32.next_up())));
        assert_eq!(inside::<f64>(1.0, 0.0, -0.0), Some(Inside::From(-0.0)));
        assert_eq!(inside::<u64>(1.0, 0.0, 2f64.powi(63)), Some(Inside::From(1 << 63)));
        // 7 · 0.1 is not 0.7 in binary: the threshold follows the value as computed.
        for raw in 0..=255u8 {
            let iso = 0.1 * f64::from(raw);
            assert_eq!(inside::<u8>(0.1, 0.0, iso), Some(Inside::From(raw)));
            assert_eq!(inside::<u8>(-0.1, 0.0, -iso), Some(Inside::UpTo(raw)));
        }
    }

    #[test]
    fn slopes_beside_a_gap_are_one_sided() {
        let v = Volume::from_slice([5, 2, 2], [1.0; 3], &[1.0, 3.0, f64::NAN, 7.0, 8.0].repeat(4)).unwrap();
        let Samples::F64(samples) = v.samples() else { unreachable!() };
        let field = Field::new(&v, samples, 2.0, DVec3::ZERO);
        let gradient = |x, y, z| field.gradient_f64(&field.row(y, z).unwrap(), x);
        assert_eq!(gradient(1, 0, 0), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(gradient(3, 1, 1), DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(gradient(0, 0, 1), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(field.height(2), f64::NEG_INFINITY);
    }
}
