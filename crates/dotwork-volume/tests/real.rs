//! Measured volumes, against what VTK 9.7 makes of them with `vtkFlyingEdges3D`.

mod common;

use common::{iso, mesh_of};
use dotwork_volume::Volume;

/// The same vertices, the same number of triangles; diagonals of polygons differ, and with them the area a little.
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
#[test]
fn surfaces_are_those_of_vtk() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/volumes");
    for (file, dims, at, vertices, triangles, area) in [
        ("neghip_66x66x66_uint8.raw", [66, 66, 66], 60.5, 14348, 28640, 9804.589),
        ("headmr.raw", [48, 62, 42], 60.5, 27557, 55320, 17851.521),
    ] {
        let samples = std::fs::read(format!("{folder}/{file}")).unwrap();
        let volume = Volume::from_vec(dims, [1.0; 3], samples).unwrap();
        let raw = iso(&volume, at);
        assert_eq!((raw.positions.len(), raw.triangles.len()), (vertices, triangles), "{file}");
        let mesh = mesh_of(raw);
        assert!((mesh.area() / area - 1.0).abs() < 0.006, "{file}: {}", mesh.area());
        assert_eq!(mesh.stats().non_manifold_edges, 0, "{file}");
    }
}
