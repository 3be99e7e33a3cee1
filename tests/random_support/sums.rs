//! Sums over all pairs of particles in f64: checks the reports of a step without an index, lists or lanes.

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3, Vec4};
use overfall::{
    Phase, Simulation, Step,
    index::BoundarySamples,
    pressure::implicit::Iterates,
    sampling::beside_wall,
    scene::{BoundaryHandling, Dimension, PressureMethod, Scene, StateEquation, SurfaceTension},
    state::{
        Accelerations, Clock, Densities, Material, Positions, PredictedPositions,
        PressureAccelerations, Velocities,
    },
};

/// Tolerance of densities in single precision \[-].
const ROUNDING: f64 = 1e-6;

/// The columns at the end of the pressure phase.
#[derive(Resource, Debug, Clone, Default)]
pub(crate) struct Columns {
    pub(crate) dt: f64,
    positions: Vec<DVec3>,
    predicted: Vec<DVec3>,
    velocities: Vec<DVec3>,
    densities: Vec<f32>,
    /// Accelerations of pressure, and the terms p/ρ² whose they are, of methods that solve a linear system.
    pub(crate) pressure: Vec<(DVec3, f64)>,
}

/// Makes every step copy its columns.
pub(crate) fn watch(simulation: &mut Simulation) {
    fn take(
        mut out: ResMut<Columns>,
        clock: Res<Clock>,
        positions: Res<Positions>,
        predicted: Res<PredictedPositions>,
        velocities: Res<Velocities>,
        densities: Res<Densities>,
        forces: (Res<Accelerations>, Res<PressureAccelerations>),
        terms: Option<Res<Iterates>>,
    ) {
        let rows = positions.rows();
        let points = |column: &[Vec4]| -> Vec<DVec3> {
            let rows = column[..rows].iter();
            rows.map(|x| x.truncate().as_dvec3()).collect()
        };
        let dt = f64::from(clock.dt);
        let force = |row: usize| (forces.0[row] + forces.1[row]).as_dvec3();
        let terms = terms.iter().flat_map(|terms| terms.acted());
        let pressure = terms.zip(forces.1.iter());
        let velocities = points(&velocities).into_iter().enumerate();
        *out = Columns {
            dt,
            positions: points(&positions),
            predicted: points(&predicted),
            velocities: velocities.map(|(row, v)| v + dt * force(row)).collect(),
            densities: densities.to_vec(),
            pressure: pressure
                .map(|(term, a)| (a.as_dvec3(), term.into()))
                .collect(),
        };
    }
    let world = simulation.world_mut();
    world.init_resource::<Columns>();
    world.schedule_scope(Step, |_, step| {
        step.add_systems(take.after(Phase::Pressure).before(Phase::Integrate));
    });
}

/// The cubic spline as in Monaghan 1992, with support h.
#[derive(Debug, Clone, Copy)]
struct Kernel {
    h: f64,
    sigma: f64,
}

impl Kernel {
    fn new(scene: &Scene) -> Self {
        let h = f64::from(scene.support()) * f64::from(scene.spacing);
        let sigma = match scene.dimension {
            Dimension::Two => 40.0 / (7.0 * std::f64::consts::PI * h * h),
            Dimension::Three => 8.0 / (std::f64::consts::PI * h * h * h),
        };
        Self { h, sigma }
    }

    fn value(self, r: f64) -> f64 {
        let q = r / self.h;
        self.sigma
            * match q {
                0.0..0.5 => 6.0 * (q.powi(3) - q.powi(2)) + 1.0,
                0.5..1.0 => 2.0 * (1.0 - q).powi(3),
                _ => 0.0,
            }
    }

    /// W′(r)/r.
    fn slope(self, r: f64) -> f64 {
        let q = r / self.h;
        let derivative = match q {
            0.0..0.5 => 6.0 * (3.0 * q * q - 2.0 * q),
            0.5..1.0 => -6.0 * (1.0 - q).powi(2),
            _ => 0.0,
        };
        if r > 0.0 {
            self.sigma * derivative / (self.h * r)
        } else {
            0.0
        }
    }
}

/// The fluid's constants, and the walls.
pub(crate) struct BruteForce {
    kernel: Kernel,
    /// Mass of a particle \[kg; kg/m in 2-D].
    pub(crate) mass: f64,
    rest_density: f64,
    walls: Vec<(DVec3, f64)>,
    push: f64,
}

/// Results.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    /// Largest difference from the engine's density, divided by the rest density.
    pub(crate) density: f64,
    /// Largest and mean remaining compression.
    pub(crate) largest: f64,
    pub(crate) mean: f64,
}

impl BruteForce {
    /// Sums for a scene in its simulation, and the largest difference of wall volumes from their definition.
    pub(crate) fn new(scene: &Scene, simulation: &Simulation) -> (Self, f64) {
        let material = *simulation.world().resource::<Material>();
        let kernel = Kernel::new(scene);
        let samples = simulation.world().get_resource::<BoundarySamples>();
        let points = samples.map_or(&[][..], |samples| samples.points());
        let walls: Vec<(DVec3, f64)> = points
            .iter()
            .map(|x| (x.truncate().as_dvec3(), f64::from(x.w)))
            .collect();
        let found = Self {
            kernel,
            mass: material.particle_mass.into(),
            rest_density: material.rest_density.into(),
            push: beside_wall(scene).push.into(),
            walls,
        };
        let worst = found.wrong_volume(scene);
        (found, worst)
    }

