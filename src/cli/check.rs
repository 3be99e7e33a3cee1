//! `overfall check`: describes what a run of the scene would do.

use std::fmt::Write;

use glam::Vec3;
use overfall::Plan;
use overfall::lattice::Lattice;
use overfall::scene::{Cfl, Outside, PressureMethod, Rate, Scene, TimeStep, Viscosity, WallSlip};
use overfall::step::Product;

use super::checkpoints::Resumed;
use super::exit::{Exit, Failure};
use super::folder::RunFolder;
use super::waiting::waiting;
use super::{check_memory, console, cost, options, plan_json};

/// Prints the plan of a scene.
pub(super) fn check(asked: &options::Check) -> Result<Exit, Failure> {
    let options = &asked.run;
    let quiet = options.reporting.quiet;
    let scene = waiting("reading the scene", quiet, || options.effective_scene())?;
    if let Some(resumed) = &options.resume {
        Resumed::read(resumed)?;
    }
    let plan = waiting("counting", quiet, || overfall::output::memory::plan(&scene));
    let plan = plan.map_err(|error| options.scene.refuse(&error))?;
    let threads = options.scene.threads();
    let cost = match asked.cost {
        true => Some(cost::measure(&scene, asked)?),
        false => None,
    };
    console::print(&if options.reporting.json {
        let cost = cost.map(|cost| cost::json(&plan, &cost, asked.error));
        plan_json::text(&scene, &plan, threads, cost)?
    } else {
        let cost = cost.map(|cost| cost::text(&plan, &cost, asked.error));
        text(&scene, &plan, threads, options) + &cost.unwrap_or_default()
    })?;
    Ok(Exit::Done)
}

/// The axes along which space repeats.
fn periodic(scene: &Scene) -> Option<String> {
    let axes = ["x", "y", "z"].into_iter().zip(scene.periodic.axes());
    let faces = |(name, faces): (&str, Option<[f32; 2]>)| {
        faces.map(|[low, high]| format!("{name} from {low} to {high} m"))
    };
    let axes: Vec<_> = axes.filter_map(faces).collect();
    (!axes.is_empty()).then(|| axes.join(", "))
}

fn text(scene: &Scene, plan: &Plan, threads: usize, options: &options::Run) -> String {
    let mut text = format!("{}: the scene is fine\n", console::name(&scene.name));
    let rows = [
        (
            "particles",
            format!(
                "{} fluid, {}{} boundary",
                plan.particles,
                if plan.boundary_is_estimate {
                    "about "
                } else {
                    ""
                },
                plan.boundary_particles
            ),
        ),
        ("fluid", extent(plan.fluid_box)),
        ("all", extent(plan.whole_box)),
        ("method", method(scene)),
        ("dimension", u8::from(scene.dimension).to_string()),
        ("spacing", format!("{} m", scene.spacing)),
        ("support radius", format!("{} m", plan.support_radius)),
        ("particle mass", format!("{:.4e} kg", plan.particle_mass)),
        (
            "neighbours",
            format!(
                "about {:.0} per particle inside the fluid",
                plan.expected_neighbours
            ),
        ),
        ("density", density(plan)),
        (
            "duration",
            match options.steps {
                Some(steps) => format!("{steps} steps, whatever their time"),
                None => format!(
                    "{} s, about {} steps at the limits below",
                    scene.duration,
                    plan.expected_steps.ceil()
                ),
            },
        ),
        ("threads", threads.to_string()),
        ("output", output(scene, options)),
    ];
    let periodic = periodic(scene).map(|axes| ("periodic", axes));
    let viscosity = viscosity(scene).map(|share| ("viscosity", share));
    for (name, value) in rows.into_iter().chain(periodic).chain(viscosity) {
        // Writing to a String cannot fail, here and below.
        let _ = writeln!(text, "  {name:<15} {value}");
    }
    text.push_str(&phases(plan));
    if scene.order.is_some() {
        text.push_str(&flow(plan));
    }
    text.push_str(&flow_of_fluid(scene, plan));
    text.push_str(&motions(scene));
    text.push_str(&gauges(scene));
    text.push_str(&time_step(scene, plan));
    text.push_str(&check_memory::text(scene, plan));
    for warning in &plan.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    text
}

/// What the sums of the viscosity show of it, in a scene with a laminar one.
fn viscosity(scene: &Scene) -> Option<String> {
    let Viscosity::Laminar { .. } = scene.fluid.viscosity else {
        return None;
    };
    let share = Lattice::of(scene).shear_viscosity();
    Some(format!(
        "sums over a sheared lattice have {share:.2} of it, and are divided by that"
    ))
}

