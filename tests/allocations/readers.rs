//! What is read takes memory in proportion to the file, whatever the file promises.
//!
//! Every file of the corpus is read as it is, cut short, and with each of its numbers replaced by a huge one. All bytes
//! that are allocated count, also those that are freed at once.

use std::fs;

use overfall::checkpoint::Checkpoint;
use overfall::loading::Override;
use overfall::measure::Curve;
use overfall::mesh::Mesh;
use overfall::output::{Frame, Series};
use overfall::scene::{
    AccelerationTable, FrameFormat, MotionTable, Neighbours, Scene, VelocityGrid,
};
use overfall::step::Order;
use overfall::study::{Pause, Plan, Reference, stability::StabilityPlan};
use overfall::{Simulation, checkpoint};

use crate::alone;
use crate::budget::{Readings, files, spoilt, text};
use crate::common::{dam, run};

#[test]
fn scenes_and_orders_take_memory_in_proportion_to_their_length() {
    let _alone = alone();
    let place = "tests/corpus/scenes/s.ron";
    let mut scenes = Readings::new("scenes", 1000, 1 << 18);
    for (name, bytes) in files("tests/corpus/scenes") {
        scenes.all(&name, &bytes, |bytes| {
            drop(Scene::parse(&text(bytes), place, &[]))
        });
    }
    for open in ["(", "[", "(bodies: [", "Some(", "\"", "/*", "a.", "-"] {
        let long = open.repeat(20_000);
        scenes.read(open, long.len(), || Scene::parse(&long, place, &[]));
    }
    scenes.end();

    let (_, scene) = &files("tests/corpus/scenes")
        .into_iter()
        .find(|(_, bytes)| Scene::parse(&text(bytes), place, &[]).is_ok())
        .expect("a scene that is right");
    let mut overrides = Readings::new("overrides", 1000, 1 << 18);
    for (_, bytes) in files("tests/corpus/overrides") {
        for line in text(&bytes).lines() {
            for (how, spoilt) in spoilt(line.as_bytes()) {
                let length = scene.len() + spoilt.len();
                overrides.read(&format!("{line}, {how}"), length, || {
                    let change = Override::parse(&text(&spoilt)).ok()?;
                    Scene::parse(&text(scene), place, &[change]).ok()
                });
            }
        }
    }
    overrides.end();

    let scene = dam();
    let mut orders = Readings::new("orders", 200, 1 << 16);
    for (name, bytes) in [files("tests/corpus/orders"), files("assets/orders")].concat() {
        orders.all(&name, &bytes, |bytes| {
            if let Ok(order) = Order::parse(&text(bytes)) {
                drop(order.check(&scene).map_err(|error| error.to_string()));
            }
        });
    }
    orders.end();
}

#[test]
fn studies_and_tables_take_memory_in_proportion_to_their_length() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "(name: \"s\", dimension: 2, spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))])";
    fs::write(folder.path().join("scene.ron"), scene).expect("a file");
    let file = folder.path().join("study.ron");
    // A study reads its scene again for every variant and point.
    let mut studies = Readings::new("studies", 1000, 2 << 20);
    for (name, bytes) in files("tests/corpus/studies") {
        for (how, spoilt) in spoilt(&bytes) {
            fs::write(&file, &spoilt).expect("a file");
            studies.read(&format!("{name}, {how}"), spoilt.len(), || {
                (Plan::load(&file).ok(), StabilityPlan::load(&file, &[]).ok())
            });
        }
    }
    studies.end();

    let mut tables = Readings::new("tables", 40, 1 << 16);
    let corpus = [
        "tests/corpus/tables",
        "tests/corpus/motions",
        "assets/reference",
    ];
    for (name, bytes) in corpus.map(files).concat() {
        for (how, spoilt) in spoilt(&bytes) {
            fs::write(&file, &spoilt).expect("a file");
            let text = text(&spoilt).into_owned();
            tables.read(&format!("{name}, {how}"), spoilt.len(), || {
                let curve = Curve::parse(&text, &file, [None; 2], |[t, y]| (t, y));
                (
                    Reference::parse(&text).ok(),
                    curve.ok(),
                    MotionTable::load(&file).ok(),
                    AccelerationTable::load(&file).ok(),
                    VelocityGrid::load(&file).ok(),
                )
            });
        }
    }
    tables.end();
}

