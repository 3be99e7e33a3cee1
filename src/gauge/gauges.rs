//! The gauges of a scene, and the systems that read them.

use std::fmt;

use bevy_ecs::prelude::*;
use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    account::EnergyAccount,
    energy, flux, force,
    free::FreeVelocities,
    level,
    moment::{Moment, Probe},
    point,
    state::State,
    window::{self, Timing, Window},
};
use crate::{
    kernel::Kernel,
    scene::{self, BoundaryShape, Dimension, GaugeKind, Quantity, Scene},
    state::{Clock, Remembers, TakenBack},
    time_step::AdaptiveTimeStep,
};

/// Figures of a gauge after a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Number of the step, counted from 1.
    pub step: u64,
    /// Simulated time at its end \[s].
    pub time: f64,
    /// A figure for each of the gauge's [`columns`](Gauge::columns); `None` if there is no fluid to measure.
    pub values: Vec<Option<f64>>,
}

/// State of a gauge between steps.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Memory {
    timing: Timing,
    window: Window,
    latest: Option<Reading>,
}

/// A gauge with its readings.
pub struct Gauge {
    name: String,
    columns: Vec<String>,
    quantities: &'static [Quantity],
    probe: Box<dyn Probe>,
    /// Length of the window \[s]; 0 for none.
    window: f64,
    memory: Memory,
    /// The memory before the last step, if steps may be rolled back.
    before: Option<Memory>,
    readings: Vec<Reading>,
}

impl fmt::Debug for Gauge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut gauge = f.debug_struct("Gauge");
        gauge.field("name", &self.name);
        gauge.field("latest", &self.memory.latest);
        gauge.finish_non_exhaustive()
    }
}

/// The gauges of the scene, in its order, with their readings. The resource exists if the scene has gauges.
///
/// ```
/// use overfall::{Simulation, gauge::Gauges, scene::Scene};
///
/// let scene = r#"(
///     name: "pool",
///     spacing: 0.1,
///     bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0.5)))],
///     boundaries: [Tank(min: (0, 0, 0), max: (0.5, 1, 0.5), name: "tank")],
///     gauges: [
///         (name: "load", kind: Force(boundary: "tank")),
///         (name: "level", kind: Height(at: (0.25, 0, 0.25)), every: Seconds(0.01)),
///     ],
/// )"#;
/// let scene = Scene::parse(scene, "pool.ron", &[]).expect("a scene");
/// let mut simulation = Simulation::new(&scene).expect("threads");
/// while simulation.time() < 0.05 {
///     simulation.step().expect("a step");
/// }
/// let gauges = simulation.world().resource::<Gauges>();
/// for gauge in gauges.iter() {
///     for reading in gauge.readings() {
///         let _ = (gauge.name(), gauge.columns(), reading.time, &reading.values);
///     }
/// }
/// let level = gauges.get("level").and_then(|gauge| gauge.value("height_m"));
/// assert!((0.4..0.6).contains(&level.expect("fluid in the column")));
/// ```
#[derive(Resource, Debug)]
pub struct Gauges(Vec<Gauge>);

/// Readings that have not been taken yet are included.
impl Remembers for Gauges {
    type State = Vec<(Memory, Option<Memory>, Vec<Reading>)>;

    fn state(&self, _: &[Entity]) -> Self::State {
        let of = |gauge: &Gauge| {
            (
                gauge.memory.clone(),
                gauge.before.clone(),
                gauge.readings.clone(),
            )
        };
        self.iter().map(of).collect()
    }

    fn set_state(&mut self, state: Self::State, _: &[Entity]) -> Result<(), &'static str> {
        if state.len() != self.0.len() {
            return Err("it is of other gauges");
        }
        for (gauge, saved) in self.0.iter_mut().zip(state) {
            (gauge.memory, gauge.before, gauge.readings) = saved;
        }
        Ok(())
    }
}

impl Gauges {
    /// All gauges, in the order of the scene.
    pub fn iter(&self) -> impl Iterator<Item = &Gauge> {
        self.0.iter()
    }

