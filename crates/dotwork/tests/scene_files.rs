//! Scene files: what they say is what is drawn, and what they get wrong is said with its line.
#![cfg(feature = "files")]

use std::path::Path;
use std::sync::{Arc, Mutex};

use dotwork::{
    Artist, FileError, LoadOptions, Loaded, Scene, Stage, Stipples, Style, Warnings, Watch, load, load_with,
    read_scene_file, settings_text,
};
use glam::Vec3;

fn write(folder: &Path, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn scene(text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "scene.toml", text);
    read_scene_file(path).unwrap().scene(None, &|_| (), &mut Warnings::new()).unwrap().0
}

#[test]
fn objects_have_their_styles_places_and_names() {
    let scene = scene(
        r##"
        style = "hard"
        seed = 7
        stipples = 5000

        [[object]]
        file = "demo:sphere"

        [[object]]
        name = "ring"
        file = "demo:torus"
        style = "night"
        gamma = 2.5
        color = "#804020"
        role = "context"
        scale = 2
        rotate = [90, 0, 0]
        translate = [0, 10, 0]

        [[object]]
        file = "demo:plate"
        role = "hidden"

        [camera]
        azimuth = 30
        elevation = -10
        ortho = true
        zoom = 1.5

        [light]
        elevation = 60

        [page]
        paper = "A6"
        dpi = 150
        margin = "5mm"
        "##,
    );
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["sphere", "ring"]);
    assert_eq!(scene.objects[0].style, dotwork::preset("hard").unwrap());
    let ring = &scene.objects[1];
    let mut style = dotwork::preset("night").unwrap();
    for pair in ["gamma=2.5", "color=#804020", "role=context"] {
        style.set_pair(pair).unwrap();
    }
    assert_eq!(ring.style, style);
    // The demo's ring lies in the plane of x and z; turned about x it stands in that of x and y.
    let bounds = ring.mesh.bounds();
    let own = dotwork::open("demo:torus", &Style::default(), &mut Warnings::new()).unwrap();
    let size = own.objects[0].mesh.bounds().size();
    let turned = Vec3::new(size.x, size.z, size.y) * 2.0;
    assert!(bounds.size().distance(turned) < 1e-4, "{bounds:?} {turned}");
    let shift = Vec3::from_array(ring.mesh.origin.map(|v| v as f32)) + bounds.center();
    assert!(shift.distance(Vec3::new(0.0, 10.0, 0.0)) < 1e-4, "{shift}");
    assert_eq!((scene.camera.azimuth, scene.camera.elevation, scene.camera.zoom), (30.0, -10.0, 1.5));
    assert!(scene.camera.ortho);
    assert_eq!((scene.light.azimuth, scene.light.elevation), (-40.0, 60.0));
    assert_eq!((scene.page.width, scene.page.height), (620, 874));
    assert_eq!((scene.seed, scene.stipples), (7, Stipples::Count(5000)));
}

#[test]
fn included_files_lie_below() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("house")).unwrap();
    write(folder.path(), "house/style.toml", "extends = 'night'\ngamma = 3\n");
    let house = "style = 'style.toml'\nseed = 3\nstipples = 100\n[camera]\nazimuth = 1\nelevation = 2\n[[object]]\nfile = 'demo:plate'\n";
    write(folder.path(), "house/base.toml", house);
    let path = write(
        folder.path(),
        "scene.toml",
        "include = ['house/base.toml']\nseed = 4\n[[object]]\nfile = 'demo:sphere'\n[camera]\ndirection = 'top'\n",
    );
    let file = read_scene_file(&path).unwrap();
    let (scene, _) = file.scene(None, &|_| (), &mut Warnings::new()).unwrap();
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["plate", "sphere"]);
    assert!(scene.objects.iter().all(|o| o.style.gamma == 3.0));
    assert_eq!((scene.seed, scene.stipples, scene.camera.elevation), (4, Stipples::Count(100), 90.0));
    assert_eq!(file.inputs().len(), 4);
}

#[test]
fn objects_that_share_a_volume_are_what_each_is_alone() {
    let object = |keys: &str| format!("[[object]]\nfile = 'demo:shells'\n{keys}\n");
    // Prepared alike, but for the last; the second drops what the others keep.
    let keys = [
        "feature = 'outer'\nkeep = 'all'",
        "feature = 'dense'\nkeep = 1",
        "feature = 2\nkeep = 'all'",
        "feature = 'outer'\nkeep = 'all'\nsmooth = 1",
    ];
    let shared = scene(&keys.map(&object).concat());
    let volume = |k: usize| shared.objects[k].volume.as_ref().unwrap();
    assert!(Arc::ptr_eq(volume(0), volume(2)), "prepared twice");
    assert!(!Arc::ptr_eq(volume(0), volume(3)));
    for (k, keys) in keys.iter().enumerate() {
        let alone = scene(&object(keys));
        let (a, b) = (&shared.objects[k], &alone.objects[0]);
        assert_eq!((&a.mesh.positions, &a.mesh.triangles), (&b.mesh.positions, &b.mesh.triangles), "{keys}");
        assert!(a.volume == b.volume && a.source == b.source && a.style == b.style, "{keys}");
    }
}

