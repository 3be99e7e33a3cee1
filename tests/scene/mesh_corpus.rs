//! The corpus of mesh files, `tests/meshes`: one solid in many notations, shells, and damaged files.

use glam::{DVec3, EulerRot, Quat, Vec3};
use overfall::mesh::Mesh;
use overfall::sampling::sample;
use proptest::prelude::*;

use super::mesh_files::scene;
use crate::mesh_support::{Files, Surface};

/// The corpus: one solid in many notations, and files that are not solids.
const CORPUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes");

fn corpus() -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = std::fs::read_dir(CORPUS)
        .expect("the corpus")
        .map(|entry| {
            let entry = entry.expect("a file");
            let bytes = std::fs::read(entry.path()).expect("a file");
            (entry.file_name().into_string().expect("a name"), bytes)
        })
        .collect();
    files.sort();
    files
}

/// Reads a file of the corpus, or one that a test has written, as a closed mesh.
fn load(file: &str, rest: &str, spacing: f32) -> Result<Mesh, String> {
    let path = std::path::Path::new(CORPUS)
        .join(file)
        .display()
        .to_string();
    let boundary = ron::from_str(&format!("(file: {path:?}, {rest})")).expect("a boundary");
    Mesh::load(&boundary, spacing).map_err(|error| error.to_string())
}

/// All notations of the same surface are read as that surface: the rules of the formats (continued lines, comments,
/// byte order marks, solids without names), and the habits of programs (NaN for normals, seams in the last digits, map
/// coordinates).
#[test]
fn one_block_written_in_many_ways_is_read_as_one_block() {
    let mut read = 0;
    for (file, _) in corpus() {
        if !file.starts_with("block") {
            continue;
        }
        let place = match file.as_str() {
            "block_map.obj" => "translation: (-4e6, 1e6, -8e6)",
            "block_map.stl" => "translation: (-4e6, -4e6, -4e6)",
            _ => "",
        };
        let mesh = load(&file, place, 0.04).unwrap_or_else(|error| panic!("{error}"));
        let (low, high) = mesh.bounds();
        let tolerance = if place.is_empty() { 2e-6 } else { 2e-9 };
        let far = DVec3::new(0.2, 0.3, 0.4);
        if file == "block_map.stl" {
            // Its text has other digits; only the position of the face matters.
            assert!((high.x - 0.2).abs() < tolerance, "{file}: {low} {high}");
            read += 1;
            continue;
        }
        assert!(
            low.abs_diff_eq(DVec3::ZERO, tolerance) && high.abs_diff_eq(far, tolerance),
            "{file}: {low} {high}"
        );
        assert!((mesh.area() - 0.52).abs() < 1e-5, "{file}: {}", mesh.area());
        for (point, distance) in [
            (0.5 * far, -0.1),
            (far.with_z(0.45), 0.05),
            (DVec3::new(0.1, 0.35, 0.2), 0.05),
        ] {
            let found = mesh.nearest(point).distance;
            assert!(
                (found - distance).abs() < 1e-5,
                "{file}: {found} instead of {distance} at {point}"
            );
        }
        read += 1;
    }
    assert!(read >= 20, "{read} files");
}

#[test]
fn faces_that_are_concave_leave_their_notches_free() {
    let mesh = load("concave.obj", "", 0.04).unwrap_or_else(|error| panic!("{error}"));
    assert!(
        (mesh.area() - (2.0 * 0.03 + 0.8 * 0.4)).abs() < 1e-9,
        "{}",
        mesh.area()
    );
    let notch = mesh.nearest(DVec3::new(0.15, 0.15, 0.02)).distance;
    assert!((notch - 0.05).abs() < 1e-6, "{notch}");
    assert!(mesh.nearest(DVec3::new(0.05, 0.15, 0.2)).distance < 0.0);
}

