//! Scenes that are put together from fragments.

use std::fs;
use std::path::Path;

use overfall::scene::Scene;
use tempfile::TempDir;

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("folders");
        fs::write(path, text).expect("a file");
    }
    folder
}

fn load(folder: &TempDir) -> Result<Scene, String> {
    Scene::load(&folder.path().join("scene.ron"), &[]).map_err(|error| error.to_string())
}

const WATER: &str =
    "// Water at 20 °C.\n(rest_density: 998, viscosity: Laminar(kinematic_viscosity: 1e-6))\n";
const WALLS: &str = "[\n    Tank(min: (0, 0, 0), max: (2, 2, 1)),\n    \
    Box(min: (1.5, 0, 0), max: (2, 1, 1), name: \"step\"),\n]";

#[test]
fn fragments_say_what_the_scene_would() {
    let whole = folder(&[(
        "scene.ron",
        r#"(
            name: "t", spacing: 0.1,
            fluid: (rest_density: 998, viscosity: Laminar(kinematic_viscosity: 1e-6)),
            bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
            boundaries: [
                Tank(min: (0, 0, 0), max: (2, 2, 1)),
                Box(min: (1.5, 0, 0), max: (2, 1, 1), name: "step"),
                Sphere(center: (1.3, 1.5, 0.5), radius: 0.2),
            ],
        )"#,
    )]);
    let expected = load(&whole).expect("a scene");
    let sphere = "Sphere(center: (1.3, 1.5, 0.5), radius: 0.2)";
    let head = "name: \"t\", spacing: 0.1,";
    let bodies = "bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))]";
    let files: &[(&str, &str)] = &[
        ("parts/water.ron", WATER),
        ("parts/walls.ron", WALLS),
        ("parts/empty.ron", "[]"),
        ("parts/sphere.ron", sphere),
        (
            "parts/base.ron",
            &format!(
                "(fluid: include(\"water.ron\"), boundaries: include(\"walls.ron\"), {bodies})"
            ),
        ),
        ("parts/all.ron", &format!("({head} include: \"base.ron\")")),
    ];
    for text in [
        format!(
            "({head} fluid: include(\"parts/water.ron\"), {bodies},
            boundaries: [include(\"parts/walls.ron\"), include(\"parts/empty.ron\"), {sphere}])"
        ),
        format!(
            "({head} fluid: include(\"parts/water.ron\"), {bodies},
            boundaries: [include(\"parts/empty.ron\"), include(\"parts/walls.ron\"), include(\"parts/sphere.ron\"),],)"
        ),
        format!("({head} include: \"parts/base.ron\", boundaries: [{sphere}])"),
        format!("({head} boundaries: [{sphere}], include: [\"parts/base.ron\"],)"),
        format!("(include: [\"parts/all.ron\"], boundaries: [{sphere}])"),
        "// A comment.\n(include: \"parts/all.ron\", /* another */ \
            boundaries: [include(\"parts/sphere.ron\")])\n".to_owned(),
        // The fields of a struct within.
        format!("({head} fluid: (include: \"parts/water.ron\"), {bodies}, \
            boundaries: [include(\"parts/walls.ron\"), {sphere}])"),
    ] {
        let folder = folder(files);
        fs::write(folder.path().join("scene.ron"), &text).expect("a file");
        let scene = load(&folder).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(scene, expected, "{text}");
        // What is saved needs no fragments.
        let saved = scene.to_ron().expect("RON");
        assert!(!saved.contains("include"), "{saved}");
        let used = Scene::fragments(&folder.path().join("scene.ron"));
        assert!(!used.is_empty() && used.iter().all(|file| file.is_file()), "{used:?}");
    }
}

/// File, what is replaced in it by what, and place and message of the error.
const MISTAKES: &[(&str, &str, &str, &str, &str)] = &[
    (
        "parts/water.ron",
        "rest_density",
        "density",
        "parts/water.ron:2:2",
        "unknown field `density`",
    ),
    (
        "parts/water.ron",
        "998",
        "-1",
        "parts/water.ron:2:16",
        "must be above 0",
    ),
    ("parts/water.ron", "998", "1,5", "parts/water.ron:2:", ""),
    (
        "parts/water.ron",
        "998,",
        "998",
        "parts/water.ron:2:",
        "comma",
    ),
    ("parts/water.ron", "))", ")", "parts/water.ron:", ""),
    (
        "parts/walls.ron",
        "Box(",
        "Bix(",
        "parts/walls.ron:3:5",
        "did you mean `Box`?",
    ),
    (
        "parts/walls.ron",
        "max: (2, 1, 1)",
        "max: (1, 1, 1)",
        "parts/walls.ron:3:32",
        "`max` must be above `min`",
    ),
    (
        "scene.ron",
        "duration: 1",
        "duration: -1",
        "scene.ron:7:15",
        "must be above 0",
    ),
    (
        "scene.ron",
        "spacing",
        "spaceing",
        "scene.ron:3:5",
        "did you mean `spacing`?",
    ),
    (
        "scene.ron",
        "parts/water",
        "parts/wine",
        "scene.ron:4:20",
        "there is no file",
    ),
    (
        "scene.ron",
        "include(\"parts/water.ron\")",
        "include(water)",
        "scene.ron:4:20",
        "in double quotes",
    ),
    (
        "scene.ron",
        "parts/water.ron",
        "parts",
        "scene.ron:4:20",
        "a folder",
    ),
];

/// Errors point into the file that they are in, whatever finds them: RON's grammar, unknown fields, checks.
#[test]
fn errors_are_at_their_place_in_the_fragment() {
    let scene = r#"(
    name: "t",
    spacing: 0.1,
    fluid: include("parts/water.ron"),
    bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
    boundaries: [include("parts/walls.ron")],
    duration: 1,
)"#;
    let good = folder(&[
        ("scene.ron", scene),
        ("parts/water.ron", WATER),
        ("parts/walls.ron", WALLS),
    ]);
    load(&good).unwrap_or_else(|error| panic!("{error}"));
    for &(file, from, to, place, message) in MISTAKES {
        let folder = folder(&[
            ("scene.ron", scene),
            ("parts/water.ron", WATER),
            ("parts/walls.ron", WALLS),
        ]);
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).expect("a text");
        assert!(text.contains(from), "{file}: {from}");
        fs::write(&path, text.replacen(from, to, 1)).expect("a file");
        let error = load(&folder).expect_err(to);
        let expected = format!("{}/{place}", folder.path().display());
        assert!(
            error.starts_with(&expected) && error.contains(message),
            "{to}: expected {expected}, got {error}"
        );
    }
}

#[test]
fn circles_and_fields_that_are_given_twice_are_refused() {
    let body = "bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))]";
    for (files, message) in [
        (
            vec![
                (
                    "scene.ron",
                    format!("(name: \"t\", spacing: 0.1, {body}, include: \"a.ron\")"),
                ),
                ("a.ron", "(include: \"b.ron\")".to_owned()),
                ("b.ron", "(include: \"./a.ron\")".to_owned()),
            ],
            "a file includes itself: ",
        ),
        (
            vec![("scene.ron", "(include: \"scene.ron\")".to_owned())],
            "a file includes itself: ",
        ),
        (
            vec![
                (
                    "scene.ron",
                    format!("(name: \"t\", spacing: 0.1, {body}, include: \"a.ron\")"),
                ),
                ("a.ron", "(duration: 1, spacing: 0.2)".to_owned()),
            ],
            "scene.ron:1:13: the field `spacing` is given here, and in ",
        ),
        (
            vec![
                (
                    "scene.ron",
                    format!("(name: \"t\", spacing: 0.1, {body}, include: \"a.ron\")"),
                ),
                ("a.ron", "[1, 2]".to_owned()),
            ],
            "scene.ron:1:92: a file of `include: …` holds fields",
        ),
        (
            vec![
                (
                    "scene.ron",
                    format!(
                        "(name: \"t\", spacing: 0.1, {body}, include: \"a.ron\", include: \"a.ron\")"
                    ),
                ),
                ("a.ron", "(duration: 1)".to_owned()),
            ],
            "`include` is given twice; write a list",
        ),
        (
            vec![("scene.ron", "(include: 3)".to_owned())],
            "scene.ron:1:11: expected the path of a file in double quotes",
        ),
    ] {
        let files: Vec<_> = files
            .iter()
            .map(|(name, text)| (*name, text.as_str()))
            .collect();
        let error = load(&folder(&files)).expect_err(message);
        assert!(error.contains(message), "{error}");
    }
}

/// Fragments that double at every level would be longer than any memory.
#[test]
fn fragments_that_grow_without_end_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for level in 0..40 {
        let next = level + 1;
        let text = format!("[include(\"{next}.ron\"), include(\"{next}.ron\")]");
        fs::write(folder.path().join(format!("{level}.ron")), text).expect("a file");
    }
    fs::write(folder.path().join("40.ron"), "[1]").expect("a file");
    fs::write(
        folder.path().join("scene.ron"),
        "(bodies: include(\"0.ron\"))",
    )
    .expect("a file");
    let error = load(&folder).expect_err("too many");
    assert!(error.contains("at most 1000 fragments"), "{error}");
}

/// Meshes, tables and orders of a fragment are relative to the fragment.
#[test]
fn files_of_a_fragment_are_beside_it() {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/block.obj");
    let mesh = fs::read_to_string(mesh).expect("a mesh");
    let folder = folder(&[
        ("parts/deep/block.obj", &mesh),
        ("parts/piston.csv", "t,x\n0,0\n1,0.1\n"),
        (
            "parts/deep/mesh.ron",
            "Mesh(file: \"block.obj\", scale: 0.1, translation: (5, 5, 5))",
        ),
        (
            "parts/walls.ron",
            "[include(\"deep/mesh.ron\"), Box(min: (2, 0, 0), max: (3, 1, 1),
                motion: Table(file: \"piston.csv\", direction: (1, 0, 0)))]",
        ),
        (
            "scene.ron",
            "(name: \"t\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
            boundaries: include(\"parts/walls.ron\"))",
        ),
    ]);
    let mut scene = load(&folder).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        scene
            .files_mut()
            .filter(|file| Path::new(file).is_file())
            .count(),
        2
    );
}
