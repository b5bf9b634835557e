//! Mesh writers: what they write, the readers read back unchanged.

use std::io::{self, Write};

use dotwork_mesh::RawMesh;

/// Bytes gathered before they are handed to the writer.
const BUFFER: usize = 64 * 1024;

/// Writes a binary little-endian PLY file.
///
/// Coordinates are `float`; with a non-zero [`RawMesh::origin`] they are `double`, the origin added back.
///
/// # Errors
/// What the writer says.
pub fn write_ply(mesh: &RawMesh, mut w: impl Write) -> io::Result<()> {
    let far = mesh.origin != [0.0; 3];
    let kind = if far { "double" } else { "float" };
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    write!(
        w,
        "ply\nformat binary_little_endian 1.0\ncomment written by dotwork\nelement vertex {vertices}\n\
         property {kind} x\nproperty {kind} y\nproperty {kind} z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    let mut buffer = Vec::with_capacity(BUFFER + 64);
    for p in &mesh.positions {
        for (k, &v) in p.iter().enumerate() {
            if far {
                buffer.extend_from_slice(&(f64::from(v) + mesh.origin[k]).to_le_bytes());
            } else {
                buffer.extend_from_slice(&v.to_le_bytes());
            }
        }
        drain(&mut buffer, &mut w, BUFFER)?;
    }
    for t in &mesh.triangles {
        buffer.push(3);
        for corner in t {
            buffer.extend_from_slice(&corner.to_le_bytes());
        }
        drain(&mut buffer, &mut w, BUFFER)?;
    }
    drain(&mut buffer, &mut w, 0)?;
    w.flush()
}

/// Writes an OBJ file with the shortest numbers that read back unchanged; a non-zero [`RawMesh::origin`] is added
/// back.
///
/// # Errors
/// What the writer says.
pub fn write_obj(mesh: &RawMesh, mut w: impl Write) -> io::Result<()> {
    let far = mesh.origin != [0.0; 3];
    let mut buffer = Vec::with_capacity(BUFFER + 256);
    buffer.extend_from_slice(b"# written by dotwork\n");
    let mut text = String::new();
    for p in &mesh.positions {
        buffer.push(b'v');
        for (k, &v) in p.iter().enumerate() {
            use std::fmt::Write as _;
            text.clear();
            let wide = f64::from(v) + mesh.origin[k];
            let short = !far && {
                let _ = write!(text, "{v}");
                // Readers round twice, to f64 and to f32; in rare ties the shortest f32 text does not survive that.
                text.parse::<f64>().is_ok_and(|d| d as f32 == v)
            };
            if !short {
                text.clear();
                let _ = write!(text, "{wide}");
            }
            buffer.push(b' ');
            buffer.extend_from_slice(text.as_bytes());
        }
        buffer.push(b'\n');
        drain(&mut buffer, &mut w, BUFFER)?;
    }
    for &[a, b, c] in &mesh.triangles {
        let [a, b, c] = [a, b, c].map(|i| u64::from(i) + 1);
        writeln!(buffer, "f {a} {b} {c}")?;
        drain(&mut buffer, &mut w, BUFFER)?;
    }
    drain(&mut buffer, &mut w, 0)?;
    w.flush()
}

fn drain(buffer: &mut Vec<u8>, w: &mut impl Write, keep_under: usize) -> io::Result<()> {
    if buffer.len() >= keep_under {
        w.write_all(buffer)?;
        buffer.clear();
    }
    Ok(())
}
