//! Triangle meshes from STL (text and binary) and OBJ files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{Mesh, RobotFault};

/// Reads the mesh that a URDF names, scaled to metres. `None` if the file is of a kind that is not read.
///
/// A `package://name/path` is looked for as `path` and `name/path` in the URDF's folder and above it, so that
/// no ROS needs to be installed.
pub(super) fn load(name: &str, scale: [f64; 3], folder: Option<&Path>) -> Result<Option<Mesh>, RobotFault> {
    let fault = |problem: String| RobotFault::Mesh { file: name.to_owned(), problem };
    let read: fn(&[u8]) -> Result<Triangles, String> =
        match Path::new(name).extension().and_then(|e| e.to_str()).map(str::to_lowercase).as_deref() {
            Some("stl") => stl,
            Some("obj") => obj,
            _ => return Ok(None),
        };
    if let Some(bad) = scale.iter().find(|s| **s == 0.0 || !s.is_finite()) {
        return Err(fault(format!("scale {bad}: must be finite and not zero")));
    }
    let path = resolve(name, folder).ok_or_else(|| fault("no such file".to_owned()))?;
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
    Ok(Some(Mesh { file: name.to_owned(), vertices, triangles }))
}

fn resolve(name: &str, folder: Option<&Path>) -> Option<PathBuf> {
    let folder = folder.unwrap_or(Path::new("."));
    let Some(inside) = name.strip_prefix("package://") else {
        let path = folder.join(name.strip_prefix("file://").unwrap_or(name));
        return path.is_file().then_some(path);
    };
    let below = inside.split_once('/').map_or(inside, |(_, path)| path);
    let absolute = std::path::absolute(folder).ok()?;
    absolute.ancestors().flat_map(|a| [a.join(below), a.join(inside)]).find(|p| p.is_file())
}

/// Vertices and triangles.
type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn stl(bytes: &[u8]) -> Result<Triangles, String> {
    // Some programs start binary files with "solid" as well: the length decides.
    let count = bytes.get(80..84).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]) as usize);
    let corners: Vec<[f64; 3]> = if count.is_some_and(|n| bytes.len() == 84 + 50 * n) {
        let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let corner = |b: &[u8]| [number(&b[..4]), number(&b[4..8]), number(&b[8..12])];
        bytes[84..].chunks_exact(50).flat_map(|t| t[12..48].chunks_exact(12).map(corner)).collect()
    } else if bytes.trim_ascii_start().starts_with(b"solid") {
        let text = std::str::from_utf8(bytes).map_err(|_| "neither a binary nor a text STL".to_owned())?;
        if !text.lines().any(|l| l.trim_start().starts_with("endsolid")) {
            return Err("cut short: there is no 'endsolid'".to_owned());
        }
        let mut corners = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let mut words = line.split_whitespace();
            if words.next() == Some("vertex") {
                corners.push(point(words).ok_or_else(|| format!("line {}: not a vertex", number + 1))?);
            }
        }
        corners
    } else {
        return Err("neither a binary nor a text STL".to_owned());
    };
    if !corners.len().is_multiple_of(3) {
        return Err(format!("{} corners do not make triangles", corners.len()));
    }
    Ok(joined(&corners))
}

/// Joins equal corners, which STL repeats for each triangle.
fn joined(corners: &[[f64; 3]]) -> Triangles {
    let mut known = BTreeMap::new();
    let mut vertices = Vec::new();
    let indices: Vec<u32> = corners
        .iter()
        .map(|c| {
            *known.entry(c.map(f64::to_bits)).or_insert_with(|| {
                vertices.push(*c);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    (vertices, indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect())
}

fn obj(bytes: &[u8]) -> Result<Triangles, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "not a text file".to_owned())?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let line_is = |what: &str| format!("line {}: {what}", number + 1);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => vertices.push(point(words).ok_or_else(|| line_is("not a vertex"))?),
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|w| corner(w, vertices.len()).ok_or_else(|| line_is("no such vertex")))
                    .collect::<Result<_, _>>()?;
                if corners.len() < 3 {
                    return Err(line_is("a face needs three corners"));
                }
                triangles.extend(corners[1..].windows(2).map(|c| [corners[0], c[0], c[1]]));
            }
            _ => {}
        }
    }
    Ok((vertices, triangles))
}

/// The index of a corner `7`, `7/1/3` or `-1` (counted back from the last vertex).
fn corner(word: &str, vertices: usize) -> Option<u32> {
    let index: i64 = word.split('/').next()?.parse().ok()?;
    let index = if index < 0 { vertices as i64 + index } else { index - 1 };
    (0..vertices as i64).contains(&index).then_some(index as u32)
}

fn point<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<[f64; 3]> {
    let mut next = || words.next()?.parse().ok();
    Some([next()?, next()?, next()?])
}
