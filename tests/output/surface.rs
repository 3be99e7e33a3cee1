//! Surfaces of frames: closed, around the fluid, with its velocity, and one per frame.

use std::collections::HashSet;
use std::f64::consts::PI;
use std::fs;

use glam::{Vec3, vec3};
use overfall::output::Frame;
use overfall::output::surface::{SurfaceError, SurfaceFormat, SurfaceMesh, Surfacing};

/// Particles on a lattice, where `inside` says so, half a spacing off the origin.
fn lattice(spacing: f32, extent: Vec3, inside: impl Fn(Vec3) -> bool) -> Frame {
    let count = (extent / spacing).round().as_ivec3();
    let mut frame = Frame::default();
    for i in -count.x..count.x {
        for j in -count.y..count.y {
            for k in -count.z..count.z {
                let at = (vec3(i as f32, j as f32, k as f32) + 0.5) * spacing;
                if inside(at) {
                    frame.positions.push(at);
                }
            }
        }
    }
    let rows = frame.positions.len();
    frame.velocities = vec![Vec3::ZERO; rows];
    frame.ids = (0..rows as u32).collect();
    frame.densities = vec![1000.0; rows];
    frame.pressures = vec![0.0; rows];
    frame
}

const RADIUS: f32 = 0.5;

fn ball(spacing: f32) -> Frame {
    lattice(spacing, Vec3::splat(RADIUS), |at| at.length() < RADIUS)
}

fn surface(frame: &Frame, spacing: f32) -> SurfaceMesh {
    let found = Surfacing::for_spacing(spacing).of(frame);
    found.unwrap_or_else(|error| panic!("{error}"))
}

/// Every edge belongs to two triangles, which go along it in opposite directions.
#[track_caller]
fn assert_closed(mesh: &SurfaceMesh) {
    let mut edges = HashSet::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert(edge), "edge {edge:?} twice in one direction");
        }
    }
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "open");
    assert!(mesh.volume() > 0.0, "inside out");
}

/// The radius that a surface has is the ball's but for a part of a spacing, so volume and area converge with it.
#[test]
fn a_ball_has_its_volume_and_area_and_normals() {
    for spacing in [0.1, 0.05, 0.025] {
        let frame = ball(spacing);
        let mesh = surface(&frame, spacing);
        assert_closed(&mesh);
        let relative = f64::from(spacing / RADIUS);
        let r = f64::from(RADIUS);
        let volume = mesh.volume() / (4.0 / 3.0 * PI * r.powi(3)) - 1.0;
        let area = mesh.area() / (4.0 * PI * r * r) - 1.0;
        // A shell of a fifth of a spacing.
        assert!(volume.abs() < 3.0 * 0.2 * relative, "{volume}");
        assert!(area.abs() < 2.0 * 0.2 * relative, "{area}");
        for (at, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((at.length() - RADIUS).abs() < 0.5 * spacing, "{at}");
            assert!((normal.length() - 1.0).abs() < 1e-5);
            assert!(normal.dot(at.normalize()) > 0.9, "{normal} at {at}");
        }
    }
}

/// What a linear function is, the vertices have: they are outside of all particles, and a mean would lag behind.
#[test]
fn vertices_of_a_body_that_turns_move_with_it() {
    let (turn, drift) = (vec3(1.0, 2.0, -0.5), vec3(0.3, 0.0, 1.0));
    let of = |at: Vec3| drift + turn.cross(at);
    for spacing in [0.1, 0.05] {
        let mut frame = ball(spacing);
        frame.velocities = frame.positions.iter().map(|at| of(*at)).collect();
        let mesh = surface(&frame, spacing);
        let errors = mesh.positions.iter().zip(&mesh.velocities);
        let most = errors
            .map(|(at, v)| (of(*at) - *v).length())
            .fold(0.0, f32::max);
        assert!(most < 0.1 * turn.length() * spacing, "{most}");
    }
}

/// A block as it lies in a tank: faces where its particles' cubes end, but for the rounded edges.
#[test]
fn a_block_fills_its_corner_of_the_tank() {
    let (spacing, half) = (0.05, vec3(0.5, 0.3, 0.2));
    let frame = lattice(spacing, half, |_| true);
    let mesh = surface(&frame, spacing);
    assert_closed(&mesh);
    let low = mesh
        .positions
        .iter()
        .copied()
        .reduce(Vec3::min)
        .expect("vertices");
    let high = mesh
        .positions
        .iter()
        .copied()
        .reduce(Vec3::max)
        .expect("vertices");
    for (found, face) in [(-low, half), (high, half)] {
        assert!(
            (found - face).abs().max_element() < 0.25 * spacing,
            "{found}"
        );
    }
    let volume = f64::from(8.0 * half.x * half.y * half.z);
    assert!(
        (mesh.volume() / volume - 1.0).abs() < 0.08,
        "{}",
        mesh.volume() / volume
    );
}

