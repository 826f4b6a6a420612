//! Triangle meshes from STL (text and binary), OBJ and COLLADA files.

use std::io::Cursor;
use std::path::Path;

use super::{LoadOptions, Mesh, RobotFault, dae};

/// Vertices and triangles.
pub(super) type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Reads the mesh that a URDF in `folder` names, scaled to metres.
pub(super) fn load(
    name: &str,
    scale: [f64; 3],
    folder: Option<&Path>,
    options: &LoadOptions,
) -> Result<Mesh, RobotFault> {
    let fault = |problem: String| RobotFault::Mesh { file: name.to_owned(), problem };
    let read: fn(&[u8]) -> Result<Triangles, String> =
        match Path::new(name).extension().and_then(|e| e.to_str()).map(str::to_lowercase).as_deref() {
            Some("stl") => stl,
            Some("obj") => obj,
            Some("dae") => dae::read,
            _ => return Err(fault("neither STL nor OBJ nor DAE".to_owned())),
        };
    if let Some(bad) = scale.iter().find(|s| **s == 0.0 || !s.is_finite()) {
        return Err(fault(format!("scale {bad}: must be finite and not zero")));
    }
    let path = options.find(name, folder).ok_or_else(|| fault("no such file".to_owned()))?;
    let bytes = std::fs::read(&path).map_err(|e| fault(e.to_string()))?;
    let (mut vertices, mut triangles) = read(&bytes).map_err(fault)?;
    if triangles.is_empty() {
        return Err(fault("there is no triangle in it".to_owned()));
    }
    for vertex in &mut vertices {
        for (v, s) in vertex.iter_mut().zip(scale) {
            *v *= s;
            if !v.is_finite() {
                return Err(fault(format!("a coordinate is {v}")));
            }
        }
    }
    // A mirrored mesh would be inside out.
    if scale.iter().product::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(Mesh { file: name.to_owned(), vertices, triangles })
}

/// An STL file, read by `stl_io`, which tells text from binary by the first word alone and wants a name in it.
fn stl(bytes: &[u8]) -> Result<Triangles, String> {
    // Some programs start binary files with "solid" as well: the length decides.
    let count = bytes.get(80..84).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]) as usize);
    if count.is_some_and(|n| bytes.len() == 84 + 50 * n) {
        return solid([&[0; 80], &bytes[80..]].concat());
    }
    let text = bytes.trim_ascii_start();
    if !text.starts_with(b"solid") {
        return Err("neither a binary nor a text STL".to_owned());
    }
    let text = std::str::from_utf8(text).map_err(|_| "neither a binary nor a text STL".to_owned())?;
    // A file may hold several solids, one after the other.
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let mut facets = String::new();
    for line in text.lines() {
        if !line.trim_start().starts_with("solid") {
            facets.push_str(line);
            facets.push('\n');
        }
        if line.trim_start().starts_with("endsolid") {
            let part = solid(format!("solid part\n{}", std::mem::take(&mut facets)).into_bytes())?;
            append(&mut vertices, &mut triangles, part)?;
        }
    }
    if facets.trim().is_empty() {
        Ok((vertices, triangles))
    } else {
        Err("cut short: there is no 'endsolid'".to_owned())
    }
}

fn solid(bytes: Vec<u8>) -> Result<Triangles, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let vertices = mesh.vertices.iter().map(|v| v.0.map(f64::from)).collect();
    let triangles = mesh.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect();
    Ok((vertices, triangles))
}

/// An OBJ file, read by `tobj`; its materials are left alone.
fn obj(bytes: &[u8]) -> Result<Triangles, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, |_| Ok(Default::default()))
        .map_err(|e| e.to_string())?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for model in models {
        let corners = model.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        let faces = model.mesh.indices.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
        append(&mut vertices, &mut triangles, (corners, faces))?;
    }
    Ok((vertices, triangles))
}

/// Adds a part to the vertices and triangles of the parts before it.
pub(super) fn append(
    vertices: &mut Vec<[f64; 3]>,
    triangles: &mut Vec<[u32; 3]>,
    (corners, faces): Triangles,
) -> Result<(), String> {
    let first = u32::try_from(vertices.len() + corners.len()).map_err(|_| "too many vertices".to_owned())?
        - corners.len() as u32;
    let count = corners.len() as u32;
    if faces.iter().flatten().any(|i| *i >= count) {
        return Err("a face names a vertex that is not there".to_owned());
    }
    vertices.extend(corners);
    triangles.extend(faces.into_iter().map(|f| f.map(|i| first + i)));
    Ok(())
}