#[test]
fn reading_tells_its_stages() {
    let folder = tempfile::tempdir().unwrap();
    let objects = "[[object]]\nfile = 'demo:shells'\n[[object]]\nfile = 'demo:shells'\nfeature = 'dense'\n";
    let path = write(folder.path(), "scene.toml", objects);
    let told = Arc::new(Mutex::new(Vec::new()));
    let watch = {
        let told = told.clone();
        Watch::new(move |stage, share| told.lock().unwrap().push((stage, share)))
    };
    let options = LoadOptions { watch, ..LoadOptions::default() };
    let Loaded::SceneFile(file) = load_with(&path, &options, &mut Warnings::new()).unwrap() else {
        panic!("a scene file")
    };
    let (scene, _) = file.scene(None, &|_| (), &mut Warnings::new()).unwrap();
    assert_eq!(scene.objects.len(), 2);
    let told = told.lock().unwrap().clone();
    let mut stages: Vec<Stage> = told.iter().map(|(stage, _)| *stage).collect();
    stages.dedup();
    // The scene file, its volume once, and a surface for each object.
    assert_eq!(stages, [Stage::Reading, Stage::Preparing, Stage::Surface]);
    let shares = |of: Stage| -> Vec<f32> {
        told.iter().filter(|(stage, _)| *stage == of).map(|(_, share)| *share).collect()
    };
    assert_eq!((shares(Stage::Reading), shares(Stage::Surface)), (vec![0.0; 2], vec![0.0; 2]));
    let preparing = shares(Stage::Preparing);
    assert!(preparing.windows(2).all(|w| w[0] <= w[1]), "{preparing:?}");
    assert!(preparing.len() > 2 && preparing[0] == 0.0 && preparing.last() == Some(&1.0), "{preparing:?}");
}

#[test]
fn labels_of_one_file_are_what_each_is_alone() {
    let folder = tempfile::tempdir().unwrap();
    // Two blocks in one corner each, labels 3 and 7.
    let value = |i: usize| match [i % 16, i / 16 % 16, i / 256] {
        [2..=7, 2..=7, 2..=7] => 3u8,
        [9..=13, 9..=13, 4..=12] => 7,
        _ => 0,
    };
    std::fs::write(folder.path().join("v.raw"), (0..4096).map(value).collect::<Vec<u8>>()).unwrap();
    let object = |name: &str, more: &str| {
        format!("[[object]]\nname = '{name}'\nfile = 'v.raw'\nraw = '16x16x16:u8'\n{more}\n")
    };
    let of = |text: String| {
        let path = write(folder.path(), "scene.toml", &text);
        read_scene_file(path).unwrap().scene(None, &|_| (), &mut Warnings::new()).unwrap().0
    };
    let objects = [
        object("a", "labels = 'auto'\nlabel = 3"),
        object("b", "labels = 'auto'\nlabel = 7"),
        // The same samples as quantities.
        object("c", "iso = 5"),
    ];
    let together = of(objects.concat());
    assert_eq!(together.objects.len(), 3);
    for (object, alone) in together.objects.iter().zip(objects) {
        let alone = &of(alone).objects[0];
        assert!(!object.mesh.triangles.is_empty());
        assert_eq!(object.mesh.positions, alone.mesh.positions, "{}", object.name);
        assert_eq!((&object.source, &object.name), (&alone.source, &alone.name));
    }
}

