//! What a backend keeps from frame to frame never shows: each frame is that of a backend which has drawn nothing before.

use dotwork_drawing::{Camera, Color, Warnings};
use dotwork_ink::{BakeSettings, MeshSurface, blue_noise, preset};
use dotwork_mesh::{MeshOptions, shapes};

use super::*;

fn mesh(name: &str) -> Arc<Mesh> {
    let raw = shapes::demo(name).unwrap();
    Arc::new(Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap())
}

struct Body {
    mesh: Arc<Mesh>,
    lines: Arc<SurfaceLines>,
    stock: Stock,
}

impl Body {
    fn new(name: &str) -> Body {
        let mesh = mesh(name);
        let baked = blue_noise(
            &MeshSurface::new(&*mesh),
            &BakeSettings { stipples: 4000, ..BakeSettings::default() },
            |_| (),
        );
        let stock = Stock::on_mesh(baked, &mesh);
        Body { lines: Arc::new(SurfaceLines::find(&mesh, 40.0)), mesh, stock }
    }
}

#[test]
fn what_is_kept_never_shows() {
    let bodies = [Body::new("torus"), Body::new("teapot")];
    let styles = |set: &str| {
        let mut styles = [preset("soft").unwrap(), preset("soft").unwrap()];
        for pair in set.split_whitespace() {
            let (key, value) = pair.split_once('=').unwrap();
            styles[1].set(key, value).unwrap();
        }
        styles
    };
    let mut kept = CpuBackend::new();
    let mut seen = Vec::new();
    // Turn of the eye, height of the light, size of the page, order of the objects, style of the second.
    for (azimuth, light, size, swapped, set) in [
        (0.0, 1.0, 200, false, ""),
        (0.0, 0.5, 200, false, ""),
        (0.5, 0.5, 200, false, ""),
        (0.5, 0.5, 200, false, "gamma=2"),
        (0.5, 0.5, 200, false, "outline=3px"),
        (0.5, 0.5, 200, false, "outline_min=900%"),
        (0.5, 0.5, 200, false, "visibility=facing"),
        (0.5, 0.5, 200, false, "visibility=through"),
        (0.5, 0.5, 200, false, "occlusion=0.3"),
        (0.5, 0.5, 200, false, "two_sided=true"),
        (0.5, 0.5, 200, false, "role=context"),
        (0.5, 0.5, 200, false, "role=context context_thin=0.2"),
        (0.5, 0.5, 200, true, "role=context"),
        (0.5, 0.5, 240, true, ""),
        (0.5, 0.5, 200, true, "outlines=false"),
        (0.5, 0.5, 200, false, ""),
    ] {
        let page = Page::pixels(size, 200).unwrap();
        let view = Camera { azimuth, ..Camera::default() }.view(Vec3::ZERO, 1.5, &page);
        let styles = styles(set);
        let plans = [0, 1].map(|k| InkPlan::new(&bodies[k].stock, &styles[k], &page));
        let mut subjects = [0, 1].map(|k| Subject {
            name: "o",
            mesh: &bodies[k].mesh,
            lines: &bodies[k].lines,
            curves: None,
            stock: &bodies[k].stock,
            style: &styles[k],
            plan: &plans[k],
        });
        if swapped {
            subjects.reverse();
        }
        let light = Vec3::new(-1.0, light, 1.0).normalize();
        let frame = Frame { subjects: &subjects, view: &view, light, page: &page };
        let draw = |backend: &mut CpuBackend| {
            let mut drawing = Drawing::new(page, Color::WHITE);
            backend.frame(&frame, &mut drawing);
            drawing
        };
        let drawing = draw(&mut kept);
        assert!(drawing == draw(&mut CpuBackend::new()), "{azimuth} {light} {size} {swapped} {set}");
        if !seen.contains(&drawing) {
            seen.push(drawing);
        }
    }
    // The frames differ: what they are made from matters.
    assert!(seen.len() >= 8, "{}", seen.len());
}
