//! What every mesh reader ends with: polygons cut into fans, colours in bytes, coordinates brought near the origin.

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::error::ReadErrorKind;

/// The names of the coordinates, for messages.
pub(crate) const AXES: [char; 3] = ['x', 'y', 'z'];

/// Coordinates farther from zero than this many extents of their bounding box lose too much in `f32`: an origin is
/// subtracted. At the limit `f32` still resolves 1/8000 of the box.
const FAR: f64 = 1000.0;

/// Vertex positions in the precision of the file.
pub(crate) enum Coordinates {
    /// Every coordinate was stored as `f32`.
    Single(Vec<[f32; 3]>),
    /// Anything else.
    Double(Vec<[f64; 3]>),
}

/// Refuses more vertices than 32-bit indices reach.
pub(crate) fn check_vertex_count(count: u64) -> Result<(), ReadErrorKind> {
    if count > u64::from(u32::MAX) {
        return Err(ReadErrorKind::TooLarge(format!(
            "declares {count} vertices; at most {} can be read",
            u32::MAX
        )));
    }
    Ok(())
}

/// Triangles as they come out of polygons.
#[derive(Default)]
pub(crate) struct Faces {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Faces with three corners or more.
    pub(crate) polygons: usize,
    short: u64,
    first_short: Option<String>,
}

impl Faces {
    /// Adds a polygon as a fan about its first corner; one with under three corners is only counted.
    #[inline]
    pub(crate) fn push(&mut self, corners: &[u32], place: impl FnOnce() -> String) {
        match corners {
            &[a, b, c] => self.triangles.push([a, b, c]),
            [] | [_] | [_, _] => {
                self.short += 1;
                self.first_short.get_or_insert_with(place);
                return;
            }
            &[a, ref others @ ..] => self.triangles.extend(others.windows(2).map(|w| [a, w[0], w[1]])),
        }
        self.polygons += 1;
    }

    /// Adds the triangles of a strip, every other one turned; [`RESTART`] begins a new strip. A repeated index only
    /// leads the strip on.
    pub(crate) fn push_strip(&mut self, strip: &[u32]) {
        for run in strip.split(|&index| index == RESTART) {
            for (i, w) in run.windows(3).enumerate() {
                let (a, b, c) = (w[0], w[1], w[2]);
                if a == b || b == c || c == a {
                    continue;
                }
                self.triangles.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                self.polygons += 1;
            }
        }
    }

    /// The finished mesh; `colors` are one for each vertex, or none.
    ///
    /// # Errors
    /// No faces; a coordinate beyond `f32`.
    pub(crate) fn into_mesh(
        self,
        coordinates: Coordinates,
        colors: Vec<[u8; 4]>,
        warnings: &mut Warnings,
    ) -> Result<RawMesh, ReadErrorKind> {
        warnings.counted("faces with fewer than three corners dropped", self.short, self.first_short);
        if self.triangles.is_empty() {
            return Err(ReadErrorKind::NoFaces);
        }
        let (positions, origin) = match coordinates {
            Coordinates::Single(positions) => near_origin_single(positions),
            Coordinates::Double(positions) => near_origin_double(&positions)?,
        };
        Ok(RawMesh {
            positions,
            triangles: self.triangles,
            origin,
            polygons: self.polygons,
            colors,
            ..RawMesh::default()
        })
    }
}

/// The index that ends a strip and begins the next (-1 in signed numbers); never that of a vertex.
pub(crate) const RESTART: u32 = u32::MAX;

/// Colours of vertices in whatever numbers the file has.
#[derive(Default)]
pub(crate) struct Colors {
    /// Red, green, blue, opacity; not numbers where the vertex has no colour.
    values: Vec<[f32; 4]>,
    strange: u64,
    first_strange: usize,
}

impl Colors {
    /// No colour at all: white.
    const NONE: [f32; 4] = [f32::NAN; 4];

