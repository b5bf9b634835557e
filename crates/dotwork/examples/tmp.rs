use dotwork::*; use std::time::Instant;
fn main(){ let a:Vec<String>=std::env::args().collect(); let mut w=Warnings::new(); let t=Instant::now();
 let raw = if let Some(n)=a[1].strip_prefix("demo:") { if n=="sphere" {dotwork_mesh::shapes::sphere(7)} else {dotwork_mesh::shapes::demo(n).unwrap()} } else { dotwork_io::read_mesh(a[1].as_ref(), &mut w).unwrap() }; let t1=t.elapsed();
 let mut style=preset(&a[3]).unwrap(); let mut s=Scene::default(); let mut n=None;
 for x in &a[4..] { let (k,v)=x.split_once('=').unwrap(); match k { "camera"=>s.camera.set_direction(v).unwrap(), "size"=>{let v:u32=v.parse().unwrap(); s.page=Page::pixels(v,v).unwrap()}, "ortho"=>s.camera.ortho=true, "light"=>s.light=Light::parse(v).unwrap(), "zoom"=>s.camera.zoom=v.parse().unwrap(),"up"=>s.camera.up=v.parse().unwrap(), "n"=>n=Some(v.parse().unwrap()), _=>style.set(k,v).unwrap() } }
 let o=Object::new("o",raw,style,&mut w).unwrap(); let t2=t.elapsed(); s.objects.push(o); if let Some(n)=n { s.stipples=Stipples::Count(n);} 
 s.bake(|_|()); let t3=t.elapsed(); let mut ar=Artist::new(); let mut d=ar.draw(&s); let t4=t.elapsed(); let mut ra=Rasterizer::new(); let mut r=Raster::default(); ra.draw(&d,&mut r); let t5=t.elapsed();
 let f=std::fs::File::create(&a[2]).unwrap(); let px= if r.channels==1 {dotwork_export::Pixels::Grey(&r.samples)} else {dotwork_export::Pixels::Rgb(&r.samples)}; dotwork_export::write_png(f,&dotwork_export::RasterView{width:r.width,height:r.height,pixels:px},11811,&[]).unwrap(); let t6=t.elapsed();
 println!("read {t1:?} build {:?} bake {:?} draw {:?} raster {:?} png {:?} | stock {} dots {} exhausted {:.3}", t2-t1,t3-t2,t4-t3,t5-t4,t6-t5, s.objects[0].stock.as_ref().unwrap().len(), d.dot_count(), ar.exhausted(&s));
 for _ in 0..200 { let t=Instant::now(); s.camera.azimuth+=0.5; ar.draw_into(&s,&mut d); let a=t.elapsed(); ra.draw(&d,&mut r); println!("next: frame {a:?} raster {:?}", t.elapsed()-a); }
 for x in w.iter(){println!("warning: {x}");} }
