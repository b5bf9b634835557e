//! The bake `hierarchy`: vertices of the mesh and of its refinement, in the order in which edges collapse and split.
//!
//! After Meruvia Pastor et al., "Real-Time Animated Stippling" (2003), section IV. The geometry is
//! [`dotwork_mesh::hierarchy`]; here it becomes stipples.

use dotwork_mesh::{HierarchySettings as Points, Mesh};
use rayon::prelude::*;

use super::MAX_STIPPLES;
use crate::stock::Baked;

/// What a hierarchy is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchySettings {
    /// Number of stipples; there are fewer only where rounding keeps a mesh from being split any further.
    pub stipples: usize,
    /// How far vertices are moved at random: 0 leaves them in their rows … 1.
    pub randomize: f32,
    /// Seed of every random choice.
    pub seed: u32,
}

impl Default for HierarchySettings {
    fn default() -> Self {
        HierarchySettings { stipples: 100_000, randomize: 1.0, seed: 0 }
    }
}

/// Bakes `settings.stipples` stipples on `mesh`, each with its relevant neighbours.
///
/// A stipple's id is the number of its vertex in the mesh, or above these that of its split. The order of a larger bake
/// begins with that of a smaller one; the radii are those of all, sorted, so that they differ a little. The result is
/// the same for any number of threads. `progress` is called with a share 0…1, from the calling thread only.
pub fn hierarchy(mesh: &Mesh, settings: &HierarchySettings, progress: impl FnMut(f32)) -> Baked {
    let points = Points {
        points: settings.stipples.min(MAX_STIPPLES),
        randomise: settings.randomize,
        seed: settings.seed,
    };
    let made = dotwork_mesh::hierarchy(mesh, &points, progress);
    Baked {
        id: made.number.par_iter().map(|&number| u64::from(number)).collect(),
        radius: made.radius,
        element: made.face,
        weights: made.weights,
        neighbours: made.neighbours,
        area: mesh.area(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::density::{Arrival, DensityTable};
    use crate::params::Fade;
    use crate::stock::Stock;
    use dotwork_mesh::shapes;

    #[test]
    fn a_stipple_has_a_radius_an_id_and_neighbours_before_it() {
        let raw = shapes::sphere(3);
        let mesh = Mesh::from_slices(&raw.positions, &raw.triangles).unwrap();
        let settings = HierarchySettings { stipples: 20_000, ..HierarchySettings::default() };
        let baked = hierarchy(&mesh, &settings, |_| ());
        assert_eq!(baked.len(), 20_000);
        assert!(baked.radius.is_sorted_by(|a, b| a >= b) && *baked.radius.last().unwrap() > 0.0);
        assert!(baked.id.iter().all(|&id| id < 1 << 38));
        let three = baked.neighbours.iter().filter(|n| n[2] != u32::MAX).count();
        assert!(three * 100 > 99 * baked.len(), "{three} have three neighbours or four");
        // The radius says how many there are: about one for each of its squares.
        let stock = Stock::on_mesh(baked, &mesh);
        let arrival = Arrival { fade: Fade::Off, width: 0.1, min: 0.0 };
        let table = DensityTable::new(&stock.baked, arrival);
        for d in [0.2f32, 0.1, 0.05] {
            let per_square = table.density(d) * f64::from(d * d);
            assert!((0.8..1.1).contains(&per_square), "{per_square} at {d}");
        }
    }
}
