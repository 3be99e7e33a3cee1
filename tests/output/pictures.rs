//! Pictures are correct: near objects hide far ones, colours follow speed, and neither the number of threads nor
//! unusual input changes that.

use glam::{Vec3, vec3};
use overfall::output::Frame;
use overfall::output::picture::{
    ColourMap, Image, Quantity, Solid, View, contact_sheet, draw, evenly_spaced,
};
use overfall::scene::{Bounds, Camera, Dimension, Scene};

fn frame(particles: &[(Vec3, f32)]) -> Frame {
    let rows = particles.len();
    Frame {
        ids: (0..rows as u32).collect(),
        positions: particles.iter().map(|particle| particle.0).collect(),
        velocities: particles
            .iter()
            .map(|particle| particle.1 * Vec3::X)
            .collect(),
        densities: vec![1000.0; rows],
        pressures: vec![0.0; rows],
        ..Frame::default()
    }
}

/// Looks from +z at the origin, 161 × 91 pixels, particles only.
fn view() -> View {
    View {
        width: 161,
        height: 91,
        dimension: Dimension::Three,
        camera: Some(Camera {
            position: vec3(0.0, 0.0, 5.0),
            target: Vec3::ZERO,
            field_of_view: 40.0,
        }),
        bounds: Bounds {
            min: Vec3::splat(-1.0),
            max: Vec3::splat(1.0),
        },
        camera_path: None,
        particle_radius: 0.5,
        quantity: Quantity::Speed,
        range: (0.0, 4.0),
        colours: ColourMap::Water,
        floor: None,
        edges: Vec::new(),
        solids: Vec::new(),
        glass: Vec::new(),
        legend: false,
    }
}

fn centre(image: &Image) -> [u8; 3] {
    image.pixel(image.width() / 2, image.height() / 2).unwrap()
}

fn lightness(pixel: [u8; 3]) -> u32 {
    pixel.into_iter().map(u32::from).sum()
}

/// A pool of a few thousand particles at pseudo-random positions.
fn pool() -> Frame {
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let particles: Vec<_> = (0..4000)
        .map(|_| {
            let at = vec3(random(), 0.4 * random(), random()) * 2.0 - 1.0;
            (at, 4.0 * random())
        })
        .collect();
    frame(&particles)
}

fn pool_view() -> View {
    View {
        camera: None,
        particle_radius: 0.04,
        floor: Some(-1.0),
        edges: vec![[Vec3::NEG_ONE, Vec3::ONE]],
        solids: vec![
            Solid::Sphere {
                center: vec3(0.5, -0.5, 0.5),
                radius: 0.4,
            },
            Solid::Box(Bounds {
                min: vec3(-0.9, -1.0, 0.0),
                max: vec3(-0.5, 0.2, 0.6),
            }),
            Solid::Wall {
                center: vec3(0.0, 0.0, -1.0),
                normal: Vec3::Z,
                half_edges: [Vec3::X, Vec3::Y],
            },
        ],
        legend: true,
        ..view()
    }
}

#[test]
fn a_sphere_in_front_hides_the_one_behind() {
    let (near, far) = (vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, -1.0));
    let slow = centre(&draw(&frame(&[(near, 0.0)]), &view()));
    let fast = centre(&draw(&frame(&[(near, 4.0)]), &view()));
    for order in [[0, 1], [1, 0]] {
        let both = [(near, 0.0), (far, 4.0)];
        assert_eq!(
            centre(&draw(&frame(&order.map(|i| both[i])), &view())),
            slow
        );
        let both = [(near, 4.0), (far, 0.0)];
        assert_eq!(
            centre(&draw(&frame(&order.map(|i| both[i])), &view())),
            fast
        );
    }
}

#[test]
fn a_sphere_is_as_large_as_the_camera_makes_it() {
    let empty = draw(&Frame::default(), &view());
    let image = draw(&frame(&[(Vec3::ZERO, 0.0)]), &view());
    let y = image.height() / 2;
    let covered = (0..image.width())
        .filter(|&x| image.pixel(x, y) != empty.pixel(x, y))
        .count();
    // Half the height of the picture is tan 20° × 5 m = 1.82 m: the diameter of 1 m has 25 of 91 pixels.
    assert!((24..=27).contains(&covered), "{covered} pixels");
}

