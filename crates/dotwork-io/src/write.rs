//! Mesh writers: what they write, the readers read back unchanged.

use std::io::{self, Write};

use dotwork_mesh::RawMesh;

/// Bytes gathered before they are handed to the writer.
const BUFFER: usize = 64 * 1024;

/// Writes a binary little-endian PLY file.
///
/// Coordinates are `float`; with a non-zero [`RawMesh::origin`] they are `double`, the origin added back. Colours are
/// written if there is one for each position; normals are not.
///
/// # Errors
/// What the writer says.
pub fn write_ply(mesh: &RawMesh, mut w: impl Write) -> io::Result<()> {
    let far = mesh.origin != [0.0; 3];
    let kind = if far { "double" } else { "float" };
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let colored = !mesh.colors.is_empty() && mesh.colors.len() == vertices;
    let channels = if colored {
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
    } else {
        ""
    };
    write!(
        w,
        "ply\nformat binary_little_endian 1.0\ncomment written by dotwork\nelement vertex {vertices}\n\
         property {kind} x\nproperty {kind} y\nproperty {kind} z\n{channels}\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    let mut buffer = Vec::with_capacity(BUFFER + 64);
    for (i, p) in mesh.positions.iter().enumerate() {
        for (k, &v) in p.iter().enumerate() {
            if far {
                buffer.extend_from_slice(&(f64::from(v) + mesh.origin[k]).to_le_bytes());
            } else {
                buffer.extend_from_slice(&v.to_le_bytes());
            }
        }
        if colored {
            buffer.extend_from_slice(&mesh.colors[i]);
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
/// back. Colours follow the coordinates, 0…1, if there is one for each position; normals are not written.
///
/// # Errors
/// What the writer says.
pub fn write_obj(mesh: &RawMesh, mut w: impl Write) -> io::Result<()> {
    let far = mesh.origin != [0.0; 3];
    let mut buffer = Vec::with_capacity(BUFFER + 256);
    buffer.extend_from_slice(b"# written by dotwork\n");
    let mut text = String::new();
    let colored = !mesh.colors.is_empty() && mesh.colors.len() == mesh.positions.len();
    let channels = if mesh.colors.iter().all(|c| c[3] == 255) { 3 } else { 4 };
    for (i, p) in mesh.positions.iter().enumerate() {
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
        if colored {
            for &channel in &mesh.colors[i][..channels] {
                // Four decimals tell 256 levels apart.
                write!(buffer, " {:.4}", f64::from(channel) / 255.0)?;
            }
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
