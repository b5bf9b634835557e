use dotwork_ink::*;
use dotwork_mesh::Mesh;
use glam::Vec3;
use std::time::Instant;
fn mesh(p: Vec<Vec3>, t: Vec<[u32;3]>) -> Mesh { let n = p.len(); Mesh{positions:p, corner_normals:t.clone(), triangles:t, normals: vec![Vec3::Z;n], origin:[0.0;3], closed:false} }
fn ply(path:&str)->Mesh{ let b=std::fs::read(path).unwrap(); let h=b.windows(11).position(|w| w==b"end_header\n").unwrap()+11; let head=String::from_utf8_lossy(&b[..h]); let mut nv=0;let mut nf=0; for l in head.lines(){ if let Some(x)=l.strip_prefix("element vertex "){nv=x.parse().unwrap()} if let Some(x)=l.strip_prefix("element face "){nf=x.parse().unwrap()} }
 let f=|o:usize| f32::from_le_bytes(b[o..o+4].try_into().unwrap()); let mut o=h; let mut p=vec![]; for _ in 0..nv { p.push(Vec3::new(f(o),f(o+4),f(o+8))); o+=12;} let mut t=vec![]; for _ in 0..nf { o+=1; let g=|k:usize| u32::from_le_bytes(b[o+4*k..o+4*k+4].try_into().unwrap()); t.push([g(0),g(1),g(2)]); o+=12;} mesh(p,t)}
fn quality(pos:&[Vec3], nor:&[Vec3], area:f64)->(f64,f64){
 let n=pos.len(); let hex=(2.0*area/(3f64.sqrt()*n as f64)).sqrt(); let cell=hex as f32*1.2; 
 use std::collections::HashMap; let mut h:HashMap<[i32;3],Vec<usize>>=HashMap::new(); let key=|p:Vec3| (p/cell).floor().as_ivec3().to_array();
 for (i,p) in pos.iter().enumerate(){h.entry(key(*p)).or_default().push(i);} let (mut mn,mut sum)=(f64::MAX,0.0);
 for (i,p) in pos.iter().enumerate(){ let k=key(*p); let mut b=cell*cell; for dx in -1..=1{for dy in -1..=1{for dz in -1..=1{ if let Some(v)=h.get(&[k[0]+dx,k[1]+dy,k[2]+dz]){ for &j in v { if j!=i && nor[i].dot(nor[j])>-0.3 { b=b.min(pos[j].distance_squared(*p)); } } } }}} let d=(b as f64).sqrt()/hex; mn=mn.min(d); sum+=d;} (mn,sum/n as f64)}
fn main(){
 let a:Vec<String>=std::env::args().collect(); let n:usize=a[2].parse().unwrap(); let reg:f32=a.get(3).map_or(1.0,|s|s.parse().unwrap());
 let m= if a[1]=="plate" { mesh(vec![Vec3::ZERO,Vec3::X,Vec3::X+Vec3::Y,Vec3::Y],vec![[0,1,2],[0,2,3]]) } else { ply(&a[1]) };
 let mut best=f64::MAX; let mut bk=None; for _ in 0..5 { let t=Instant::now(); let s=MeshSurface::new(&m); let t1=t.elapsed().as_secs_f64(); let b=blue_noise(&s,&BakeSettings{stipples:n,regularity:reg,seed:0},|_|()); let e=t.elapsed().as_secs_f64(); if e<best{best=e;} println!("surface {t1:.3} total {e:.3}"); bk=Some(b);} 
 let b=bk.unwrap(); let st=Stock::on_mesh(b,&m); println!("n {} best {best:.3}", st.len());
 let mut k=500; while k<=n { let q=quality(&st.position[..k],&st.facet[..k],st.baked.area); println!("{k} min {:.3} mean {:.3} kappa {:.3} lumps", q.0,q.1, k as f64*(st.baked.radius[k-1] as f64).powi(2)/st.baked.area); k=(k as f64*1.3) as usize; }
 // lumps: equal radius share
 let mut i=0; while i<st.len(){ let mut j=i; while j<st.len() && st.baked.radius[j]==st.baked.radius[i]{j+=1;} if j-i>20 {println!("lump at {} of {}: {:.2}%", i, j-i, 100.0*(j-i) as f64/i.max(1) as f64);} i=j;}
}
