//! A user's own URDF with meshes in every form that is read.

use std::fs;
use std::path::Path;

use sealegs_leg::robot::{Geometry, Mesh, Source};

use super::*;

/// A tetrahedron's corners and outward faces.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn text_stl() -> Vec<u8> {
    let mut text = "solid tetrahedron\n".to_owned();
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        for c in face {
            let [x, y, z] = CORNERS[c];
            text += &format!("vertex {x:e} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid tetrahedron\n").into_bytes()
}

fn binary_stl() -> Vec<u8> {
    // A header that starts like a text file, as some programs write it.
    let mut bytes = b"solid binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for c in face {
            CORNERS[c].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj() -> Vec<u8> {
    let mut text = "# tetrahedron\no t\n".to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("v {x} {y} {z}\n");
    }
    text += "vn 0 0 1\nf 1//1 3//1 2//1\nf 1 2 4\nf -4 -1 -2\nf 2/1/1 3/1/1 4/1/1\n";
    text.into_bytes()
}

/// In millimetres, the corners halved and then doubled by the scene's node, one face a polygon of its own.
fn dae() -> Vec<u8> {
    let corners: String = CORNERS.iter().flatten().map(|v| format!("{} ", 500.0 * v)).collect();
    let pair = |i: usize| format!("{i} 0 ");
    let list = |faces: &[[usize; 3]]| faces.iter().flatten().map(|i| pair(*i)).collect::<String>();
    let inputs = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>\
        <input semantic=\"NORMAL\" source=\"#n\" offset=\"1\"/>";
    format!(
        "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\
         <asset><unit meter=\"0.001\" name=\"millimeter\"/><up_axis>Y_UP</up_axis></asset>\
         <library_geometries><geometry id=\"g\"><mesh>\
         <source id=\"p\"><float_array id=\"a\" count=\"12\">{corners}</float_array><technique_common>\
         <accessor source=\"#a\" count=\"4\" stride=\"3\"/></technique_common></source>\
         <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\
         <triangles count=\"3\">{inputs}<p>{}</p></triangles>\
         <polylist count=\"1\">{inputs}<vcount>3</vcount><p>{}</p></polylist>\
         </mesh></geometry></library_geometries>\
         <library_visual_scenes><visual_scene id=\"s\"><node><translate>10 20 30</translate>\
         <rotate>0 0 1 90</rotate><node><scale>2 2 2</scale><instance_geometry url=\"#g\"/></node></node>\
         </visual_scene></library_visual_scenes>\
         <scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>",
        list(&FACES[..3]),
        list(&FACES[3..]),
    )
    .into_bytes()
}

/// The same with one part of it replaced.
fn dae_with(part: &str, other: &str) -> Vec<u8> {
    let text = String::from_utf8(dae()).expect("text");
    assert!(text.contains(part), "{part}");
    text.replacen(part, other, 1).into_bytes()
}

/// Volume enclosed by the triangles by the divergence theorem: its sign tells the winding.
fn volume(mesh: &Mesh) -> f64 {
    let corner = |i: u32| nalgebra::Vector3::from(mesh.vertices[i as usize]);
    mesh.triangles.iter().map(|t| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2]))) / 6.0).sum()
}

fn with_mesh(folder: &Path, filename: &str, scale: &str) -> Result<Robot, LegError> {
    let mesh = format!(
        "<collision><geometry><mesh filename=\"{filename}\" scale=\"{scale}\"/></geometry></collision></link>"
    );
    let urdf = folder.join("leg.urdf");
    fs::write(&urdf, leg().replacen("</link>", &mesh, 1)).expect("writable");
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    Robot::load_with(urdf.to_str().expect("a plain path"), None, &strict)
}