    fn wrong_volume(&self, scene: &Scene) -> f64 {
        let spacing = scene.spacing;
        let layer: f64 = overfall::kernel::Kernel::of(scene)
            .lattice(scene.dimension, spacing)
            .filter(|x: &Vec3| x.y.abs() < 0.5 * spacing)
            .map(|x| self.kernel.value(x.length().into()))
            .sum();
        let wrong = self.walls.iter().map(|(x, volume)| {
            let others = self.walls.iter();
            let sum: f64 = others.map(|(y, _)| self.kernel.value(x.distance(*y))).sum();
            let wanted = match scene.boundary_handling() {
                BoundaryHandling::Akinci | BoundaryHandling::Extrapolated => 1.0 / sum,
                BoundaryHandling::DirectForcing(_) => {
                    self.mass / self.rest_density * (layer / sum).min(1.0)
                }
                other => panic!("what is the volume of a wall with {other:?}?"),
            };
            (volume / wanted - 1.0).abs()
        });
        wrong.fold(0.0, f64::max)
    }

    /// All values that a step should have reported.
    pub(crate) fn errors(&self, scene: &Scene, columns: &Columns, stabilised: bool) -> Errors {
        let Columns {
            positions,
            predicted,
            velocities,
            pressure,
            ..
        } = columns;
        let rows = positions.len();
        let share = match scene.pressure {
            PressureMethod::Iisph(of) if stabilised => of.stabilisation.into(),
            PressureMethod::Dfsph(of) if stabilised => of.stabilisation.into(),
            _ => 0.0,
        };
        let stabilisation = |i: usize, j: usize, x: DVec3| {
            let [(a_i, t_i), (a_j, t_j)] = [pressure[i], pressure[j]];
            share * columns.dt * (2.0 * self.rest_density * (t_i - t_j) + (a_i + a_j).dot(x))
        };
        let own = self.mass * self.kernel.value(0.0);
        let (mut density, mut rate, mut after) =
            (vec![own; rows], vec![0.0; rows], vec![own; rows]);
        let h_squared = self.kernel.h * self.kernel.h;
        for i in 0..rows {
            for j in 0..i {
                let x = positions[i] - positions[j];
                if x.length_squared() > h_squared {
                    continue;
                }
                let r = x.length();
                let value = self.mass * self.kernel.value(r);
                let slope = self.mass * self.kernel.slope(r);
                let change = slope * x.dot(velocities[i] - velocities[j]);
                if share > 0.0 {
                    rate[i] += slope * stabilisation(i, j, x);
                    rate[j] += slope * stabilisation(j, i, -x);
                }
                let later = self.mass * self.kernel.value(predicted[i].distance(predicted[j]));
                for k in [i, j] {
                    density[k] += value;
                    rate[k] += change;
                    after[k] += later;
                }
            }
            for &(wall, volume) in &self.walls {
                let x = positions[i] - wall;
                if x.length_squared() > h_squared {
                    continue;
                }
                let r = x.length();
                let share = self.rest_density * volume;
                density[i] += share * self.kernel.value(r);
                rate[i] += self.push * share * self.kernel.slope(r) * x.dot(velocities[i]);
                after[i] += share * self.kernel.value(predicted[i].distance(wall));
            }
        }
        let remaining = |row: usize| match scene.pressure {
            PressureMethod::Sesph(_) | PressureMethod::DeltaSph(_) => density[row],
            PressureMethod::Pcisph(_) => after[row],
            PressureMethod::Iisph(_) | PressureMethod::Dfsph(_) => {
                density[row] + columns.dt * rate[row]
            }
            other => panic!("which density remains with {other:?}?"),
        };
        let errors = || (0..rows).map(|row| (remaining(row) / self.rest_density - 1.0).max(0.0));
        let differs = |row: usize| (density[row] - f64::from(columns.densities[row])).abs();
        Errors {
            density: (0..rows).map(differs).fold(0.0, f64::max) / self.rest_density,
            largest: errors().fold(0.0, f64::max),
            mean: errors().sum::<f64>() / rows.max(1) as f64,
        }
    }

