//! Walls in prescribed motion.
//!
//! Where a wall is follows from the time alone: a step that is taken back takes its walls back, and a checkpoint
//! holds nothing of them. In a step from t to t + dt a sample goes from its place at t to that at t + dt. Its
//! velocity is the mean of the step: Dρ/Dt with it leads to the density beside the wall where that will be, and contact
//! holds the fluid off there. Places are computed in double precision from the shape, and nothing adds up.
//!
//! The index takes over what changed its cell. Volumes are summed anew where a wall is near one that moves otherwise.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use super::apart::Apart;
use crate::{
    index::BoundarySamples,
    measure::CurveError,
    mesh::Mesh,
    sampling::BoundarySample,
    scene::{BoundaryShape, Dimension, Scene, WallCourse, WallMotion},
    state::{
        Clock, DomainTooLarge, Execution, Failure, FailureCause, Limit, Material, PART_OF_PERIOD,
        Phase, Product, Stage,
        particle::{Boundary, BoundaryNormal, Position},
    },
};

/// Walls in motion, before anything is searched among them.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Walls],
    wanted: is_wanted,
    limits,
    ..Stage::new("move_walls", Phase::RebuildIndex, |_| {
        move_walls.into_configs()
    })
};

/// Whether a wall of the scene moves.
pub(crate) fn is_wanted(scene: &Scene) -> bool {
    let mut walls = scene.boundaries.iter();
    walls.any(|wall| wall.motion().is_some())
}

/// Part of the support radius that a wall may move in a step \[-], as the fluid of an adaptive step.
const FARTHEST: f32 = 0.4;

fn limits(scene: &Scene) -> Vec<Limit> {
    let in_plane = scene.dimension == Dimension::Two;
    let of_one = |wall: &BoundaryShape| {
        let corners = match wall.motion() {
            Some(WallMotion::Rotation { .. }) => {
                let mesh = wall.mesh(scene.spacing).and_then(Result::ok);
                let bounds = mesh.as_ref().map(Mesh::bounds);
                bounds.map(|(low, high)| [low.as_vec3(), high.as_vec3()])
            }
            _ => None,
        };
        wall.greatest_speed(in_plane, corners)
    };
    let speeds = scene.boundaries.iter().filter_map(of_one);
    let speed = speeds.fold(0.0, f32::max);
    let walls = scene.boundaries.iter();
    let periods = walls.filter_map(|wall| wall.shortest_period(scene.spacing));
    let period = periods.fold(f32::INFINITY, f32::min);
    vec![
        (
            "the speed of walls",
            FARTHEST * scene.support_radius() / speed,
        ),
        ("the period of walls", PART_OF_PERIOD * period),
    ]
}

/// Where a boundary particle was before it moved, and the course that it takes. A host that moves one changes this.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
pub struct RestPose {
    /// Index in [`MovingWalls::courses`].
    pub course: u32,
    /// \[m]
    pub position: Vec3,
    /// Unit vector from the solid into the fluid.
    pub normal: Vec3,
}

/// The walls that move.
#[derive(Resource, Debug, Clone)]
pub struct MovingWalls {
    /// Their motions; boundaries that move alike have one.
    pub(crate) courses: Vec<WallCourse>,
    /// The course of each boundary of the scene, by its number.
    of_boundary: Vec<Option<u32>>,
    /// Rows of the samples that move.
    samples: Vec<(u32, RestPose)>,
    /// What is needed for volumes, if walls move past each other.
    apart: Option<Apart>,
}

impl MovingWalls {
    /// Reads the motions of a scene; `None` if nothing moves.
    pub fn new(scene: &Scene) -> Result<Option<Self>, CurveError> {
        let mut courses: Vec<WallCourse> = Vec::new();
        let mut of_boundary = Vec::new();
        for wall in &scene.boundaries {
            let course = wall.motion().map(WallCourse::new).transpose()?;
            of_boundary.push(course.map(|course| {
                let known = courses.iter().position(|known| *known == course);
                known.unwrap_or_else(|| {
                    courses.push(course);
                    courses.len() - 1
                }) as u32
            }));
        }
        Ok((!courses.is_empty()).then_some(Self {
            courses,
            of_boundary,
            samples: Vec::new(),
            apart: None,
        }))
    }