#[test]
fn meshes_take_memory_in_proportion_to_their_length() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let mut meshes = Readings::new("meshes", 200, 1 << 18);
    let mut load = |name: &str, how: &str, bytes: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, bytes).expect("a file");
        let boundary = ron::from_str(&format!("(file: {file:?})")).expect("a boundary");
        meshes.read(&format!("{name}, {how}"), bytes.len(), || {
            Mesh::load(&boundary, 0.04).ok()
        });
    };
    for (name, bytes) in files("tests/meshes") {
        for (how, spoilt) in spoilt(&bytes) {
            load(&name, &how, &spoilt);
        }
        // Numbers in binary: of triangles, above all.
        for at in (0..bytes.len().min(140) / 4).map(|word| 4 * word) {
            for value in [u32::MAX, i32::MAX as u32, 1 << 24] {
                let mut spoilt = bytes.clone();
                spoilt[at..at + 4].copy_from_slice(&value.to_le_bytes());
                load(&name, &format!("{value} at byte {at}"), &spoilt);
            }
        }
    }
    for (name, repeated) in [
        ("f.obj", "f 1 2 3\n"),
        ("fan.obj", "1 2 3 "),
        ("v.obj", "v 0 0 0\n"),
        ("facet.stl", "facet outer loop "),
    ] {
        let head = ["v 0 0 0\nv 1 0 0\nv 0 1 0\n", "solid\n"][usize::from(name.ends_with("stl"))];
        let head = head.to_owned() + ["", "f "][usize::from(name == "fan.obj")];
        load(
            name,
            "repeated",
            (head + &repeated.repeat(20_000)).as_bytes(),
        );
    }
    meshes.end();
}

#[test]
fn particles_and_frames_take_memory_in_proportion_to_their_length() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let mut bodies = Readings::new("bodies of particles", 500, 1 << 20);
    let mut load = |name: &str, how: &str, bytes: &[u8]| {
        fs::write(folder.path().join(name), bytes).expect("a file");
        let scene =
            format!("(name: \"s\", spacing: 0.1, bodies: [(shape: Particles(file: {name:?}))])");
        let place = folder.path().join("s.ron").display().to_string();
        bodies.read(&format!("{name}, {how}"), bytes.len(), || {
            Scene::parse(&scene, &place, &[]).ok()
        });
    };
    let csv = b"x,y,z\n0,0,0\n0.1,0,0\n0,0.1,0\n";
    let ascii = b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n0 0 0\n0.1 0 0\n";
    let list = |kind: &str, format: &str, count: &[u8]| {
        let head = format!(
            "ply\nformat {format} 1.0\nelement face 1\nproperty list {kind} double a\nelement vertex 1\n\
             property float x\nproperty float y\nproperty float z\nend_header\n"
        );
        [head.as_bytes(), count, &[0; 40]].concat()
    };
    let mut simulation = Simulation::with_threads(&dam(), 1).expect("a scene that runs");
    run(&mut simulation, 2);
    let frame = Frame::from_world(simulation.world_mut());
    let written = |name: &str, format| {
        let file = folder.path().join(name);
        frame.write(&file, format).expect("a frame");
        fs::read(file).expect("a frame")
    };
    let frames = [("f.ply", FrameFormat::Ply), ("f.vtu", FrameFormat::Vtu)];
    let frames = frames.map(|(name, format)| (name, written(name, format)));
    let huge = u32::MAX.to_le_bytes();
    let more = [
        ("p.csv", csv.to_vec()),
        ("a.ply", ascii.to_vec()),
        ("l.ply", list("uint", "binary_little_endian", &huge)),
        ("m.ply", list("uint", "binary_big_endian", &huge)),
        ("n.ply", list("int", "ascii", b"4294967295 1 2 3\n")),
    ];
    for (name, bytes) in more.iter().chain(&frames) {
        for (how, spoilt) in spoilt(bytes) {
            load(name, &how, &spoilt);
        }
    }
    bodies.end();

    let mut read = Readings::new("frames", 10, 1 << 16);
    for (name, bytes) in &frames {
        let file = folder.path().join(name);
        for (how, spoilt) in spoilt(bytes) {
            fs::write(&file, &spoilt).expect("a file");
            read.read(&format!("{name}, {how}"), spoilt.len(), || {
                Frame::read(&file).ok()
            });
        }
    }
    let series = b"<VTKFile><Collection><DataSet timestep=\"0.5\" part=\"0\" \
        file=\"frames/f.vtu\"/></Collection></VTKFile>";
    let file = folder.path().join("s.pvd");
    for (how, spoilt) in spoilt(series) {
        fs::write(&file, &spoilt).expect("a file");
        read.read(&format!("series, {how}"), spoilt.len(), || {
            Series::read(&file).ok()
        });
    }
    read.end();
}

