use dotwork::*;
fn main() {
    let mut args = std::env::args().skip(1);
    let (input, direction, out) = (args.next().unwrap(), args.next().unwrap(), args.next().unwrap());
    let mut style = preset("papers").unwrap();
    for a in args { style.set_pair(&a).unwrap(); }
    let mut w = Warnings::new();
    let t = std::time::Instant::now();
    let mut scene = open(&input, &style, &mut w).unwrap();
    let t_open = t.elapsed();
    scene.page = Page::pixels(900, 900).unwrap();
    scene.camera.set_direction(&direction).unwrap();
    let t = std::time::Instant::now();
    scene.bake(|_| ());
    let t_bake = t.elapsed();
    let stock = scene.objects[0].stock.clone().unwrap();
    let e = stock.elements.as_ref().unwrap();
    let mut artist = Artist::new();
    artist.draw(&scene);
    let t = std::time::Instant::now();
    let d = artist.draw(&scene);
    let t_draw = t.elapsed();
    let mut raster = Raster::default();
    Rasterizer::new().draw(&d, &mut raster);
    let ink: Vec<f64> = raster.samples.iter().map(|&s| { let v = s as f64/255.0; let l = if v<=0.04045 {v/12.92} else {((v+0.055)/1.055).powf(2.4)}; 1.0-l }).collect();
    // mean inside the object: 30 px blocks with any ink
    let (w_, h_) = (raster.width as usize, raster.height as usize);
    let ch = raster.channels as usize;
    let (mut s, mut n, mut most) = (0.0, 0.0, 0.0f64);
    for by in 0..h_/30 { for bx in 0..w_/30 {
        let mut b = 0.0;
        for y in 0..30 { for x in 0..30 { b += ink[((by*30+y)*w_+bx*30+x)*ch]; } }
        b /= 900.0;
        most = most.max(b);
        if b > 0.002 { s += b; n += 1.0; }
    } }
    println!("{input}: open {t_open:?} bake {t_bake:?} draw {t_draw:?} stipples {} voxels {} n_max {:.2} edge {:.2} dots {} ink inside {:.3} darkest block {:.3}", stock.len(), e.len(), e.n_max, e.reach, d.dot_count(), s/n, most);
    for h in dotwork::ink::tone::factor_histograms(e, &style, &scene.view(), &scene.page, scene.light.direction(&scene.view(), scene.camera.up)) {
        if h.on { println!("  {} mean {:.3} above {} bins {:?}", h.name, h.mean, h.above, h.bins); }
    }
    for w in scene.bake_warnings().iter() { println!("  warning: {w}"); }
    write_drawing(&out, Format::Png, &d, &scene, &mut w).unwrap();
}
