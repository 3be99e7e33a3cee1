//! Warnings for fluid that enters or leaves otherwise than a scene's author thinks.

use super::numbers::short;
use crate::scene::shapes::{Inlet, Lattice};
use crate::scene::{BoundaryShape, Bounds, Emitter, Scene, WallCourse};

/// Times at which walls are looked at, evenly over the run.
const LOOKS: u32 = 97;

pub(super) fn of(scene: &Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let name = format!("emitters.{index}");
        warnings
            .extend(enters_nothing(scene, emitter, &name).or_else(|| met(scene, emitter, &name)));
    }
    let boxes = scene.outflow.iter().enumerate();
    warnings.extend(boxes.filter_map(|(index, bounds)| removes(scene, bounds, index)));
    warnings
}

/// An emitter of which no layer passes the face while the scene lasts.
fn enters_nothing(scene: &Scene, emitter: &Emitter, name: &str) -> Option<String> {
    if emitter.start >= scene.duration {
        return Some(format!(
            "`{name}` starts at {} s, and the scene ends at {} s: nothing enters",
            emitter.start, scene.duration
        ));
    }
    let inlet = Inlet::new(emitter, scene);
    let way = inlet.way(emitter, 0, scene.duration.into());
    (way < 0.0).then(|| {
        format!(
            "`{name}` enters at {} m/s: until the scene ends at {} s not one layer passes the face, which takes \
             {} s",
            emitter.speed,
            scene.duration,
            short(0.5 * inlet.pitch / f64::from(emitter.speed))
        )
    })
}

/// A box that removes fluid which is in it at the start, or that no fluid can reach.
fn removes(scene: &Scene, bounds: &Bounds, index: usize) -> Option<String> {
    let period = scene.period();
    let beyond = scene.domain.is_some_and(|domain| {
        let apart = bounds.max.cmplt(domain.min) | bounds.min.cmpgt(domain.max);
        (apart & !period.axes()).any()
    });
    if beyond {
        return Some(format!(
            "`outflow.{index}` is outside of `domain`, where no fluid gets: it removes nothing"
        ));
    }
    let (mut all, mut removed) = (0_u64, 0_u64);
    for body in &scene.bodies {
        let lattice = Lattice::new(&body.shape, scene.spacing.into(), scene.dimension);
        lattice.for_each(|x| {
            all += 1;
            removed += u64::from(period.contains(bounds, x.as_vec3()));
        });
    }
    let how_many = if removed == all {
        "all".to_owned()
    } else {
        format!("{removed}")
    };
    (removed > 0).then(|| {
        format!(
            "`outflow.{index}` removes {how_many} of the {all} particles of `bodies` in the first step: they start in \
             it"
        )
    })
}

