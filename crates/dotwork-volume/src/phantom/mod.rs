//! Phantoms: volumes that the project makes itself, for tests, for figures, and to begin with.
//!
//! Each is a list of solids given by signed distances (`distance`), painted one over the other with the partial
//! volume of a scanner at every boundary (`paint`). The analytic ones ([`shells`], [`plane`], [`box_phantom`]) are
//! oracles: where their surfaces lie is known in closed form. The others stand for what scanners see: [`head`],
//! [`vessels`], [`engine`].
//!
//! A phantom depends on its arguments alone, not on the number of threads.
//!
//! ```
//! use dotwork_volume::phantom;
//!
//! let head = phantom::head(48, 0.0, 0);
//! assert_eq!(head.affine().orientation(), Some(['L', 'P', 'S']));
//! assert!(phantom::PHANTOMS.iter().any(|&(name, _)| name == "vessels"));
//! assert!(phantom::phantom("snowman").is_none());
//! ```

mod distance;
mod head;
mod paint;
mod solids;
mod vessels;

pub use head::head;
pub use solids::{BOX_HALF, PLANE_NORMAL, SHELLS, box_phantom, engine, plane, shells};
pub use vessels::vessels;

use crate::volume::Volume;

/// The names that [`phantom`] knows, with a line on each.
pub const PHANTOMS: &[(&str, &str)] = &[
    ("head", "CT of a human head: skin at -480, bone at 600, teeth, brain (169 x 216 x 256)"),
    ("vessels", "an artery that branches, with an aneurysm: vessels at 115 (192 x 192 x 192)"),
    ("engine", "a cast block with steel sleeves: metal at 60, steel at 170 (256 x 146 x 175)"),
    ("shells", "four nested spheres of known values: 125, 375, 625, 875 (128 x 128 x 128)"),
    ("box", "a box off the grid: 500 (72 x 72 x 72)"),
    ("plane", "a half space off the grid: 500 (64 x 64 x 64)"),
];

/// Voxels along the longest side of the head that [`phantom`] gives.
const HEAD_SIZE: usize = 256;

/// The phantom of this name, see [`PHANTOMS`]; `None` if there is none.
pub fn phantom(name: &str) -> Option<Volume> {
    Some(match name {
        "head" => head(HEAD_SIZE, 0.0, 0),
        "vessels" => vessels(),
        "engine" => engine(0.0),
        "shells" => shells(),
        "box" => box_phantom(33.0),
        "plane" => plane(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_phantom_of_the_size_it_says() {
        for &(name, line) in PHANTOMS {
            let volume = phantom(name).unwrap();
            let [x, y, z] = volume.dims();
            assert!(line.ends_with(&format!("({x} x {y} x {z})")), "{name}: {x} x {y} x {z}");
        }
    }
}