/// A drop of one particle keeps a surface of its own, with its own velocity.
#[test]
fn single_drops_stay() {
    let spacing = 0.05;
    let mut frame = ball(spacing);
    let alone = vec3(1.2, 0.4, -0.3);
    frame.positions.push(alone);
    frame.velocities.push(Vec3::Y);
    let mesh = surface(&frame, spacing);
    assert_closed(&mesh);
    let of_drop = |at: &&Vec3| (**at - alone).length() < spacing;
    let drop: Vec<usize> = (0..mesh.positions.len())
        .filter(|i| of_drop(&&mesh.positions[*i]))
        .collect();
    assert!(drop.len() >= 8, "{}", drop.len());
    assert!(
        drop.iter()
            .all(|i| (mesh.velocities[*i] - Vec3::Y).length() < 1e-5)
    );
}

#[test]
fn a_frame_without_particles_has_an_empty_surface() {
    let nowhere = Frame {
        positions: vec![Vec3::NAN, Vec3::INFINITY],
        velocities: vec![Vec3::ZERO; 2],
        ..Frame::default()
    };
    for frame in [Frame::default(), nowhere] {
        let mesh = surface(&frame, 0.1);
        assert!(mesh.triangles.is_empty() && mesh.positions.is_empty());
        assert_eq!((mesh.volume(), mesh.area()), (0.0, 0.0));
        let folder = tempfile::tempdir().expect("a folder");
        for format in [SurfaceFormat::Ply, SurfaceFormat::Obj, SurfaceFormat::Vtu] {
            mesh.write(&folder.path().join("a"), format)
                .expect("a file");
        }
    }
}

/// One surface per frame, whichever threads there are: also where the library divides the space.
#[test]
fn a_frame_has_one_surface() {
    let spacing = 0.05;
    let bar = lattice(spacing, vec3(1.6, 0.15, 0.15), |at| at.x.sin() * 0.1 > at.y);
    let first = surface(&bar, spacing);
    assert_closed(&first);
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads");
        for _ in 0..3 {
            assert_eq!(
                pool.install(|| surface(&bar, spacing)),
                first,
                "{threads} threads"
            );
        }
    }
}

#[test]
fn impossible_surfaces_are_refused() {
    let frame = ball(0.1);
    let usual = Surfacing::for_spacing(0.1);
    for wrong in [
        Surfacing {
            particle_radius: 0.0,
            ..usual
        },
        Surfacing {
            cube_size: f32::NAN,
            ..usual
        },
        Surfacing {
            smoothing_length: 99.0,
            ..usual
        },
        Surfacing {
            threshold: 1.0,
            ..usual
        },
    ] {
        let refused = wrong.of(&frame).expect_err("a wrong parameter");
        assert!(
            matches!(refused, SurfaceError::Parameter { .. }),
            "{refused}"
        );
    }
    // Too far for any grid: an error that says so, never a panic.
    let mut far = frame;
    far.positions[0] = Vec3::splat(1e20);
    let refused = usual.of(&far).expect_err("a particle far away");
    assert!(refused.to_string().contains("outside: Remove"), "{refused}");
}

/// The numbers of an OBJ file are those of the mesh, and so are those of the binary formats.
#[test]
fn files_hold_the_mesh() {
    let mut frame = ball(0.1);
    frame.velocities = frame.positions.iter().map(|at| at.cross(Vec3::Y)).collect();
    let mesh = surface(&frame, 0.1);
    let folder = tempfile::tempdir().expect("a folder");
    let write = |format: SurfaceFormat| {
        let path = folder.path().join(format!("a.{}", format.extension()));
        mesh.write(&path, format).expect("a file");
        fs::read(&path).expect("the file")
    };
    let obj = String::from_utf8(write(SurfaceFormat::Obj)).expect("text");
    let vectors = |key: &str| -> Vec<Vec3> {
        let rows = obj.lines().filter_map(|line| line.strip_prefix(key));
        let numbers = rows.map(|row| row.split(' ').map(|word| word.parse().expect("a number")));
        numbers
            .map(|mut row| Vec3::from_array(std::array::from_fn(|_| row.next().expect("three"))))
            .collect()
    };
    assert_eq!(
        (vectors("v "), vectors("vn ")),
        (mesh.positions.clone(), mesh.normals.clone())
    );
    assert_eq!(
        obj.lines().filter(|line| line.starts_with("f ")).count(),
        mesh.triangles.len()
    );
    let ply = write(SurfaceFormat::Ply);
    let head = b"end_header\n";
    let start = ply
        .windows(head.len())
        .position(|window| window == head)
        .expect("a head")
        + head.len();
    assert_eq!(
        ply.len() - start,
        36 * mesh.positions.len() + 13 * mesh.triangles.len()
    );
    let last = mesh.positions.len() - 1;
    let speed: [f32; 3] = std::array::from_fn(|i| {
        let at = start + 36 * last + 24 + 4 * i;
        f32::from_le_bytes(ply[at..at + 4].try_into().expect("four bytes"))
    });
    assert_eq!(Vec3::from(speed), mesh.velocities[last]);
    let vtu = String::from_utf8(write(SurfaceFormat::Vtu)).expect("text");
    let piece = format!(
        "NumberOfPoints=\"{}\" NumberOfCells=\"{}\"",
        mesh.positions.len(),
        mesh.triangles.len()
    );
    assert!(vtu.contains(&piece) && vtu.contains("Normals=\"normal\""));
}