    /// The gauge with a name.
    pub fn get(&self, name: &str) -> Option<&Gauge> {
        self.0.iter().find(|gauge| gauge.name == name)
    }

    /// Takes the readings up to a step, gauge by gauge in the order of the scene. Readings are kept until they are
    /// taken.
    pub fn take_readings(&mut self, up_to: u64) -> impl Iterator<Item = Vec<Reading>> {
        self.0.iter_mut().map(move |gauge| {
            let count = gauge
                .readings
                .partition_point(|reading| reading.step <= up_to);
            gauge.readings.drain(..count).collect()
        })
    }
}

impl Gauge {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of its figures, which end with their SI unit if they have one: first the current figures, then their means
    /// over the window, `mean_…`, if it has a window.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The latest reading; `None` before the first.
    pub fn latest(&self) -> Option<&Reading> {
        self.memory.latest.as_ref()
    }

    /// The latest figure of a column; `None` before the first reading, if there was no fluid to measure, or if there is
    /// no such column.
    pub fn value(&self, column: &str) -> Option<f64> {
        let column = self.columns.iter().position(|name| name == column)?;
        self.latest()?.values[column]
    }

    /// Readings since they were last taken, the oldest first.
    pub fn readings(&self) -> impl Iterator<Item = &Reading> {
        self.readings.iter()
    }

    fn new(gauge: &scene::Gauge, scene: &Scene) -> Self {
        Self {
            name: gauge.name.clone(),
            columns: gauge.columns(),
            quantities: gauge.kind.quantities(),
            probe: probe(&gauge.kind, scene),
            window: window::decimal(gauge.window),
            memory: Memory {
                timing: Timing::new(gauge.every),
                window: Window::default(),
                latest: None,
            },
            before: None,
            readings: Vec::new(),
        }
    }

    fn read(&mut self, moment: &Moment, rows: &mut Vec<u32>) {
        let clock = &moment.state.clock;
        self.before = (moment.state.adaptive.is_some()).then(|| self.memory.clone());
        let is_due = self.memory.timing.is_due(clock);
        let has_means = self.window > 0.0;
        if !is_due && !has_means {
            return;
        }
        let mut values = Vec::with_capacity(self.columns.len());
        self.probe.read(moment, rows, &mut values);
        if has_means {
            self.memory.window.add(&values, clock.dt.into());
        }
        if !is_due {
            return;
        }
        if has_means {
            let dt = clock.dt.into();
            let means = self.memory.window.close(clock.time, self.window, dt);
            let averaged = self.quantities.iter().zip(means);
            values.extend(
                averaged
                    .filter(|(quantity, _)| quantity.is_averaged)
                    .map(|(_, mean)| mean),
            );
        }
        let reading = Reading {
            step: clock.step,
            time: clock.time,
            values,
        };
        self.memory.latest = Some(reading.clone());
        self.readings.push(reading);
    }
}

/// Creates the instrument of a kind.
fn probe(kind: &GaugeKind, scene: &Scene) -> Box<dyn Probe> {
    let h = scene.support_radius();
    let around = |at: Vec3, radius: Option<f32>, side: Option<Vec3>| point::Around {
        at,
        side: side.map(Vec3::normalize_or_zero),
        kernel: Kernel::new(scene.kernel(), scene.dimension, radius.unwrap_or(h)),
    };
    match *kind {
        GaugeKind::Height { at, radius } => Box::new(level::Height {
            at,
            radius: radius.unwrap_or(scene.spacing),
        }),
        GaugeKind::Front {
            from,
            direction,
            within,
        } => Box::new(level::Front {
            from,
            direction: direction.normalize_or_zero(),
            within,
        }),
        GaugeKind::Pressure { at, radius } => Box::new(point::Pressure(around(at, radius, None))),
        GaugeKind::WallPressure {
            at,
            normal,
            radius,
            ref boundary,
        } => {
            let mut named = (0..).zip(&scene.boundaries);
            let is_it = |shape: &BoundaryShape| {
                shape
                    .name()
                    .is_some_and(|name| boundary.as_deref() == Some(name))
            };
            Box::new(point::WallPressure {
                around: around(at, radius, Some(normal)),
                boundary: named
                    .find(|(_, shape)| is_it(shape))
                    .map(|(number, _)| number),
            })
        }
        GaugeKind::Velocity { at, radius } => Box::new(point::Velocity(around(at, radius, None))),
        GaugeKind::Force {
            ref boundary,
            about,
        } => {
            let named = (0..).zip(&scene.boundaries);
            let of_name = named.filter(|(_, shape)| shape.name() == Some(boundary));
            Box::new(force::Force {
                boundaries: of_name.map(|(number, _)| number).collect(),
                about,
            })
        }
        GaugeKind::Flux {
            corner,
            along,
            across,
        } => {
            let flat = scene.dimension == Dimension::Two;
            Box::new(flux::Flux {
                corner,
                along,
                across: if flat { Vec3::Z } else { across },
                flat,
            })
        }
        GaugeKind::Energy => Box::new(energy::Energy),
    }
}