    /// Gives the vertex (counted from 0) a colour; vertices are coloured in ascending order.
    #[inline]
    pub(crate) fn set(&mut self, vertex: usize, rgb: [f32; 3], opacity: Option<f32>) {
        self.values.resize(vertex, Self::NONE);
        if rgb.iter().all(|c| c.is_finite()) {
            self.values.push([rgb[0], rgb[1], rgb[2], opacity.unwrap_or(f32::NAN)]);
            return;
        }
        if self.strange == 0 {
            self.first_strange = vertex;
        }
        self.strange += 1;
        self.values.push(Self::NONE);
    }

    /// The colours of all `vertices` in bytes, or none if no vertex had any. `full` is the number that means the whole
    /// of a channel; without it that is 1 if no number is larger, else 255.
    pub(crate) fn finish(
        mut self,
        vertices: usize,
        full: Option<f32>,
        warnings: &mut Warnings,
    ) -> Vec<[u8; 4]> {
        let first = Some(format!("vertex {}", self.first_strange + 1));
        warnings.counted("colours that are not numbers replaced by white", self.strange, first);
        if self.values.is_empty() {
            return Vec::new();
        }
        self.values.resize(vertices, Self::NONE);
        // `f32::max` passes over what is no number.
        let largest = |k: usize| self.values.iter().fold(0.0f32, |m, c| m.max(c[k]));
        let opacity = largest(3);
        let color = (0..4).map(largest).fold(0.0, f32::max);
        let guess = |largest: f32| full.unwrap_or(if largest > 1.0 { 255.0 } else { 1.0 });
        // Opacity may be 0…1 beside colours of 0…255, but hardly the other way round.
        let full = [guess(color), guess(color), guess(color), guess(opacity)];
        let byte = |c: f32, full: f32| if c.is_nan() { 255 } else { (c / full * 255.0).round() as u8 };
        self.values.iter().map(|c| [0, 1, 2, 3].map(|k| byte(c[k], full[k]))).collect()
    }
}

fn near_origin_single(mut positions: Vec<[f32; 3]>) -> (Vec<[f32; 3]>, [f64; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in &positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let origin = origin_of(low.map(f64::from), high.map(f64::from));
    if origin != [0.0; 3] {
        for p in &mut positions {
            for k in 0..3 {
                p[k] = (f64::from(p[k]) - origin[k]) as f32;
            }
        }
    }
    (positions, origin)
}

fn near_origin_double(positions: &[[f64; 3]]) -> Result<(Vec<[f32; 3]>, [f64; 3]), ReadErrorKind> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let origin = origin_of(low, high);
    for k in 0..3 {
        let farthest = (low[k] - origin[k]).abs().max((high[k] - origin[k]).abs());
        if !(farthest as f32).is_finite() && !positions.is_empty() {
            let axis = AXES[k];
            return Err(ReadErrorKind::TooLarge(format!(
                "has {axis} from {:e} to {:e}, beyond the range of single precision",
                low[k], high[k]
            )));
        }
    }
    let single = positions.iter().map(|p| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)).collect();
    Ok((single, origin))
}

