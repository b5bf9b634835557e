//! What is taken away: half-spaces, and what they have in common or cover together.

use glam::DVec3;
use thiserror::Error;

/// The most planes of a region whose planes must all agree; a triangle keeps one bit for each.
const MAX_PLANES: usize = 32;

/// What a text for [`ClipRegion::parse`] may be.
const GRAMMAR: &str = "clip planes are x>0.5, x<0.5 (x, y or z, and a share of the object's box from 0 to 1) or \
                       plane=NX,NY,NZ,SHARE, several joined by ;";

/// A plane, and the side of it that is removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    /// Unit normal, pointing to the part that is removed.
    pub normal: DVec3,
    /// Points of the plane have `normal · p = offset`, world units.
    pub offset: f64,
}

impl ClipPlane {
    /// The plane `normal · p = offset`, with the side to which `normal` points removed; both are divided by the
    /// length of `normal`.
    ///
    /// # Errors
    /// [`ClipError::Plane`] if a number is not finite or the normal has no length.
    pub fn new(normal: DVec3, offset: f64) -> Result<ClipPlane, ClipError> {
        let length = normal.length();
        let plane = ClipPlane { normal: normal / length, offset: offset / length };
        // A normal that is a unit already, like that of an axis, keeps its bits.
        let plane = if (length - 1.0).abs() < 1e-15 { ClipPlane { normal, offset } } else { plane };
        let sound = (plane.normal.length() - 1.0).abs() < 1e-6 && plane.offset.is_finite();
        if sound { Ok(plane) } else { Err(ClipError::Plane { normal: normal.to_array(), offset }) }
    }

    /// How far `point` lies on the removed side, world units; negative on the other.
    #[inline]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// The same plane with the other side removed.
    pub fn flipped(&self) -> ClipPlane {
        ClipPlane { normal: -self.normal, offset: -self.offset }
    }
}

/// Why planes or a box say nothing that could be removed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ClipError {
    /// The normal has no direction, or a number is not finite.
    #[error("no plane has the normal {normal:?} and the offset {offset}")]
    Plane {
        /// The normal asked for.
        normal: [f64; 3],
        /// The offset asked for.
        offset: f64,
    },
    /// Too many planes that must all agree.
    #[error("{0} clip planes are more than the {MAX_PLANES} that can be used together")]
    TooManyPlanes(usize),
    /// The sides of a box are swapped, coincide, are NaN, or are all infinite.
    #[error("the clip box from {min:?} to {max:?} is empty or has no sides")]
    Box {
        /// Lowest corner.
        min: [f64; 3],
        /// Highest corner.
        max: [f64; 3],
    },
}

/// A box along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipBox {
    /// Lowest corner, world units; −∞ leaves a side open.
    pub min: DVec3,
    /// Highest corner, world units; ∞ leaves a side open.
    pub max: DVec3,
    /// True: what lies in the box is removed (a cutaway). False: what lies outside it (a crop).
    pub remove_inside: bool,
}

impl ClipBox {
    /// The box as planes.
    ///
    /// # Errors
    /// [`ClipError::Box`].
    pub fn region(&self) -> Result<ClipRegion, ClipError> {
        let empty = ClipError::Box { min: self.min.to_array(), max: self.max.to_array() };
        // Written so that NaN is refused.
        if !(0..3).all(|a| self.min[a] < self.max[a]) {
            return Err(empty);
        }
        let sides = (0..3).flat_map(|a| {
            [(DVec3::AXES[a], self.min[a]), (-DVec3::AXES[a], -self.max[a])]
                .map(|(normal, offset)| ClipPlane { normal, offset })
        });
        let inwards: Vec<ClipPlane> = sides.filter(|p| p.offset.is_finite()).collect();
        if inwards.is_empty() {
            return Err(empty);
        }
        if self.remove_inside {
            ClipRegion::common(&inwards)
        } else {
            ClipRegion::union(&inwards.iter().map(ClipPlane::flipped).collect::<Vec<_>>())
        }
    }
}

/// How the removed sides of several planes combine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipRule {
    /// Removed is what lies on the removed side of *all* planes: a convex piece is cut out.
    All,
    /// Removed is what lies on the removed side of *any* plane: a convex piece is kept.
    Any,
}

/// The part of the world that is removed: what half-spaces have in common, or what they cover together.
///
/// The region is open: points on a plane are kept.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipRegion {
    planes: Vec<ClipPlane>,
    rule: ClipRule,
}

impl ClipRegion {
    /// Removes what lies on the removed side of *all* planes; no planes remove nothing.
    ///
    /// # Errors
    /// [`ClipError`]: a plane is not sound, or there are more than 32.
    pub fn common(planes: &[ClipPlane]) -> Result<ClipRegion, ClipError> {
        let region = ClipRegion::new(planes, ClipRule::All)?;
        let count = region.planes.len();
        if count > MAX_PLANES { Err(ClipError::TooManyPlanes(count)) } else { Ok(region) }
    }