#[test]
fn two_features_share_a_volume_and_the_focus_shows_through_its_context() {
    let text = |role: &str| {
        format!(
            "stipples = 30000\n[page]\nsize_px = [300, 300]\n\
             [[object]]\nname = 'inner'\nfile = 'demo:shells'\nfeature = 'dense'\nrole = 'focus'\noutlines = false\ndot_size = '2px'\n\
             [[object]]\nname = 'outer'\nfile = 'demo:shells'\nfeature = 'outer'\nrole = '{role}'\noutlines = false\ndot_size = '2px'\nfade = 'off'\nforeshorten = 0\ngrow = 0\nshadow = 0.7\n"
        )
    };
    let dots = |role: &str| {
        let mut scene = scene(&text(role));
        assert_eq!(scene.objects[0].source.as_ref().unwrap().file, "demo:shells");
        scene.bake(|_| ());
        let drawing = Artist::new().draw(&scene);
        [drawing.layers[0].dots.clone(), drawing.layers[1].dots.clone()]
    };
    let ([hidden, whole], [seen, thinned]) = (dots("plain"), dots("context"));
    assert_eq!(hidden.len(), 0, "the shell around it hides the core");
    assert!(seen.len() > 300, "{}", seen.len());
    // In a view of concentric balls the focus covers the middle of the page.
    let ink = |dots: &dotwork::drawing::Dots, inside: bool| {
        let reach = seen.x.iter().zip(&seen.y).map(|(x, y)| (x - 150.0).hypot(y - 150.0)).fold(0.0, f32::max);
        let counted = (0..dots.len()).filter(|&i| {
            let r = (dots.x[i] - 150.0).hypot(dots.y[i] - 150.0);
            if inside { r < reach - 3.0 } else { r > reach + 3.0 }
        });
        counted.map(|i| dots.radius[i].powi(2)).sum::<f32>()
    };
    let (inside, outside) =
        (ink(&thinned, true) / ink(&whole, true), ink(&thinned, false) / ink(&whole, false));
    assert!((inside - 0.25).abs() < 0.05, "context_thin = 0.75 leaves a quarter: {inside}");
    assert!((outside - 1.0).abs() < 1e-6, "{outside}");
}

#[test]
fn lines_of_a_context_are_thinned_before_a_focus() {
    // A ring before a ball, its outline half beside and half before it. In parallel all its width is one.
    let draw = |role: &str, thin: f32| {
        let text = format!(
            "stipples = 3000\n[page]\nsize_px = [500, 500]\n[camera]\nazimuth = 0\nelevation = 0\northo = true\n\
             [[object]]\nfile = 'demo:sphere'\nrole = 'focus'\ndot_size = '4px'\n\
             [[object]]\nfile = 'demo:torus'\nrole = '{role}'\nmode = 'outline'\ncontext_thin = {thin}\n\
             rotate = [90, 0, 0]\ntranslate = [0.7, 0.2, 4]\n"
        );
        let mut scene = scene(&text);
        scene.bake(|_| ());
        Artist::new().draw(&scene)
    };
    let drawing = draw("context", 0.75);
    // The ball's middle on the page, and its radius.
    let dots = &drawing.layers[0].dots;
    let extent = |v: &[f32]| v.iter().fold((f32::MAX, f32::MIN), |(a, b), &x| (a.min(x), b.max(x)));
    let ((left, right), (top, bottom)) = (extent(&dots.x), extent(&dots.y));
    let (x, y, radius) = ((left + right) / 2.0, (top + bottom) / 2.0, (right - left) / 2.0);
    // Width and strength of the line's points that lie before the ball, and of those beside it.
    let points = |drawing: &dotwork::Drawing, before: bool| {
        let strokes = &drawing.layers[1].strokes;
        let of = |i: usize| {
            let away = (strokes.x[i] - x).hypot(strokes.y[i] - y);
            let there = if before { away < radius - 20.0 } else { away > radius + 20.0 };
            there.then(|| (strokes.width[i], strokes.darkness[i]))
        };
        (0..strokes.x.len()).filter_map(of).collect::<Vec<_>>()
    };
    let plain = draw("plain", 0.75);
    let [(width, darkness), ..] = points(&plain, true)[..] else { panic!("no line before the ball") };
    assert_eq!(darkness, 1.0);
    for (drawing, before, share) in
        [(&plain, true, 1.0), (&plain, false, 1.0), (&drawing, true, 0.25), (&drawing, false, 1.0)]
    {
        let points = points(drawing, before);
        assert!(points.len() > 10, "{} points", points.len());
        for (w, d) in points {
            let left = w / width * d;
            assert!((left - share).abs() < 0.01, "{left} of its ink where {share} should be");
            assert!((w / width - d).abs() < 0.01, "narrower and lighter: {w} of {width}, {d}");
        }
    }
    let gone = draw("context", 1.0);
    assert!(points(&gone, true).is_empty());
    assert!(points(&gone, false).iter().filter(|&&(w, d)| w == width && d == 1.0).count() > 10);
}

#[test]
fn modes_say_what_is_drawn() {
    let drawn = |mode: &str| {
        let text = format!(
            "stipples = 2000\n[[object]]\nfile = 'demo:sphere'\n{mode}\n[[object]]\nfile = 'demo:plate'\n"
        );
        let mut scene = scene(&text);
        scene.bake(|_| ());
        let drawing = Artist::new().draw(&scene);
        let of = |layer: &dotwork::drawing::Layer| (!layer.dots.is_empty(), !layer.strokes.is_empty());
        drawing
            .layers
            .iter()
            .filter(|l| l.object == "sphere")
            .map(of)
            .fold((false, false), |a, b| (a.0 || b.0, a.1 || b.1))
    };
    assert_eq!(drawn("mode = 'stippled'"), (true, false));
    assert_eq!(drawn("mode = 'outline'"), (false, true));
    assert_eq!(drawn("mode = 'both'\nstyle = 'outline'"), (true, true));
    assert_eq!(drawn("mode = 'hidden'"), (false, false));
}