#[test]
fn colours_grow_lighter_with_speed_and_stop_at_the_ends_of_the_range() {
    let colour = |speed| centre(&draw(&frame(&[(Vec3::ZERO, speed)]), &view()));
    let shades: Vec<_> = [0.0, 1.0, 2.0, 3.0, 4.0]
        .map(|speed| lightness(colour(speed)))
        .into();
    assert!(shades.is_sorted_by(|a, b| a < b), "{shades:?}");
    assert_eq!(colour(4.0), colour(400.0));
    assert_eq!(colour(0.0), colour(f32::NAN));
    let [red, _, blue] = colour(0.0);
    assert!(blue > 2 * red, "slow water is blue");
}

#[test]
fn a_solid_hides_a_particle_behind_it_and_a_wall_only_from_its_front() {
    let particle = frame(&[(Vec3::ZERO, 0.0)]);
    let blue = centre(&draw(&particle, &view()));
    let with = |solid| {
        centre(&draw(
            &particle,
            &View {
                solids: vec![solid],
                ..view()
            },
        ))
    };
    let ball = Solid::Sphere {
        center: vec3(0.0, 0.0, 2.0),
        radius: 0.5,
    };
    let wall = |normal| Solid::Wall {
        center: vec3(0.0, 0.0, 2.0),
        normal,
        half_edges: [Vec3::X, Vec3::Y],
    };
    assert!(lightness(with(ball)) > lightness(blue));
    assert!(lightness(with(wall(Vec3::Z))) > lightness(blue));
    let [red, _, b] = with(wall(Vec3::NEG_Z));
    assert!(
        b > 2 * red,
        "the particle is seen through the back of a wall"
    );
}

/// A glass is seen, and so is what is in it and behind it; stone hides what is behind.
#[test]
fn glass_is_seen_through() -> Result<(), Box<dyn std::error::Error>> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    let scene = Scene::load(&root.join("glass_small.ron"), &[])?;
    let glass = View {
        legend: false,
        particle_radius: 0.01,
        ..View::from_scene(&scene).with_size(120, 160).with_glass()
    };
    let without = View {
        glass: Vec::new(),
        ..glass.clone()
    };
    let stone = View {
        floor: glass.floor,
        legend: false,
        ..View::from_scene(&scene).with_size(120, 160)
    };
    assert_eq!(glass.solids.len() + glass.glass.len(), stone.solids.len());
    let drop = frame(&[(vec3(0.0, 0.12, 0.0), 0.0)]);
    let [glass, without, stone] = [glass, without, stone].map(|view| draw(&drop, &view));
    let mut changed = [0_u32; 2];
    for y in 0..160 {
        for x in 0..120 {
            let pixel = |image: &Image| image.pixel(x, y).expect("a pixel").map(i32::from);
            let bare = pixel(&without);
            for (changed, image) in changed.iter_mut().zip([&glass, &stone]) {
                let difference = (0..3).map(|i| (pixel(image)[i] - bare[i]).unsigned_abs());
                *changed += difference.sum::<u32>();
            }
        }
    }
    let [by_glass, by_stone] = changed;
    assert!(by_glass > 0 && 2 * by_glass < by_stone, "{changed:?}");
    // The drop is blue, through the wall of the glass.
    let (x, y) = (0..160)
        .flat_map(|y| (0..120).map(move |x| (x, y)))
        .max_by_key(|&(x, y)| {
            let [red, _, blue] = without.pixel(x, y).expect("a pixel").map(i32::from);
            blue - red
        })
        .expect("a picture");
    let [red, _, blue] = glass.pixel(x, y).expect("a pixel");
    assert!(blue > red + 60, "{red} {blue}");
    // No ground is of glass.
    let river = Scene::load(&root.join("river_small.ron"), &[])?;
    let view = View::from_scene(&river);
    assert_eq!(view.clone().with_glass(), view);
    Ok(())
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let (frame, view) = (pool(), pool_view());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| draw(&frame, &view))
    };
    let one = with(1);
    assert!(
        one.as_rgb().iter().any(|byte| *byte < 100),
        "something dark is drawn"
    );
    for threads in [2, 3, 8] {
        assert_eq!(with(threads), one, "{threads} threads");
    }
}

