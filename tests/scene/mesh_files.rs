//! Mesh files: all formats give the same boundary, and invalid meshes are refused with the file and the remedy.

use glam::Vec3;
use overfall::sampling::sample;
use overfall::scene::Scene;

use crate::mesh_support::{Files, Surface};

fn tank() -> Surface {
    Surface::block(Vec3::ZERO, Vec3::new(0.5, 0.75, 0.5))
}

/// A scene of fluid in a mesh.
pub(super) fn scene(file: &str, rest: &str) -> Result<Scene, String> {
    let text = format!(
        "(name: \"mesh\", spacing: 0.05,
          boundaries: [Mesh((file: {file:?}, {rest}))],
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0.5)))])"
    );
    Scene::parse(&text, "mesh.ron", &[]).map_err(|error| error.to_string())
}

#[test]
fn obj_and_stl_in_text_and_binary_give_the_same_boundary() {
    let files = Files::new();
    let tank = tank();
    let written = [
        files.put("tank.obj", tank.obj()),
        // Indices from the end, missing texture and normal indices, objects, materials.
        files.put(
            "other.OBJ",
            tank.obj()
                .replace("f 1 5 7 3", "o part\nusemtl red\nf -8/1/1 -4//9 -2/7 -6"),
        ),
        files.put("text.stl", tank.stl_text()),
        files.put("binary.stl", tank.stl_binary(b"made by hand")),
        files.put("solid.stl", tank.stl_binary(b"solid made by hand\n")),
    ];
    let samples: Vec<_> = written
        .iter()
        .map(|file| sample(&scene(file, "side: Inside").expect("a scene")).expect("samples"))
        .collect();
    assert!(samples[0].len() > 600);
    for other in &samples[1..] {
        assert_eq!(other.len(), samples[0].len());
        for sample in other {
            let same = |one: &&_| *one == sample;
            assert!(samples[0].iter().any(|one| same(&one)), "{sample:?}");
        }
    }
}

#[test]
fn a_mesh_is_scaled_turned_and_moved() {
    let files = Files::new();
    let file = files.put("tank.obj", tank().obj());
    // Scaled by one half, with its height along +z, then along +x: (x, y, z) → (x, −z, y) → … in metres about (1, 2,
    // 3).
    let place = "side: Inside, scale: 0.5, rotation: (90, 0, 90), translation: (1, 2, 3)";
    let text = format!(
        "(name: \"mesh\", spacing: 0.025, boundaries: [Mesh((file: {file:?}, {place}))],
          bodies: [(shape: Box(min: (1, 2, 3), max: (1.25, 2.25, 3.25)))])"
    );
    let scene = Scene::parse(&text, "mesh.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    let samples = sample(&scene).expect("samples");
    let low = samples
        .iter()
        .fold(Vec3::INFINITY, |low, s| low.min(s.position));
    let high = samples
        .iter()
        .fold(Vec3::NEG_INFINITY, |high, s| high.max(s.position));
    // The layer is 0.6 spacings outside: x' = z/2, y' = x/2, z' = y/2.
    let depth = overfall::sampling::layer_depth(&scene);
    assert!(
        low.abs_diff_eq(Vec3::new(1.0, 2.0, 3.0) - depth, 2e-4),
        "{low}"
    );
    assert!(
        high.abs_diff_eq(Vec3::new(1.25, 2.25, 3.375) + depth, 2e-4),
        "{high}"
    );
}

#[test]
fn a_file_is_looked_for_beside_the_scene() {
    let files = Files::new();
    let mesh = files.put("tank.obj", tank().obj());
    let text =
        "(name: \"mesh\", spacing: 0.05, boundaries: [Mesh(file: \"tank.obj\", side: Inside)],
        bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0.5)))])";
    let path = files.put("mesh.ron", text);
    let mut scene = Scene::load(path.as_ref(), &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.files_mut().collect::<Vec<_>>(), [&mesh]);
    let change = "boundaries.0.scale=2".parse().expect("an override");
    let error = Scene::load(path.as_ref(), &[change]);
    assert!(error.is_ok(), "{error:?}");
}