    /// Removes what lies on the removed side of *any* plane.
    ///
    /// # Errors
    /// [`ClipError::Plane`].
    pub fn union(planes: &[ClipPlane]) -> Result<ClipRegion, ClipError> {
        ClipRegion::new(planes, ClipRule::Any)
    }

    fn new(planes: &[ClipPlane], rule: ClipRule) -> Result<ClipRegion, ClipError> {
        let mut region = ClipRegion { planes: Vec::with_capacity(planes.len()), rule };
        for plane in planes {
            let plane = ClipPlane::new(plane.normal, plane.offset)?;
            // A plane said twice would have two cut faces.
            if !region.planes.contains(&plane) {
                region.planes.push(plane);
            }
        }
        Ok(region)
    }

    /// The planes, each once, in the order given.
    pub fn planes(&self) -> &[ClipPlane] {
        &self.planes
    }

    /// How they combine.
    pub fn rule(&self) -> ClipRule {
        self.rule
    }

    /// True if `point` (world units) is removed.
    #[inline]
    pub fn removes(&self, point: DVec3) -> bool {
        let mut removed = self.planes.iter().map(|p| p.distance(point) > 0.0);
        match self.rule {
            ClipRule::All => !self.planes.is_empty() && removed.all(|r| r),
            ClipRule::Any => removed.any(|r| r),
        }
    }

    /// Reads clip planes: `x>0.5` removes the part of the object beyond the middle of its bounding box along x,
    /// `y<0.3` the lowest 30 % along y, `plane=1,1,0,0.5` what lies beyond half of the object's extent in the
    /// direction (1, 1, 0). Several, joined by `;`, remove what satisfies *all* of them: `x>0.5;y<0.5;z>0.5` an octant.
    ///
    /// `bounds` are the lowest and the highest corner of the object's box, world units. Blanks and case do not matter.
    ///
    /// ```
    /// use dotwork_mesh::ClipRegion;
    /// use glam::DVec3;
    ///
    /// let octant = ClipRegion::parse("x > 0.5; y < 0.25; z > 0", [DVec3::ZERO, DVec3::splat(8.0)])?;
    /// assert!(octant.removes(DVec3::new(5.0, 1.0, 1.0)));
    /// assert!(!octant.removes(DVec3::new(5.0, 3.0, 1.0)));
    /// # Ok::<(), String>(())
    /// ```
    ///
    /// # Errors
    /// One clear sentence that names the part of the text at fault.
    pub fn parse(text: &str, bounds: [DVec3; 2]) -> Result<ClipRegion, String> {
        let compact: String = text.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_lowercase();
        let mut planes = Vec::new();
        for part in compact.split(';').filter(|part| !part.is_empty()) {
            planes.push(parse_plane(part, bounds).map_err(|why| format!("{part}: {why}"))?);
        }
        if planes.is_empty() {
            return Err(format!("no clip plane in {text:?}: {GRAMMAR}"));
        }
        for (i, a) in planes.iter().enumerate() {
            if planes[..i].iter().any(|b| a.normal == -b.normal && a.offset >= -b.offset) {
                return Err(format!("{compact} removes nothing: no point satisfies all of it"));
            }
        }
        ClipRegion::common(&planes).map_err(|e| e.to_string())
    }
}

/// One part of the text, without blanks and in lower case.
fn parse_plane(part: &str, [min, max]: [DVec3; 2]) -> Result<ClipPlane, String> {
    let number = |word: &str| {
        word.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| format!("{word:?} is not a number"))
    };
    let (normal, share) = if let Some(numbers) = part.strip_prefix("plane=") {
        let numbers = numbers.split(',').map(number).collect::<Result<Vec<f64>, String>>()?;
        let [x, y, z, share] = numbers[..] else {
            return Err(format!("{} numbers instead of four; {GRAMMAR}", numbers.len()));
        };
        (DVec3::new(x, y, z).try_normalize().ok_or("the direction has no length")?, share)
    } else {
        let axis = part.bytes().next().and_then(|first| b"xyz".iter().position(|&axis| axis == first));
        let side = part.get(1..2).map(|sign| if sign == ">" { 1.0 } else { -1.0 });
        match (axis, side, part.get(1..2)) {
            (Some(axis), Some(side), Some(">" | "<")) => (side * DVec3::AXES[axis], number(&part[2..])?),
            _ => return Err(format!("not a clip plane; {GRAMMAR}")),
        }
    };
    if !(0.0..=1.0).contains(&share) {
        return Err(format!("{share} is not a share from 0 to 1"));
    }
    // Shares of an axis count upwards whichever side is removed, those of a free direction along it.
    let share = if part.get(1..2) == Some("<") { 1.0 - share } else { share };
    // The extent of the box along the normal: each side at its farther end.
    let [low, high] = [DVec3::min, DVec3::max].map(|of| of(normal * min, normal * max).element_sum());
    ClipPlane::new(normal, low + share * (high - low)).map_err(|e| e.to_string())
}