/// The last step whose readings are final: the last but one if steps may be rolled back.
pub fn settled_step(world: &World) -> u64 {
    let step = world.get_resource::<Clock>().map_or(0, |clock| clock.step);
    let may_go_back = world.contains_resource::<AdaptiveTimeStep>();
    step.saturating_sub(may_go_back.into())
}

/// Whether a scene measures forces on its boundaries.
pub(crate) fn measures_forces(scene: &Scene) -> bool {
    let is_force = |gauge: &scene::Gauge| matches!(gauge.kind, GaugeKind::Force { .. });
    scene.gauges.iter().any(is_force)
}

/// Whether a scene measures energies.
pub(crate) fn measures_energy(scene: &Scene) -> bool {
    let is_energy = |gauge: &scene::Gauge| gauge.kind == GaugeKind::Energy;
    scene.gauges.iter().any(is_energy)
}

/// Inserts the gauges of a scene, if it has some.
pub(crate) fn install(world: &mut World, scene: &Scene) {
    if scene.gauges.is_empty() {
        return;
    }
    let gauges = scene.gauges.iter().map(|gauge| Gauge::new(gauge, scene));
    world.insert_resource(Gauges(gauges.collect()));
    if measures_forces(scene) {
        world.init_resource::<FreeVelocities>();
    }
    if measures_energy(scene) {
        world.init_resource::<EnergyAccount>();
    }
}

/// Gauges that a thread reads at a time.
const AT_A_TIME: usize = 8;

/// Reads the gauges that are due (phase `Observe`, if the step succeeded), each on one thread.
pub(crate) fn read_gauges(mut gauges: ResMut<Gauges>, state: State, mut rows: Local<Vec<u32>>) {
    let moment = Moment::new(&state);
    if gauges.0.len() <= AT_A_TIME {
        for gauge in &mut gauges.0 {
            gauge.read(&moment, &mut rows);
        }
        return;
    }
    state.execution.install(|| {
        gauges.0.par_chunks_mut(AT_A_TIME).for_each(|gauges| {
            let mut rows = Vec::new();
            for gauge in gauges {
                gauge.read(&moment, &mut rows);
            }
        });
    });
}

/// Removes the readings of steps that were rolled back (phase `Observe`, if steps may be).
pub(crate) fn go_back(
    mut gauges: ResMut<Gauges>,
    energy: Option<ResMut<EnergyAccount>>,
    adaptive: Res<AdaptiveTimeStep>,
    clock: Res<Clock>,
) {
    // The step that failed was never read; the one before it was.
    let good = |taken: &TakenBack| taken.steps > 1;
    if !adaptive.taken_back.as_ref().is_some_and(good) {
        return;
    }
    for gauge in &mut gauges.0 {
        if let Some(before) = gauge.before.take() {
            gauge.memory = before;
        }
        let is_taken = |reading: &Reading| reading.step > clock.step;
        while gauge.readings.pop_if(|reading| is_taken(reading)).is_some() {}
    }
    if let Some(mut energy) = energy {
        energy.go_back();
    }
}