    fn number_of(&self, boundary: u32) -> Option<u32> {
        self.of_boundary.get(boundary as usize).copied().flatten()
    }

    /// The course of a boundary, by its number in the scene; none if it stands.
    pub fn course_of(&self, boundary: u32) -> Option<&WallCourse> {
        self.courses.get(self.number_of(boundary)? as usize)
    }

    /// The pose of a sample of a boundary, by the boundary's number; none if that stands.
    pub fn pose_of(&self, boundary: u32, sample: &BoundarySample) -> Option<RestPose> {
        Some(RestPose {
            course: self.number_of(boundary)?,
            position: sample.position,
            normal: sample.normal,
        })
    }

    /// Takes the poses of all boundary particles, in the order of their rows, and where they are now \[m]. Fails if the
    /// scene's spatial index cannot cover them.
    pub(crate) fn take(
        &mut self,
        scene: &Scene,
        poses: &[Option<RestPose>],
        points: &[Vec4],
        execution: &Execution,
    ) -> Result<(), DomainTooLarge> {
        let rows = (0..).zip(poses);
        self.samples = rows
            .filter_map(|(row, pose)| pose.map(|pose| (row, pose)))
            .collect();
        let of = |(pose, point): (&Option<RestPose>, &Vec4)| match pose {
            Some(rest) => (Some(rest.course), rest.position.extend(0.0)),
            None => (None, *point),
        };
        let places: Vec<_> = poses.iter().zip(points).map(of).collect();
        self.apart = Apart::new(scene, &places, execution)?;
        Ok(())
    }

    /// Numbers in the scene of the boundaries that move in this step, and of which a sample `touches` something.
    pub(super) fn boundaries_in_motion(
        &self,
        samples: &BoundarySamples,
        touches: impl Fn(Vec4) -> bool,
    ) -> Vec<u32> {
        let mut courses = vec![false; self.courses.len()];
        for (row, rest) in &self.samples {
            let row = *row as usize;
            let known = courses[rest.course as usize];
            let moves = samples.velocity(row) != Vec3::ZERO;
            if !known && moves && touches(samples.packed[row]) {
                courses[rest.course as usize] = true;
            }
        }
        let of = |(number, course): (u32, &Option<u32>)| {
            let moves = course.is_some_and(|course| courses[course as usize]);
            moves.then_some(number)
        };
        (0..).zip(&self.of_boundary).filter_map(of).collect()
    }

    /// Puts samples where they are at the start of the step and where they are at its end. Returns the longest way
    /// \[m].
    fn put(&self, boundary: &mut BoundarySamples, material: &Material, clock: &Clock) -> f64 {
        let dt = f64::from(clock.dt);
        let poses: Vec<_> = (self.courses.iter())
            .map(|course| (course.pose(clock.time), course.pose(clock.time + dt)))
            .collect();
        let mut farthest = 0.0_f64;
        let period = material.period;
        for (row, rest) in &self.samples {
            let row = *row as usize;
            let (now, then) = &poses[rest.course as usize];
            let (from, to) = (now.place(rest.position), then.place(rest.position));
            let volume = boundary.packed[row].w;
            let here = period.wrap_exactly(from);
            boundary.packed[row] = here.as_vec3().extend(volume);
            boundary.ahead[row] = (to - (from - here)).as_vec3().extend(volume);
            boundary.velocities[row] = ((to - from) / dt).as_vec3().extend(0.0);
            boundary.normals[row] = now.turn(rest.normal);
            farthest = farthest.max(from.distance(to));
        }
        farthest
    }