fn mesh_of(robot: &Robot) -> &Mesh {
    match &robot.links[0].collisions[0].geometry {
        Geometry::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

#[test]
fn analytic_volume_in_every_form() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in [("t.stl", text_stl()), ("b.STL", binary_stl()), ("o.obj", obj())] {
        fs::write(folder.path().join(name), bytes).expect("writable");
        let robot = with_mesh(folder.path(), name, "1 1 1").expect("readable");
        let mesh = mesh_of(&robot);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4), "{name}");
        assert!((volume(mesh) - 1.0 / 6.0).abs() < 1e-15, "{name}");
        // In millimetres, and mirrored: the outside stays outside.
        let robot = with_mesh(folder.path(), name, "0.001 -0.001 0.001").expect("readable");
        assert!((volume(mesh_of(&robot)) * 6e9 - 1.0).abs() < 1e-12, "{name}");
    }
}

#[test]
fn analytic_collada_at_the_place_that_its_scene_gives_it() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("d.dae"), dae()).expect("writable");
    let robot = with_mesh(folder.path(), "d.dae", "1 1 1").expect("readable");
    let mesh = mesh_of(&robot);
    assert_eq!(mesh.triangles.len(), 4);
    assert!((volume(mesh) - 1.0 / 6.0).abs() < 1e-12, "{}", volume(mesh));
    // A quarter turn takes x to y; the node's offset is in millimetres as well.
    let moved = |c: [f32; 3]| [0.01 - f64::from(c[1]), 0.02 + f64::from(c[0]), 0.03 + f64::from(c[2])];
    for corner in CORNERS.map(moved) {
        let near = |v: &[f64; 3]| v.iter().zip(&corner).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(mesh.vertices.iter().any(near), "{corner:?} in {:?}", mesh.vertices);
    }
}

#[test]
fn several_solids_in_one_text_are_one_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("two.stl"), [text_stl(), text_stl()].concat()).expect("writable");
    let robot = with_mesh(folder.path(), "two.stl", "1 1 1").expect("readable");
    assert_eq!(mesh_of(&robot).triangles.len(), 8);
}

#[test]
fn packages_are_found_where_options_say() {
    let folder = tempfile::tempdir().expect("a folder");
    let (urdfs, share) = (folder.path().join("urdf"), folder.path().join("install/share"));
    let stack = folder.path().join("src/stack");
    fs::create_dir_all(&urdfs).expect("writable");
    for package in [share.join("one"), stack.join("two")] {
        fs::create_dir_all(package.join("meshes")).expect("writable");
        fs::write(package.join("meshes/t.stl"), text_stl()).expect("writable");
    }
    let urdf = urdfs.join("leg.urdf");
    let load = |package: &str, package_folders: Vec<std::path::PathBuf>| {
        let mesh = format!(
            "<visual><geometry><mesh filename=\"package://{package}/meshes/t.stl\"/></geometry></visual></link>"
        );
        fs::write(&urdf, leg().replacen("</link>", &mesh, 1)).expect("writable");
        let options = LoadOptions { strict: true, package_folders };
        Robot::load_with(urdf.to_str().expect("plain"), None, &options)
    };
    assert!(load("one", Vec::new()).is_err());
    assert!(load("one", vec![share.clone()]).is_ok(), "in a folder of packages");
    assert!(load("one", vec![share.join("one")]).is_ok(), "the package itself");
    assert!(load("two", vec![share, folder.path().join("src")]).is_ok(), "in a stack");
}

#[test]
fn packages_are_found_around_the_urdf() {
    let folder = tempfile::tempdir().expect("a folder");
    let urdfs = folder.path().join("my_robot/urdf");
    let meshes = folder.path().join("my_robot/meshes");
    fs::create_dir_all(&urdfs).expect("writable");
    fs::create_dir_all(&meshes).expect("writable");
    fs::write(meshes.join("t.stl"), text_stl()).expect("writable");
    let robot = with_mesh(&urdfs, "package://my_robot/meshes/t.stl", "1 1 1").expect("found");
    assert_eq!(mesh_of(&robot).file, "package://my_robot/meshes/t.stl");
    assert!(with_mesh(&urdfs, "../meshes/t.stl", "1 1 1").is_ok());
    let full = format!("file://{}", meshes.join("t.stl").display());
    assert!(with_mesh(&urdfs, &full, "1 1 1").is_ok());
}