/// An image of few bytes may hold many points; their number is limited.
#[test]
fn images_take_memory_in_proportion_to_the_points_that_are_possible() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("h.png");
    let mut images = Readings::new("images", 100, 16 << 20);
    for [width, height] in [
        [1_u32, 1],
        [2, 2],
        [1500, 1500],
        [1 << 20, 2],
        [1 << 16, 1 << 16],
        [u32::MAX >> 1; 2],
    ] {
        for depth in [1, 8, 16] {
            let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
            let header = [
                &width.to_be_bytes()[..],
                &height.to_be_bytes(),
                &[depth, 0, 0, 0, 0],
            ];
            for (name, data) in [
                (b"IHDR", header.concat()),
                (b"IDAT", vec![0x78, 0x9c]),
                (b"IEND", Vec::new()),
            ] {
                bytes.extend((data.len() as u32).to_be_bytes());
                let checked = [&name[..], &data].concat();
                bytes.extend(&checked);
                bytes.extend(crc32fast::hash(&checked).to_be_bytes());
            }
            fs::write(&file, &bytes).expect("a file");
            let scene = format!(
                "(name: \"s\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))], boundaries: \
                 [Terrain(size: (2, 2), heights: Image(file: {file:?}, black: 0, white: 1))])"
            );
            let name = format!("{width} × {height}, {depth} bits");
            images.read(&name, bytes.len(), || {
                Scene::parse(&scene, "s.ron", &[]).ok()
            });
        }
    }
    images.end();
}

#[test]
fn checkpoints_take_memory_in_proportion_to_their_length() {
    let _alone = alone();
    let mut read = Readings::new("checkpoints", 5, 1 << 15);
    let mut restored = Readings::new("restored checkpoints", 60, 5 << 20);
    for neighbours in [Neighbours::Stored, Neighbours::Verlet { skin: 0.1 }] {
        let scene = Scene {
            neighbours,
            ..dam()
        };
        let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
        run(&mut simulation, 3);
        let saved = Checkpoint::of(simulation.world_mut()).expect("a checkpoint");
        let bytes = saved.to_bytes();
        for length in [20, 24, 40, 100, bytes.len() / 2, bytes.len()] {
            for promise in [length as u64, 1 << 40, u64::MAX] {
                let mut spoilt = bytes[..length].to_vec();
                spoilt[12..20].copy_from_slice(&promise.to_le_bytes());
                let name = format!("{promise} of {length}");
                read.read(&name, length, || Checkpoint::read(&mut &spoilt[..]).ok());
                read.read(&name, length, || Pause::read(&mut &spoilt[..]).ok());
            }
        }
        // Lengths within it, with a checksum that is right.
        let places = (20..300).chain((300..bytes.len() - 24).step_by(bytes.len() / 300));
        for (place, k) in places.zip(0..) {
            let mut spoilt = bytes[..bytes.len() - 4].to_vec();
            let number: &[u8] = match k % 3 {
                0 => &[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01],
                1 => &[0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x02],
                _ => &[0xff, 0xff, 0xff, 0xff],
            };
            spoilt[place..place + number.len()].copy_from_slice(number);
            spoilt.extend(crc32fast::hash(&spoilt).to_le_bytes());
            let name = format!("{neighbours:?}, {number:02x?} at byte {place}");
            read.read(&name, spoilt.len(), || {
                Checkpoint::read(&mut &spoilt[..]).ok()
            });
            if let Ok(checkpoint) = Checkpoint::read(&mut &spoilt[..]) {
                restored.read(&name, spoilt.len(), || {
                    checkpoint.restore(simulation.world_mut())
                });
            }
        }
        assert!(checkpoint::steps_until_possible(simulation.world_mut()) < u64::MAX);
    }
    read.end();
    restored.end();
}