    /// Every figure that the motions depend on and that is not in the scene.
    pub(crate) fn figures(&self) -> impl Iterator<Item = f64> {
        self.courses.iter().flat_map(WallCourse::figures)
    }
}

/// Puts walls where they are at the start of the step, and says where they will be at its end (phase `RebuildIndex`).
pub fn move_walls(
    mut boundary: ResMut<BoundarySamples>,
    mut failure: ResMut<Failure>,
    walls: Res<MovingWalls>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let boundary = &mut *boundary;
    boundary.ahead.clone_from(&boundary.packed);
    boundary.velocities.clear();
    boundary
        .velocities
        .resize(boundary.packed.len(), Default::default());
    let farthest = walls.put(boundary, &material, &clock);
    let (displacement, limit) = (farthest as f32, 0.5 * material.kernel.support_radius);
    // A length that is not a number is no limit kept.
    if displacement.is_nan() || displacement > limit {
        let cause = FailureCause::WallTooFast {
            displacement,
            limit,
        };
        return failure.record(cause, None);
    }
    let points = boundary.packed.len().saturating_sub(1);
    let points = &boundary.packed[..points];
    if let Err(error) = boundary.index.update(points, &execution) {
        return failure.record(FailureCause::DomainTooLarge(error), None);
    }
    if let Some(apart) = &walls.apart {
        apart.put_volumes(boundary, walls.courses.len(), &execution);
    }
}

/// Puts walls where they are at the end of a step that has become shorter since [`move_walls`].
///
/// The sums of wall velocities remain: the mean velocity of a part of a step differs by a part of its acceleration.
pub(crate) fn move_walls_less(
    boundary: Option<ResMut<BoundarySamples>>,
    walls: Option<Res<MovingWalls>>,
    material: Res<Material>,
    clock: Res<Clock>,
) {
    if let (Some(mut boundary), Some(walls)) = (boundary, walls)
        // An order may leave the motion out.
        && !boundary.velocities.is_empty()
    {
        walls.put(&mut boundary, &material, &clock);
    }
}

/// Puts the boundary particles where they are at the end of the step (phase `Integrate`, when the step is good).
pub fn show_walls(
    mut particles: Query<(&mut Position, &mut BoundaryNormal, &RestPose), With<Boundary>>,
    walls: Res<MovingWalls>,
    boundary: Res<BoundarySamples>,
    material: Res<Material>,
    clock: Res<Clock>,
) {
    // An order may leave the motion out.
    if boundary.velocities.is_empty() {
        return;
    }
    let poses: Vec<_> = (walls.courses.iter())
        .map(|course| course.pose(clock.time))
        .collect();
    for (mut position, mut normal, rest) in &mut particles {
        if let Some(pose) = poses.get(rest.course as usize) {
            let place = pose.place(rest.position);
            position.0 = material.period.wrap_exactly(place).as_vec3();
            normal.0 = pose.turn(rest.normal);
        }
    }
}

/// Puts the boundary particles of a world where they are at its time, between two steps: after its clock was set.
pub(crate) fn place_walls(world: &mut World) {
    let (Some(walls), Some(clock), Some(material)) = (
        world.get_resource::<MovingWalls>(),
        world.get_resource::<Clock>(),
        world.get_resource::<Material>(),
    ) else {
        return;
    };
    let period = material.period;
    // Before the first step all are where their shapes say.
    let poses: Vec<_> = (walls.courses.iter())
        .map(|course| course.pose(clock.time))
        .collect();
    let mut particles =
        world.query_filtered::<(&mut Position, &mut BoundaryNormal, &RestPose), With<Boundary>>();
    for (mut position, mut normal, rest) in particles.iter_mut(world) {
        if let Some(pose) = poses.get(rest.course as usize) {
            position.0 = period.wrap_exactly(pose.place(rest.position)).as_vec3();
            normal.0 = pose.turn(rest.normal);
        }
    }
}