/// The mesh with one side of its solid missing.
fn without_a_side(obj: &str) -> String {
    let open = obj.replace("f 3 7 8 4\n", "");
    assert_ne!(open, obj);
    open
}

/// Names and contents of invalid files, and parts of their messages.
fn invalid_files() -> Vec<(&'static str, String, &'static [&'static str])> {
    let tank = tank();
    let obj = tank.obj();
    let open = without_a_side(&obj);
    let twisted = obj.replace("f 3 7 8 4", "f 4 8 7 3");
    // A fin: a third triangle at one edge.
    let fin = format!("{obj}v 0 0 9\nf 1 5 9\n");
    vec![
        (
            "missing.obj",
            String::new(),
            &["cannot read the mesh", "missing.obj"],
        ),
        (
            "tank.ply",
            obj.clone(),
            &["ends neither in .obj nor in .stl"],
        ),
        (
            "empty.obj",
            "# nothing\n".to_owned(),
            &["it has no triangle"],
        ),
        (
            "open.obj",
            open,
            &["not closed", "4 of its edges", "side: Front"],
        ),
        (
            "twisted.obj",
            twisted,
            &["wound opposite ways", "recalculate the normals"],
        ),
        ("fin.obj", fin, &["3 triangles meet at one edge"]),
        (
            "range.obj",
            obj.replace("f 3 7 8 4", "f 3 7 99 4"),
            &["names a vertex that the file does not have"],
        ),
        (
            "zero.obj",
            obj.replace("f 3 7 8 4", "f 0 7 8 4"),
            &["names a vertex that the file does not have"],
        ),
        (
            "word.obj",
            obj.replace("f 3 7 8 4", "f 3 7 x 4"),
            &["whole numbers"],
        ),
        (
            "nan.obj",
            obj.replacen("v 0 0 0", "v nan 0 0", 1),
            &["not finite"],
        ),
        (
            "short.obj",
            obj.replacen("v 0 0 0", "v 0 0", 1),
            &["three numbers"],
        ),
        (
            "sliver.obj",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 3 2\n".to_owned(),
            &["triangles has an area"],
        ),
        (
            "kilometres.obj",
            Surface::block(Vec3::ZERO, Vec3::splat(3e-4)).obj(),
            &["encloses nothing", "3.0e-4 m large", "set `scale`"],
        ),
        ("noise.stl", "not a mesh".to_owned(), &["no STL file"]),
        (
            "text.stl",
            "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n".to_owned(),
            &["line 4", "three numbers"],
        ),
    ]
}

#[test]
fn files_that_are_no_boundary_are_refused_with_what_would_be_right() {
    let files = Files::new();
    for (name, contents, words) in invalid_files() {
        let file = files.put(name, contents);
        if name == "missing.obj" {
            std::fs::remove_file(&file).expect("removed");
        }
        let error = scene(&file, "side: Inside").expect_err(name);
        assert!(
            error.contains(name) && error.starts_with("mesh.ron:2:"),
            "{error}"
        );
        for word in words {
            assert!(error.contains(word), "{error}");
        }
    }
    let file = files.put("cut.stl", &tank().stl_binary(b"")[..200]);
    let error = scene(&file, "side: Inside").expect_err("cut short");
    assert!(error.contains("cut short"), "{error}");
}

#[test]
fn meshes_that_overlap_the_fluid_are_refused() {
    let files = Files::new();
    let obj = tank().obj();
    // An open mesh may be a sheet.
    let file = files.put("open.obj", without_a_side(&obj));
    let error = scene(&file, "side: Both").expect_err("water in the sheet");
    assert!(
        error.contains("overlaps the mesh `boundaries.0`"),
        "{error}"
    );
    let file = files.put("tank.obj", obj);
    let error = scene(&file, "side: Outside").expect_err("water in the solid");
    assert!(
        error.contains("overlaps the mesh `boundaries.0`"),
        "{error}"
    );
    let error = scene(&file, "side: Inside, scale: 0").expect_err("no size");
    assert!(error.contains("must be above 0"), "{error}");
    let error = scene(&file, "side: Inside, scale: 0.9").expect_err("too small");
    assert!(
        error.contains("overlaps the mesh `boundaries.0`"),
        "{error}"
    );
}