#[test]
fn two_dimensions_are_seen_from_the_front_as_a_plane() {
    let flat = View {
        dimension: Dimension::Two,
        bounds: Bounds {
            min: vec3(-1.0, -1.0, 0.0),
            max: vec3(1.0, 1.0, 0.0),
        },
        ..view()
    };
    let empty = draw(&Frame::default(), &flat);
    let image = draw(
        &frame(&[(vec3(-0.5, 0.5, 0.0), 0.0), (vec3(0.5, -0.5, 0.0), 4.0)]),
        &flat,
    );
    let changed = |right: bool, low: bool| {
        let columns = (0..image.width()).filter(|x| (*x > image.width() / 2) == right);
        let pixels = columns.flat_map(|x| (0..image.height()).map(move |y| (x, y)));
        let half = pixels.filter(|(_, y)| (*y > image.height() / 2) == low);
        half.filter(|&(x, y)| image.pixel(x, y) != empty.pixel(x, y))
            .count()
    };
    assert!(changed(false, false) > 100 && changed(true, true) > 100);
    assert!(changed(false, true) + changed(true, false) < 100);
}

#[test]
fn odd_input_gives_a_picture_all_the_same() {
    let odd = [f32::NAN, f32::INFINITY, -1e38, 1e38, 1e-38, 0.0];
    let particles: Vec<_> = odd.iter().map(|&x| (vec3(x, -x, x), x)).collect();
    let mut frame = frame(&particles);
    frame.velocities.pop();
    for dimension in [Dimension::Two, Dimension::Three] {
        for &x in &odd {
            let view = View {
                dimension,
                camera: (x != 0.0).then_some(Camera {
                    position: Vec3::splat(x),
                    target: Vec3::splat(x),
                    field_of_view: x,
                }),
                bounds: Bounds {
                    min: Vec3::splat(x),
                    max: Vec3::splat(x),
                },
                particle_radius: x,
                range: (x, x),
                floor: Some(x),
                edges: vec![[Vec3::splat(x), Vec3::ZERO]],
                solids: vec![
                    Solid::Sphere {
                        center: Vec3::splat(x),
                        radius: x,
                    },
                    Solid::Wall {
                        center: Vec3::ZERO,
                        normal: Vec3::splat(x),
                        half_edges: [Vec3::splat(x), Vec3::ZERO],
                    },
                ],
                ..pool_view()
            };
            let image = draw(&frame, &view.with_size(40, 30));
            assert_eq!(image.as_rgb().len(), 40 * 30 * 3);
        }
    }
    assert_eq!(draw(&frame, &view().with_size(0, 0)).as_rgb().len(), 3);
}

#[test]
fn a_contact_sheet_has_a_cell_a_picture() {
    let image = draw(&pool(), &pool_view().with_size(100, 50));
    let sheet = contact_sheet(&vec![image.clone(); 7], 3);
    assert_eq!((sheet.width(), sheet.height()), (4 + 3 * 104, 4 + 3 * 54));
    // The second cell of the second row shows the picture unscaled.
    assert_eq!(sheet.pixel(4 + 104 + 30, 4 + 54 + 20), image.pixel(30, 20));
    assert_eq!(sheet.pixel(0, 0), Some([255; 3]));

    let large = draw(&pool(), &pool_view().with_size(960, 540));
    let sheet = contact_sheet(&vec![large; 12], 4);
    assert!(
        sheet.width() <= 1920 && sheet.width() > 1900,
        "{}",
        sheet.width()
    );
    assert_eq!(contact_sheet(&[], 4).as_rgb().len(), 0);
}

#[test]
fn evenly_spaced_indices_hold_the_first_and_the_last() {
    assert_eq!(evenly_spaced(101, 5), [0, 25, 50, 75, 100]);
    assert_eq!(evenly_spaced(3, 12), [0, 1, 2]);
    assert_eq!(evenly_spaced(0, 12), [0; 0]);
    let sixteen = evenly_spaced(17, 16);
    assert_eq!((sixteen.len(), sixteen[0], sixteen[15]), (16, 0, 16));
    assert!(sixteen.is_sorted_by(|a, b| a < b));
}

#[test]
fn a_picture_is_written_as_png() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let image = draw(&pool(), &pool_view());
    image.write_png(&path).unwrap();
    let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (161, 91));
    assert_eq!(bytes, image.as_rgb());
}