/// The centre of the box, rounded to its decimal magnitude, if the box is [`FAR`] from zero; else zero.
fn origin_of(low: [f64; 3], high: [f64; 3]) -> [f64; 3] {
    let farthest = (0..3).map(|k| low[k].abs().max(high[k].abs())).fold(0.0, f64::max);
    let extent = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    // Non-finite where there are no vertices, or where they span more than f64: nothing to bring near.
    if !farthest.is_finite() || !extent.is_finite() || farthest <= FAR * extent {
        return [0.0; 3];
    }
    let magnitude = if extent > 0.0 { extent.log10().floor() } else { farthest.log10().floor() - 6.0 };
    [0, 1, 2].map(|k| {
        let center = 0.5 * low[k] + 0.5 * high[k];
        // Decimal steps read well in messages; multiplying and dividing by 10ⁿ, n ≥ 0, rounds best.
        let step = 10f64.powi(magnitude.abs() as i32);
        let rounded =
            if magnitude < 0.0 { (center * step).round() / step } else { (center / step).round() * step };
        if rounded.is_finite() { rounded } else { center }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_boxes_get_a_rounded_origin() {
        let at = |low, high| origin_of(low, high);
        assert_eq!(at([-1.0; 3], [1.0; 3]), [0.0; 3]);
        assert_eq!(at([2000.0, 0.1, 0.2], [2000.8, 0.9, 1.0]), [2000.4, 0.5, 0.6]);
        assert_eq!(at([999.0, 0.0, 0.0], [1000.0, 1.0, 1.0]), [0.0; 3], "at the limit nothing moves");
        assert_eq!(
            at([4_321_034.5, 512_011.0, 0.0], [4_321_234.5, 512_200.0, 60.0]),
            [4_321_100.0, 512_100.0, 0.0]
        );
        assert_eq!(at([0.123_45, 0.0, 0.0], [0.123_46, 0.0, 0.0])[0], 0.123_455);
        assert_eq!(at([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), [0.0; 3], "no vertices");
        assert_eq!(at([-1e308; 3], [1e308; 3]), [0.0; 3]);
        assert!(at([5e-320; 3], [5e-320; 3])[0].is_finite());
    }

    #[test]
    fn coordinates_beyond_single_precision_are_refused() {
        assert!(near_origin_double(&[[1e39, 0.0, 0.0], [0.0; 3]]).is_err());
        let (positions, origin) = near_origin_double(&[[1e39, 0.0, 0.0], [1e39, 1.0, 0.0]]).unwrap();
        assert!(positions.iter().flatten().all(|v| v.is_finite()) && origin[0].is_finite());
    }

    #[test]
    fn strips_alternate_restart_and_pass_over_repeats() {
        let mut faces = Faces::default();
        faces.push_strip(&[0, 1, 2, 3, RESTART, 4, 5, 6, RESTART, RESTART, 7, 8, RESTART, 0, 1, 1, 2, 3]);
        assert_eq!(faces.triangles, [[0, 1, 2], [2, 1, 3], [4, 5, 6], [1, 2, 3]]);
        assert_eq!(faces.polygons, 4);
    }

    #[test]
    fn colours_find_their_scale() {
        let finish = |colors: &[([f32; 3], Option<f32>)], full| {
            let mut gathered = Colors::default();
            colors.iter().enumerate().for_each(|(v, &(rgb, a))| gathered.set(v, rgb, a));
            let mut warnings = Warnings::new();
            (gathered.finish(3, full, &mut warnings), warnings.is_empty())
        };
        let white = [255; 4];
        let floats = [([1.0, 0.5, 0.0], None), ([0.0, 2.0 / 255.0, 1.0], Some(0.2))];
        assert_eq!(finish(&floats, None).0, [[255, 128, 0, 255], [0, 2, 255, 51], white]);
        let bytes = [([1.0, 0.0, 0.0], None), ([300.0, -2.0, 1.0], Some(255.0))];
        assert_eq!(finish(&bytes, None).0, [[1, 0, 0, 255], [255, 0, 1, 255], white]);
        let mixed = [([200.0, 0.0, 0.0], Some(1.0)), ([0.0, 0.0, 1.0], Some(0.5))];
        assert_eq!(finish(&mixed, None).0, [[200, 0, 0, 255], [0, 0, 1, 128], white]);
        let black = [([0.0; 3], Some(255.0))];
        assert_eq!(finish(&black, None).0, [[0, 0, 0, 255], white, white]);
        assert_eq!(finish(&[([65535.0, 0.0, 0.0], None)], Some(65535.0)).0[0], [255, 0, 0, 255]);
        assert_eq!(finish(&[([1.0, f32::NAN, 0.0], None)], None), (vec![white; 3], false));
        assert_eq!(finish(&[], None), (vec![], true));
    }

    #[test]
    fn polygons_become_fans() {
        let mut faces = Faces::default();
        faces.push(&[0, 1, 2, 3, 4], || unreachable!());
        faces.push(&[5, 6], || "face 2".into());
        faces.push(&[], || "face 3".into());
        assert_eq!(faces.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!((faces.polygons, faces.short), (1, 2));
        assert_eq!(faces.first_short.as_deref(), Some("face 2"));
    }
}