    /// Total energy of positions and velocities \[J; J/m in 2-D]: kinetic and potential energy, cohesion, and the
    /// energy stored by an equation of state.
    pub(crate) fn energy(
        &self,
        scene: &Scene,
        particles: &mut dyn Iterator<Item = (DVec3, DVec3)>,
    ) -> f64 {
        let particles: Vec<_> = particles.collect();
        let gravity = scene.gravity.as_dvec3();
        let of_one = |(x, v): &(DVec3, DVec3)| 0.5 * v.length_squared() - gravity.dot(*x);
        let mut energy: f64 = particles.iter().map(of_one).sum();
        let cohesion = Cohesion::new(scene, self.kernel);
        let mut density = vec![self.mass * self.kernel.value(0.0); particles.len()];
        for i in 0..particles.len() {
            for j in 0..i {
                let square = particles[i].0.distance_squared(particles[j].0);
                if square < self.kernel.h * self.kernel.h {
                    let r = square.sqrt();
                    energy += cohesion.energy(r);
                    let value = self.mass * self.kernel.value(r);
                    density[i] += value;
                    density[j] += value;
                }
            }
            for &(wall, volume) in &self.walls {
                let r = particles[i].0.distance(wall);
                density[i] += self.rest_density * volume * self.kernel.value(r);
            }
        }
        if let PressureMethod::Sesph(sesph) = scene.pressure {
            let stored = density
                .iter()
                .map(|rho| stored(sesph.equation, *rho, self.rest_density));
            energy += stored.sum::<f64>();
        }
        self.mass * energy
    }

    /// Energy of the speeds that remove the initial compression within one step \[J; J/m in 2-D].
    pub(crate) fn pushed_out(&self, columns: &Columns) -> f64 {
        let speed = |rho: &f32| {
            let compression = (f64::from(*rho) / self.rest_density - 1.0).max(ROUNDING);
            compression * self.kernel.h / columns.dt
        };
        let squares = columns.densities.iter().map(|rho| speed(rho).powi(2));
        0.5 * self.mass * squares.sum::<f64>()
    }

    /// Energy of a particle at a distance from the origin \[m] whose density is affected by rounding \[J; J/m in 2-D].
    fn rounding(&self, scene: &Scene, farthest: f64) -> f64 {
        let PressureMethod::Sesph(sesph) = scene.pressure else {
            return 0.0;
        };
        // Coordinates far from the origin have larger rounding errors, and so have densities.
        let off = ROUNDING + f64::from(f32::EPSILON) * farthest / f64::from(scene.spacing);
        let density = (1.0 + 10.0 * off) * self.rest_density;
        self.mass * stored(sesph.equation, density, self.rest_density)
    }

    /// Reference for a rise of energy: initial kinetic and potential energy, and stored energy \[J; J/m in 2-D].
    pub(crate) fn energy_scale(
        &self,
        scene: &Scene,
        particles: &mut dyn Iterator<Item = (DVec3, DVec3)>,
    ) -> f64 {
        let particles: Vec<_> = particles.collect();
        let gravity = scene.gravity.as_dvec3();
        let heights = particles.iter().map(|(x, _)| gravity.dot(*x));
        let (low, high) = heights
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
                (low.min(height), high.max(height))
            });
        let least = gravity.length() * f64::from(scene.spacing);
        let kinetic: f64 = particles
            .iter()
            .map(|(_, v)| 0.5 * v.length_squared())
            .sum();
        let still = self.energy(scene, &mut particles.iter().map(|(x, _)| (*x, DVec3::ZERO)));
        let potential: f64 = particles.iter().map(|(x, _)| -gravity.dot(*x)).sum();
        let farthest = particles
            .iter()
            .map(|(x, _)| x.length())
            .fold(0.0, f64::max);
        let rounding = self.rounding(scene, farthest) * particles.len() as f64;
        let other = (still - self.mass * potential).abs() + rounding;
        self.mass * (kinetic + particles.len() as f64 * (high - low + least)) + other
    }
}

/// `∫ p/ρ² dρ` from the rest density, over positive p \[J/kg].
fn stored(equation: StateEquation, density: f64, rest: f64) -> f64 {
    if density <= rest {
        return 0.0;
    }
    match equation {
        StateEquation::Tait { stiffness } => {
            let part = |rho: f64| rho.powi(6) / (6.0 * rest.powi(7)) + 1.0 / rho;
            f64::from(stiffness) * (part(density) - part(rest))
        }
        StateEquation::Gas { stiffness } => {
            let part = |rho: f64| rho.ln() + rest / rho;
            f64::from(stiffness) * (part(density) - part(rest))
        }
        other => panic!("what energy is in {other:?}?"),
    }
}

/// Energy of an attracting pair over its distance: the integral of κ r W(max(r, spacing)), by the trapezium rule.
struct Cohesion {
    table: Vec<f64>,
    step: f64,
}

impl Cohesion {
    fn new(scene: &Scene, kernel: Kernel) -> Self {
        let count = 400;
        let step = kernel.h / f64::from(count);
        let SurfaceTension::BeckerTeschner { kappa } = scene.fluid.surface_tension else {
            return Self {
                table: Vec::new(),
                step,
            };
        };
        let pull = |k: i32| {
            let r = f64::from(k) * step;
            f64::from(kappa) * r * kernel.value(r.max(scene.spacing.into()))
        };
        let mut table = vec![0.0; count as usize + 2];
        for k in (0..count).rev() {
            table[k as usize] = table[k as usize + 1] - 0.5 * step * (pull(k) + pull(k + 1));
        }
        Self { table, step }
    }

    fn energy(&self, r: f64) -> f64 {
        let at = r / self.step;
        let k = at.floor() as usize;
        match self.table.get(k..k + 2) {
            Some([a, b]) => a + (at - k as f64) * (b - a),
            _ => 0.0,
        }
    }
}
