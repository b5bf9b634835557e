//! The bake `hierarchy` in scenes: chosen by the style, kept by `.dots` files, drawn by radius or by edges.
#![cfg(feature = "files")]

use dotwork::ink::{BakeMethod, Relevance};
use dotwork::{
    Artist, Format, Scene, Stipples, Style, Warnings, encode_dots, encode_drawing, open, save_dots,
};

fn scene(name: &str, stipples: Stipples) -> Scene {
    let style = Style { bake: BakeMethod::Hierarchy, ..Style::default() };
    let mut scene = open(name, &style, &mut Warnings::new()).expect("a demo");
    scene.stipples = stipples;
    scene.bake(|_| ());
    scene
}

fn csv(scene: &Scene) -> Vec<u8> {
    let drawing = Artist::new().draw(scene);
    let mut bytes = Vec::new();
    encode_drawing(&mut bytes, Format::Csv, false, &drawing, scene, &mut Warnings::new()).expect("memory");
    bytes
}

#[test]
fn a_dots_file_gives_the_hierarchy_back() {
    for relevance in [Relevance::Radius, Relevance::Edges] {
        let mut before = scene("demo:teapot", Stipples::Count(20_000));
        before.objects[0].style.relevance = relevance;
        let stock = before.objects[0].stock.clone().expect("baked");
        assert_eq!((stock.len(), stock.baked.neighbours.len()), (20_000, 20_000));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("teapot.dots");
        save_dots(&path, &before).expect("written");
        let after = open(&path, &Style::default(), &mut Warnings::new()).expect("read");
        assert_eq!(after.objects[0].stock.as_deref(), Some(&*stock));
        assert_eq!(csv(&after), csv(&before));
        assert_eq!(encode_dots(&after), encode_dots(&before));
    }
}

#[test]
fn another_style_asks_for_another_bake() {
    let mut scene = scene("demo:sphere", Stipples::Count(2000));
    let object = &mut scene.objects[0];
    // Tone and lines leave the stipples alone; who makes them, and how far they move, does not.
    let darker = Style { tone: 0.5, relevance: Relevance::Edges, ..object.style.clone() };
    object.restyle(darker).expect("sound");
    assert!(object.stock.is_some());
    let straight = Style { randomize: 0.0, ..object.style.clone() };
    object.restyle(straight).expect("sound");
    assert!(object.stock.is_none());
    scene.bake(|_| ());
    let object = &mut scene.objects[0];
    object.restyle(Style { bake: BakeMethod::BlueNoise, ..object.style.clone() }).expect("sound");
    assert!(object.stock.is_none());
    scene.bake(|_| ());
    assert!(scene.objects[0].stock.as_ref().is_some_and(|stock| stock.baked.neighbours.is_empty()));
}

#[test]
fn auto_bakes_what_the_darkest_tone_needs() {
    let mut scene = scene("demo:teapot", Stipples::Auto);
    let mut artist = Artist::new();
    let drawing = artist.draw(&scene);
    let count = scene.objects[0].stock.as_ref().map_or(0, |stock| stock.len());
    assert!(count >= 16_384 && count > drawing.dot_count());
    assert!(artist.exhausted(&scene) < 0.005);
    // About as many as blue noise: the page asks for ink and not for a method, but a less even order overlaps more.
    scene.objects[0].restyle(Style::default()).expect("sound");
    scene.bake(|_| ());
    let even = scene.objects[0].stock.as_ref().map_or(0, |stock| stock.len());
    assert!((count as f64 / even as f64 - 1.0).abs() < 0.1, "{count} against {even}");
}

#[test]
fn isosurfaces_have_hierarchies_too() {
    let scene = scene("demo:shells", Stipples::Count(5000));
    let stock = scene.objects[0].stock.as_ref().expect("baked");
    assert_eq!((stock.len(), stock.baked.neighbours.len()), (5000, 5000));
}