#[test]
fn shells_bound_solids_and_cavities_or_are_refused() {
    let cavity = load("cavity.obj", "", 0.04).unwrap_or_else(|error| panic!("{error}"));
    let apart = load("apart_turned.obj", "", 0.04).unwrap_or_else(|error| panic!("{error}"));
    for (mesh, free, solid) in [
        (&cavity, DVec3::splat(0.3), DVec3::new(0.1, 0.3, 0.3)),
        (&cavity, DVec3::splat(0.7), DVec3::splat(0.5)),
        (&apart, DVec3::new(0.3, 0.1, 0.1), DVec3::splat(0.1)),
        (&apart, DVec3::new(0.7, 0.1, 0.1), DVec3::new(0.5, 0.1, 0.1)),
    ] {
        assert!(mesh.nearest(free).distance > 0.0 && mesh.nearest(solid).distance < 0.0);
    }
    for (file, words) in [
        ("refused_overlap.obj", &["cross at (0.", "unite"][..]),
        (
            "refused_nested.obj",
            &["wound the same way", "flip its normals"],
        ),
        ("refused_bow.obj", &["line 9", "crosses"]),
        ("refused_surface.obj", &["line 15", "`surf`"]),
        ("refused_lost_line.obj", &["line 10 starts with `7`"]),
        ("refused_cut.stl", &["cut short"]),
        ("refused_two_binary.stl", &["bytes follow", "one file each"]),
    ] {
        let error = load(file, "", 0.04).expect_err(file);
        for word in words {
            assert!(error.contains(word) && error.contains(file), "{error}");
        }
    }
}

/// A block and the same block turned inside out, cut into triangles along the same or other diagonals, bound nothing.
#[test]
fn a_block_and_its_inverse_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("both.obj").display().to_string();
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    let faces = [
        [1, 4, 3, 2],
        [5, 6, 7, 8],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 4, 8, 7],
        [4, 1, 5, 8],
    ];
    for first in 0..4 {
        let mut text = corners.to_owned();
        for face in faces {
            let turned = [3, 2, 1, 0].map(|k: usize| face[(k + first) % 4]);
            for [a, b, c, d] in [face, turned] {
                text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
            }
        }
        std::fs::write(&file, text).expect("a file");
        for side in ["Outside", "Inside"] {
            let error = load(&file, &format!("side: {side}"), 0.04).expect_err("refused");
            let told = error.contains("encloses nothing") || error.contains("back to back");
            assert!(told && error.contains("side: Both"), "{first}: {error}");
        }
        load(&file, "side: Both", 0.04).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// Two blocks, one of them rotated, translated and inverted: refused if they intersect, or if one is inside the other
/// with the same orientation. Otherwise each is solid, whatever its orientation. Tested at the points of a lattice.
#[test]
fn two_blocks_anywhere_are_two_solids_or_refused() {
    let files = Files::new();
    let first = Surface::block(Vec3::ZERO, Vec3::ONE);
    let mut random = 7;
    let mut unit = || (next_random(&mut random) >> 8) as f32 / (1 << 24) as f32;
    let (mut refused, mut taken) = (0, 0);
    for case in 0..60 {
        let size = 0.2 + 0.5 * unit();
        let mut second = Surface::block(Vec3::splat(-size), Vec3::splat(size));
        let turn = Quat::from_euler(EulerRot::XYZ, unit(), unit(), unit());
        let middle = Vec3::new(2.6 * unit() - 0.8, 2.6 * unit() - 0.8, 2.6 * unit() - 0.8);
        second
            .vertices
            .iter_mut()
            .for_each(|x| *x = turn * *x + middle);
        let inverted = case % 2 == 0;
        if inverted {
            second.faces.iter_mut().for_each(|face| face.reverse());
        }
        let is_in = |x: Vec3| (turn.inverse() * (x - middle)).abs().max_element() - size;
        let mut both = first.clone();
        both.faces.extend(
            second
                .faces
                .iter()
                .map(|face| face.iter().map(|row| row + 8).collect()),
        );
        both.vertices.extend(&second.vertices);
        // Depth of a point of one block inside the other.
        let lattice = || {
            (0..9261)
                .map(|k| Vec3::new((k % 21) as f32, (k / 21 % 21) as f32, (k / 441) as f32) / 20.0)
        };
        let depth = lattice().map(is_in).fold(f32::INFINITY, f32::min);
        let within = second
            .vertices
            .iter()
            .all(|x| x.min(1.0 - *x).min_element() > 0.0);
        let file = files.put("blocks.obj", both.obj());
        match load(&file, "", 0.05) {
            Err(error) => {
                refused += 1;
                let named = error.contains("cross at")
                    || (within && !inverted && error.contains("same way"));
                assert!(named && depth < 0.0, "{case}: {error}, {depth}");
            }
            Ok(mesh) => {
                taken += 1;
                assert!(
                    depth > -0.08 || (within && inverted),
                    "{case}: {depth} deep"
                );
                for x in lattice().map(|x| 3.0 * x - 1.0) {
                    let in_first = x.cmpgt(Vec3::ZERO).all() && x.cmplt(Vec3::ONE).all();
                    let solid = if within {
                        in_first && is_in(x) > 0.0
                    } else {
                        in_first || is_in(x) < 0.0
                    };
                    let found = mesh.nearest(x.as_dvec3()).distance;
                    assert!(
                        found.abs() < 1e-5 || (found < 0.0) == solid,
                        "{case}: {found} at {x}"
                    );
                }
            }
        }
    }
    assert!(
        refused > 10 && taken > 10,
        "{refused} refused, {taken} taken"
    );
}

fn next_random(state: &mut u32) -> u32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    *state
}