/// Corners in six digits: the seventh and more of single precision are rounding.
fn extent(corners: (Vec3, Vec3)) -> String {
    let short = |x: f32| format!("{x:.5e}").parse().unwrap_or(x);
    let [low, high] = [corners.0, corners.1].map(|corner| corner.to_array().map(short));
    format!(
        "from ({}, {}, {}) to ({}, {}, {}) m",
        low[0], low[1], low[2], high[0], high[1], high[2]
    )
}

/// The pressure method with all its parameters.
fn method(scene: &Scene) -> String {
    let PressureMethod::DeltaSph(method) = &scene.pressure else {
        return written(&scene.pressure);
    };
    let speed = method.sound_speed_in(scene);
    written(&scene.pressure) + &format!(", speed of sound {speed:.4} m/s")
}

/// A value in the notation of a scene file.
fn written(value: &impl serde::Serialize) -> String {
    let options = ron::Options::default()
        .with_default_extension(ron::extensions::Extensions::UNWRAP_VARIANT_NEWTYPES)
        .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    let text = options.to_string(value).unwrap_or_default();
    text.replace(',', ", ").replace(':', ": ")
}

/// Fluid that enters and leaves: emitters with what they add, boxes that remove, and the domain if it does.
fn flow_of_fluid(scene: &Scene, plan: &Plan) -> String {
    let mut text = String::new();
    if !scene.emitters.is_empty() {
        text.push_str("\nFluid that enters\n");
    }
    let unit = match u8::from(scene.dimension) {
        2 => "m²/s",
        _ => "m³/s",
    };
    for (index, (emitter, planned)) in scene.emitters.iter().zip(&plan.emitters).enumerate() {
        let name = format!("emitters.{index}");
        let _ = writeln!(text, "  {name:<15} {}", console::name(&written(emitter)));
        let _ = writeln!(
            text,
            "  {:<15} {:.4e} {unit} in layers of {} particles {:.4e} m apart, {} of them behind the face",
            "", planned.flow, planned.layer, planned.pitch, planned.waiting
        );
        let _ = writeln!(
            text,
            "  {:<15} {} particles until {} s",
            "", planned.particles, scene.duration
        );
    }
    let removes = scene.outside == Outside::Remove;
    if removes || !scene.outflow.is_empty() {
        text.push_str("\nFluid that leaves\n");
    }
    for (index, bounds) in scene.outflow.iter().enumerate() {
        let name = format!("outflow.{index}");
        let _ = writeln!(text, "  {name:<15} {}", extent((bounds.min, bounds.max)));
    }
    if let Some(domain) = scene.domain.filter(|_| removes) {
        let outside = extent((domain.min, domain.max));
        let _ = writeln!(text, "  {:<15} not {outside}", "outside");
    }
    text
}

/// What moves or drives beside gravity: fields of velocities at the start, body forces, walls in motion.
fn motions(scene: &Scene) -> String {
    let mut text = String::new();
    let mut row = |heading: &str, name: &str, value: &str| {
        if !text.contains(heading) {
            let _ = writeln!(text, "\n{heading}");
        }
        let _ = writeln!(text, "  {name:<15} {}", console::name(value));
    };
    for (index, body) in scene.bodies.iter().enumerate() {
        if let Some(field) = &body.velocity_field {
            let name = format!("bodies.{index}");
            row("Velocities at the start", &name, &written(field));
        }
    }
    for (index, force) in scene.body_forces.iter().enumerate() {
        let name = format!("body_forces.{index}");
        row("Forces beside gravity", &name, &written(force));
    }
    for (index, wall) in scene.boundaries.iter().enumerate() {
        if let Some(motion) = wall.motion() {
            let number = format!("boundaries.{index}");
            let name = wall.name().map_or(number, str::to_owned);
            row(
                "Walls in motion",
                console::name(&name).as_ref(),
                &written(motion),
            );
        }
    }
    for (index, wall) in scene.boundaries.iter().enumerate() {
        if wall.slip() != WallSlip::Free {
            let number = format!("boundaries.{index}");
            let name = wall.name().map_or(number, str::to_owned);
            row(
                "Walls that hold the fluid",
                console::name(&name).as_ref(),
                &written(&wall.slip()),
            );
        }
    }
    text
}