/// A wall that comes to where the fluid waits behind a face: neither gives way.
fn met(scene: &Scene, emitter: &Emitter, name: &str) -> Option<String> {
    let (low, high) = Inlet::new(emitter, scene).bounds();
    let end = f64::from(scene.duration);
    scene.boundaries.iter().enumerate().find_map(|(index, wall)| {
        let course = WallCourse::new(wall.motion()?).ok()?;
        if wall.frame().is_turned() {
            return None;
        }
        let (min, max, holds) = match *wall {
            BoundaryShape::Tank { min, max, .. } => (min, max, true),
            BoundaryShape::Box { min, max, .. } => (min, max, false),
            BoundaryShape::Sphere { center, radius, .. } => (center - radius, center + radius, false),
            BoundaryShape::Plane { .. }
            | BoundaryShape::Mesh(_)
            | BoundaryShape::Revolution(_)
            | BoundaryShape::Terrain(_) => return None,
        };
        let meets = |time: f64| {
            let pose = course.pose(time);
            let corners = [min, max].map(|x| pose.place(x));
            let (first, last) = (corners[0].min(corners[1]), corners[0].max(corners[1]));
            let apart = first.cmpge(high) | last.cmple(low);
            let around = first.cmple(low) & last.cmpge(high);
            let mut axes = 0..usize::from(u8::from(scene.dimension));
            let is_around = holds && axes.clone().all(|axis| around.test(axis));
            !axes.any(|axis| apart.test(axis)) && !is_around
        };
        // Where a wall is at the start is refused, not warned of.
        let mut times = (0..=LOOKS).map(|k| end * f64::from(k) / f64::from(LOOKS));
        let begins = f64::from(emitter.start);
        let stops = emitter.end.map_or(end, f64::from);
        let time = times.find(|&time| (begins..=stops).contains(&time) && meets(time))?;
        Some(format!(
            "the wall `boundaries.{index}` is at {} s where the fluid of `{name}` waits behind the face, from {} to \
             {}: neither gives way; move one of them, or let the emitter end before",
            short(time),
            low.as_vec3(),
            high.as_vec3()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::super::warnings;
    use crate::scene::Scene;

    fn of(rest: &str) -> String {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, duration: 2,
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))], {rest})"
        );
        let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        warnings(&scene).expect("a scene").join("\n")
    }

    const TANK: &str = "boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 0))]";

    #[test]
    fn an_emitter_of_which_nothing_enters_is_told() {
        for (timing, part) in [
            ("speed: 1, start: 2", "starts at 2 s"),
            ("speed: 0.01", "not one layer"),
            ("speed: 1, start: 1.96", "not one layer"),
            ("speed: 0.03", ""),
            ("speed: 1, start: 1.9", ""),
        ] {
            let told = of(&format!(
                "{TANK}, emitters: [(shape: Disc(center: (1, 1, 0), normal: (0, -1, 0), radius: 0.2), {timing})]"
            ));
            assert!(
                told.contains(part) && told.is_empty() == part.is_empty(),
                "{timing}: {told}"
            );
        }
    }

    #[test]
    fn outflow_that_takes_the_start_or_takes_nothing_is_told() {
        let domain = "domain: (min: (-1, -1, 0), max: (3, 3, 0))";
        for (low, high, top, part) in [
            (-1.0, 0.4, 0.32, "removes 12 of the 25 particles"),
            (-1.0, 1.0, 0.8, "removes all of the 25"),
            (0.5, 1.0, 0.8, ""),
            (3.5, 4.0, 0.8, "outside of `domain`"),
        ] {
            let told = of(&format!(
                "{TANK}, {domain}, outflow: [(min: ({low}, -1, 0), max: ({high}, {top}, 0))]"
            ));
            assert!(
                told.contains(part) && told.is_empty() == part.is_empty(),
                "{low}: {told}"
            );
        }
        // The image of a box counts as the box.
        let told = of("periodic: (x: (0, 2)), outflow: [(min: (1.5, -1, 0), max: (2.2, 1, 0))]");
        assert!(told.contains("removes 10 of the 25"), "{told}");
    }

    #[test]
    fn a_wall_that_comes_to_a_face_is_told() {
        for (wall, meets) in [
            (
                "Box(min: (0.6, 1.7, 0), max: (1.4, 1.9, 0), motion: Velocity(velocity: (0, -0.3, 0)))",
                true,
            ),
            (
                "Box(min: (0.6, 1.7, 0), max: (1.4, 1.9, 0), motion: Velocity(velocity: (0, -0.1, 0)))",
                false,
            ),
            (
                "Sphere(center: (1.8, 1.2, 0), radius: 0.15, \
                    motion: Oscillation(amplitude: (0.6, 0, 0), frequency: 1))",
                true,
            ),
            (
                "Tank(min: (-1, -1, 0), max: (3, 3, 0), motion: Velocity(velocity: (1, 0, 0)))",
                true,
            ),
            (
                "Tank(min: (-1, -1, 0), max: (3, 3, 0), motion: Velocity(velocity: (0.3, 0, 0)))",
                false,
            ),
        ] {
            let told = of(&format!(
                "boundaries: [{wall}],
                emitters: [(shape: Disc(center: (1, 1, 0), normal: (0, -1, 0), radius: 0.2), speed: 1)]"
            ));
            assert_eq!(told.contains("neither gives way"), meets, "{wall}: {told}");
        }
    }
}