/// Kinds of damage to a file of the corpus.
#[derive(Debug, Clone)]
enum Damage {
    Byte(usize, u8),
    Cut(usize),
    Drop(usize, usize),
    Twice(usize, usize),
    Word(usize, &'static str),
}

fn damage() -> impl Strategy<Value = Damage> {
    const WORDS: [&str; 16] = [
        "f",
        "v",
        "nan",
        "-inf",
        "1e308",
        "-1",
        "0",
        "4294967296",
        "\\\n",
        "#",
        "solid",
        "endsolid",
        "facet",
        "\u{feff}",
        "1e-310",
        "vertex",
    ];
    prop_oneof![
        (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        any::<usize>().prop_map(Damage::Cut),
        (any::<usize>(), 1..40_usize).prop_map(|(at, count)| Damage::Drop(at, count)),
        (any::<usize>(), 1..200_usize).prop_map(|(at, count)| Damage::Twice(at, count)),
        (any::<usize>(), 0..WORDS.len()).prop_map(|(at, word)| Damage::Word(at, WORDS[word])),
    ]
}

fn damaged(mut bytes: Vec<u8>, damages: &[Damage]) -> Vec<u8> {
    for damage in damages {
        let length = bytes.len();
        if length == 0 {
            break;
        }
        match *damage {
            Damage::Byte(at, byte) => bytes[at % length] = byte,
            Damage::Cut(at) => bytes.truncate(at % length),
            Damage::Drop(at, count) => {
                bytes.drain(at % length..(at % length + count).min(length));
            }
            Damage::Twice(at, count) => {
                let part = bytes[at % length..(at % length + count).min(length)].to_vec();
                bytes.splice(at % length..at % length, part);
            }
            // Replaces the existing word.
            Damage::Word(at, word) => {
                let is_space = |byte: &u8| byte.is_ascii_whitespace();
                let start = bytes[..at % length]
                    .iter()
                    .rposition(is_space)
                    .map_or(0, |space| space + 1);
                let end = bytes[start..]
                    .iter()
                    .position(is_space)
                    .map_or(length, |space| start + space);
                bytes.splice(start..end, word.bytes());
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever a file contains, the result is a mesh of finite numbers or an error that names the file.
    #[test]
    fn damaged_files_are_read_or_refused(
        which in any::<prop::sample::Index>(),
        damages in prop::collection::vec(damage(), 1..6),
        side in 0..4_usize,
    ) {
        let files = Files::new();
        let corpus = corpus();
        let (name, bytes) = &corpus[which.index(corpus.len())];
        let file = files.put(name, damaged(bytes.clone(), &damages));
        let side = ["Outside", "Inside", "Front", "Both"][side];
        match load(&file, &format!("side: {side}"), 0.04) {
            Ok(mesh) => {
                let (low, high) = mesh.bounds();
                prop_assert!(low.is_finite() && high.is_finite() && low.cmple(high).all());
                // Also sampled, unless the mesh is refused for its size or position.
                let _refused_or_not = scene(&file, &format!("side: {side}, translation: (9, 9, 9)"))
                    .map(|scene| sample(&scene));
            }
            Err(error) => prop_assert!(error.contains(name.as_str()), "{error}"),
        }
    }
}