#[test]
fn its_plate_is_drawn_again_with_every_object_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(
        folder.path(),
        "scene.toml",
        "stipples = 3000\n[page]\nsize_px = [120, 100]\n[[object]]\nfile = 'demo:torus'\n\
         [[object]]\nfile = 'demo:sphere'\nscale = 0.5\nrotate = [1, 2, 3]\ntranslate = [0.5, -0.25, 0.125]\n",
    );
    let mut scene = read_scene_file(path).unwrap().scene(None, &|_| (), &mut Warnings::new()).unwrap().0;
    let drawing = scene.draw();
    let plate = folder.path().join("plate.svg");
    dotwork::write_drawing(&plate, dotwork::Format::Svg, &drawing, &scene, &mut Warnings::new()).unwrap();
    let Loaded::Plate(again) = load(&plate, &mut Warnings::new()).unwrap() else { panic!("a plate") };
    let mut again = again.scene(&mut Warnings::new()).unwrap();
    assert_eq!(settings_text(&again), settings_text(&scene));
    assert_eq!(again.draw(), drawing);
}

#[test]
fn errors_name_the_file_and_the_line() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "loop.toml", "include = ['scene.toml']\n");
    for (text, line, part) in [
        ("# nothing\n", 1, "no [[object]]"),
        ("gamma = 2\n", 1, "a scene has no 'gamma'"),
        ("[[object]]\nname = 'a'\n", 2, "has no file"),
        ("[[object]]\nfile = 'demo:plate'\n\ngama = 2\n", 4, "did you mean 'gamma'?"),
        ("[[object]]\nfile = 'demo:plate'\ngamma = 99\n", 3, "gamma takes a number"),
        ("[[object]]\nfile = 'demo:plate'\nrole = 'star'\n", 3, "focus, context"),
        ("[[object]]\nfile = 'demo:plate'\nmode = 'plain'\n", 3, "shaded, stippled, both, outline or hidden"),
        ("[[object]]\nfile = 'demo:plate'\nstyle = 'brigt'\n", 3, "there is no style 'brigt'"),
        ("[[object]]\nfile = 'demo:plate'\nscale = 0\n", 3, "scale"),
        ("[[object]]\nfile = 'demo:plate'\ntranslate = [1, 2]\n", 3, "3 numbers"),
        ("[[object]]\nfile = 'demo:plate'\n[camera]\nazimuth = 3\n", 4, "go together"),
        ("[[object]]\nfile = 'demo:plate'\n[camera]\nfov = 3\n", 4, "[camera] has no 'fov'"),
        ("[[object]]\nfile = 'demo:plate'\n[page]\nsize_px = [0, 10]\n", 4, "no area"),
        ("[[object]]\nfile = 'demo:plate'\n[page]\npaper = 'B9'\n", 4, "not a page"),
        ("object = 3\n", 1, "[[object]]"),
        ("seed = -1\n", 1, "whole number"),
        ("include = ['loop.toml']\n", 1, "includes itself"),
        ("seed = \n", 1, ""),
    ] {
        let path = write(folder.path(), "scene.toml", text);
        match read_scene_file(&path) {
            Err(FileError::Scene { path: at, line: found, reason }) => {
                assert!(found == line && reason.contains(part), "{text:?}: {found}: {reason}");
                assert_eq!(at, path, "{text:?}");
            }
            other => panic!("{text:?}: {other:?}"),
        }
    }
    // What only the object's file can tell is said with the object's line.
    for (text, line, part) in [
        ("seed = 1\n[[object]]\nfile = 'gone.ply'\n", 3, "gone.ply"),
        ("[[object]]\nfile = 'demo:shells'\nfeature = '9'\n", 2, "there is no feature 9; its features are 1"),
        ("[[object]]\nfile = 'demo:nothing'\n", 2, "there is no such demo"),
    ] {
        let path = write(folder.path(), "scene.toml", text);
        match read_scene_file(&path).unwrap().scene(None, &|_| (), &mut Warnings::new()) {
            Err(FileError::Scene { line: found, reason, .. }) => {
                assert!(found == line && reason.contains(part), "{text:?}: {found}: {reason}");
            }
            other => panic!("{text:?}: {other:?}"),
        }
    }
}