#[test]
fn meshes_that_cannot_be_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let cut = text_stl()[..120].to_vec();
    for (name, bytes, problem) in [
        ("a.stl", b"nothing".to_vec(), "neither a binary nor a text STL"),
        ("b.stl", cut, "cut short"),
        ("c.stl", b"solid empty\nendsolid".to_vec(), "no triangle"),
        ("d.stl", b"solid\nvertex 1 2\nendsolid".to_vec(), "invalid facet header"),
        ("e.stl", binary_stl()[..150].to_vec(), "neither a binary nor a text STL"),
        (
            "f.stl",
            String::from_utf8(text_stl()).expect("text").replace("vertex 1e0", "vertex nan").into(),
            "NaN",
        ),
        ("g.obj", b"v 0 0 0\nf 1 2 3\n".to_vec(), "out of bounds"),
        ("h.obj", b"v 0 0\n".to_vec(), "position parse error"),
        ("i.obj", b"v 0 0 0\nv 1 0 0\nf 1 2\n".to_vec(), "no triangle"),
        ("k.dae", b"<mesh/>".to_vec(), "<mesh>, not <COLLADA>"),
        ("l.dae", dae_with("<vcount>3</vcount>", "<vcount>4</vcount>"), "beyond its <p>"),
        ("m.dae", dae_with("<p>0 0 2 0", "<p>0 0 9 0"), "a vertex that is not there"),
        ("n.dae", dae_with("<p>0 0 2 0", "<p>0 0 x 0"), "'x' in <p> is no number"),
        ("o.dae", dae_with("#g\"/></node>", "#g\"/><instance_node url=\"#s\"/></node>"), "have no end"),
        ("p.dae", dae_with("<scale>2 2 2</scale>", "<scale>2</scale>"), "<scale> with 1 numbers"),
    ] {
        fs::write(folder.path().join(name), bytes).expect("writable");
        let (line, element, fault) = taken_apart(with_mesh(folder.path(), name, "1 1 1").expect_err(name));
        assert_eq!((line, element.as_str()), (Some(2), "link 'base' collision geometry"));
        let said = fault.to_string();
        assert!(said.contains(problem), "{name}: {said}");
    }
    fs::write(folder.path().join("t.stl"), text_stl()).expect("writable");
    let error = with_mesh(folder.path(), "t.stl", "1 0 1").expect_err("no scale").to_string();
    assert!(error.contains("scale 0"), "{error}");
}

#[test]
fn a_users_files_beside_each_other() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("t.stl"), text_stl()).expect("writable");
    let bare = with_mesh(folder.path(), "t.stl", "1 1 1").expect("readable");
    assert!(bare.actuators.is_empty());
    let placement = "[[actuator]]\nname = \"k\"\nkind = \"linear\"\nactuator = \"my.toml\"\nlink_1 = \"thigh\"\n\
        point_1_m = [-0.05, 0, -0.25]\nlink_2 = \"shank\"\npoint_2_m = [-0.06, 0, 0]\n";
    let beside = folder.path().join("leg.actuators.toml");
    fs::write(&beside, placement).expect("writable");
    let own = sealegs_actuator::ActuatorSpec::preset_text("thor-linear").expect("a preset");
    fs::write(folder.path().join("my.toml"), own).expect("writable");
    let robot = with_mesh(folder.path(), "t.stl", "1 1 1").expect("readable");
    assert_eq!(robot.actuators.len(), 1);
    let urdf = folder.path().join("leg.urdf");
    assert_eq!(robot.source, Source::Files { urdf: urdf.clone(), placement: Some(beside) });
    // Another placement, named outright; seen from its own folder the actuator's file is not there.
    let elsewhere = tempfile::tempdir().expect("a folder");
    let other = elsewhere.path().join("other.toml");
    fs::write(&other, placement.replace("my.toml", "thor-linear")).expect("writable");
    let robot = Robot::load(urdf.to_str().expect("plain"), Some(&other)).expect("readable");
    assert_eq!(robot.actuators[0].actuator, "thor-linear");
    fs::write(&other, placement).expect("writable");
    assert!(Robot::load(urdf.to_str().expect("plain"), Some(&other)).is_err());
}