/// The gauges: what they measure, how often, and the columns of their files.
fn gauges(scene: &Scene) -> String {
    let mut text = String::new();
    if !scene.gauges.is_empty() {
        text.push_str("\nGauges\n");
    }
    for gauge in &scene.gauges {
        let rate = match gauge.every {
            Rate::Steps(1) => "every step".to_owned(),
            Rate::Steps(steps) => format!("every {steps} steps"),
            Rate::Seconds(seconds) => format!("every {seconds} s"),
        };
        let window = match gauge.window {
            0.0 => String::new(),
            window => format!(", means over {window} s"),
        };
        let reference = gauge.reference.as_ref();
        let reference = reference.map_or_else(String::new, |known| {
            format!(", beside {}", console::name(&known.file))
        });
        let kind = console::name(&written(&gauge.kind)).to_string();
        let _ = writeln!(
            text,
            "  {:<15} {kind}, {rate}{window}{reference}",
            gauge.name
        );
        let columns = gauge.columns().join(", ");
        let _ = writeln!(text, "  {:<15} {columns}", "");
    }
    text
}

/// Where a run would write, and what.
fn output(scene: &Scene, options: &options::Run) -> String {
    let folder = RunFolder::new(options.out.as_deref(), &scene.name);
    let formats: Vec<_> = (scene.output.formats.iter())
        .map(|format| format.extension())
        .collect();
    let mut kinds = formats.join(", ");
    if kinds.is_empty() {
        kinds.push_str("no files of frames");
    }
    if scene.output.pictures {
        kinds.push_str(", pictures");
    }
    let rate = scene.output.frames_per_second;
    format!(
        "{} ({kinds}), {rate} frames per second",
        console::name(&folder.root().display().to_string())
    )
}

/// The compression of the fluid at the start.
fn density(plan: &Plan) -> String {
    match plan.start_density {
        None => "not computed: sampling the meshes would take too much time and memory for a check"
            .to_owned(),
        Some(start) => format!(
            "at t = 0 up to {:.2} % above rest, at ({:.4}, {:.4}, {:.4}) m; {:.3} % on average",
            100.0 * start.max_error,
            start.place.x,
            start.place.y,
            start.place.z,
            100.0 * start.mean_error
        ),
    }
}

fn phases(plan: &Plan) -> String {
    let mut text = "\nA step\n".to_owned();
    for (phase, systems) in &plan.phases {
        let systems = match systems.as_slice() {
            [] => "-".to_owned(),
            systems => systems.join(", "),
        };
        let _ = writeln!(text, "  {:<15} {systems}", phase.name());
    }
    text
}

/// The data flow: what every stage of an order reads and writes, and how old that may be.
fn flow(plan: &Plan) -> String {
    let mut text = "\nData flow\n".to_owned();
    for stage in &plan.flow {
        let read = |(product, age): &(Product, u64)| match age {
            0 => product.to_string(),
            1 => format!("{product} (1 step old at most)"),
            age => format!("{product} ({age} steps old at most)"),
        };
        let list = |items: Vec<String>| {
            if items.is_empty() {
                "-".to_owned()
            } else {
                items.join(", ")
            }
        };
        let reads = list(stage.reads.iter().map(read).collect());
        let writes = list(stage.writes.iter().map(Product::to_string).collect());
        let every = match stage.every {
            1 => String::new(),
            every => format!(", every {every} steps"),
        };
        let _ = writeln!(
            text,
            "  {:<15} reads {reads}; writes {writes}{every}",
            stage.stage
        );
    }
    text
}

fn time_step(scene: &Scene, plan: &Plan) -> String {
    let mut text = match scene.time_step {
        TimeStep::Fixed(dt) => format!("\nThe time step is {dt:e} s; it should be at most\n"),
        TimeStep::Cfl(Cfl { min, max, .. }) => {
            format!("\nThe time step is from {min:e} to {max:e} s, and at most\n")
        }
        TimeStep::Adaptive(scheme) => format!(
            "\nThe time step is from {:e} to {:e} s; steps are taken back where the largest density error jumps by \
             {:.1} % or is above {:.1} %\nIt shrinks above\n",
            scheme.min,
            scheme.max,
            800.0 * scheme.density_error,
            100.0 * scheme.max_density_error,
        ),
        _ => "\nThe time step should be at most\n".to_owned(),
    };
    for (name, limit) in &plan.time_step_limits {
        let limit = if limit.is_finite() {
            format!("{limit:.3e} s")
        } else {
            "no limit".to_owned()
        };
        let _ = writeln!(text, "  {limit:<12} {name}");
    }
    text
}
