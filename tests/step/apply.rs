//! Changes of a scene while it runs.

use overfall::{ApplyError, Override, Simulation, checkpoint::Checkpoint, scene::Scene};

const SCENE: &str = r#"(
    name: "changing",
    dimension: 2,
    spacing: 0.05,
    fluid: (viscosity: Laminar(kinematic_viscosity: 1e-3)),
    bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))],
    boundaries: [Tank(min: (0, 0, 0), max: (1, 1, 0), slip: NoSlip)],
)"#;

fn set(texts: &[&str]) -> Vec<Override> {
    texts
        .iter()
        .map(|text| Override::parse(text).expect("an override"))
        .collect()
}

fn start(overrides: &[&str]) -> Simulation {
    let scene =
        Scene::parse(SCENE, "s.ron", &set(overrides)).unwrap_or_else(|error| panic!("{error}"));
    Simulation::with_threads(&scene, 1).unwrap_or_else(|error| panic!("{error}"))
}

/// A change before the first step makes the run that the changed scene is, to the bit, for every thing that may change.
#[test]
fn a_changed_run_is_that_of_the_changed_scene() {
    for changes in [
        &["gravity=(1, -1.62, 0)"][..],
        &["fluid.viscosity.kinematic_viscosity=0.02"],
        &[
            "pressure.max_density_error=0.01",
            "pressure.max_divergence_error=0.02",
        ],
        &[
            "pressure.min_iterations=5",
            "pressure.max_divergence_iterations=3",
        ],
        &["limits.compression=0.5"],
        &["output.frames_per_second=7", "duration=9"],
        &["time_step.max=0.0004"],
    ] {
        let (mut whole, mut changed) = (start(changes), start(&[]));
        changed
            .apply(&set(changes))
            .unwrap_or_else(|error| panic!("{changes:?}: {error}"));
        assert_eq!(whole.scene(), changed.scene(), "{changes:?}");
        for _ in 0..12 {
            let [a, b] = [&mut whole, &mut changed].map(|run| run.step().expect("a step"));
            // The first step was chosen before: gravity alone lets it differ.
            assert_eq!(
                (a.time, a.kinetic_energy),
                (b.time, b.kinetic_energy),
                "{changes:?}"
            );
        }
    }
    for (kind, change) in [
        ("time_step=Fixed(0.001)", "time_step=Fixed(0.0005)"),
        ("time_step=Adaptive(max: 0.01)", "time_step.max=0.0002"),
    ] {
        let mut run = start(&[kind]);
        run.step().expect("a step");
        run.apply(&set(&[change]))
            .unwrap_or_else(|error| panic!("{change}: {error}"));
        let report = run.step().expect("a step");
        assert!(report.dt <= 0.0005, "{change}: {}", report.dt);
    }
}

#[test]
fn what_is_fixed_is_refused_and_the_run_goes_on() {
    let (mut run, mut other) = (start(&[]), start(&[]));
    for changes in [
        &["spacing=0.1"][..],
        &["bodies=[]"],
        &["dimension=3"],
        &["fluid.rest_density=800"],
        &["fluid.viscosity=None"],
        &["fluid.viscosity.numerical=0"],
        &["pressure=Iisph"],
        &["pressure.momentum=false"],
        &["time_step=Fixed(0.001)"],
        &["index.structure=UniformGrid"],
        &["boundaries=[]"],
        &["gravity=(0, -5, 0)", "name=other"],
        &["domain=(min: (-1, -1, 0), max: (2, 2, 0))"],
    ] {
        let error = run.apply(&set(changes)).expect_err("refused");
        let path = changes
            .last()
            .and_then(|change| change.split('=').next())
            .expect("a path");
        assert!(
            matches!(error, ApplyError::Fixed { .. }),
            "{changes:?}: {error}"
        );
        let text = error.to_string();
        assert!(
            text.contains(&format!("`{path}` cannot change")) && text.contains("gravity"),
            "{text}"
        );
    }
    for changes in [
        &["gravity=(0, 0, 1)"][..],
        &["gravity=3"],
        &["limits.energy=-1"],
        &["nothing=1"],
    ] {
        let error = run.apply(&set(changes)).expect_err("refused");
        assert!(
            matches!(error, ApplyError::Scene(_)),
            "{changes:?}: {error}"
        );
    }
    assert_eq!(run.scene(), other.scene());
    let [a, b] = [&mut run, &mut other].map(|run| run.step().expect("a step"));
    assert_eq!((a.dt, a.kinetic_energy), (b.dt, b.kinetic_energy));
    let mut gauged = start(&["gauges=[(name: \"level\", kind: Height(at: (0.2, 0, 0)))]"]);
    let error = gauged
        .apply(&set(&["gravity=(1, 0, 0)"]))
        .expect_err("refused")
        .to_string();
    assert!(error.contains("`Height` gauge"), "{error}");
    gauged
        .apply(&set(&["gravity=(0, -1, 0)"]))
        .expect("the same direction");
}

/// A checkpoint after a change holds the changed scene, and goes on with it.
#[test]
fn a_checkpoint_holds_the_changed_scene() {
    let mut run = start(&[]);
    for _ in 0..3 {
        run.step().expect("a step");
    }
    run.apply(&set(&[
        "gravity=(0, 2, 0)",
        "pressure.max_density_error=0.001",
    ]))
    .expect("changes");
    run.step().expect("a step");
    let checkpoint = Checkpoint::of(run.world_mut()).expect("a checkpoint");
    let scene = checkpoint.scene().expect("a scene");
    assert_eq!(Some(&scene), run.scene());
    let mut resumed = Simulation::with_threads(&scene, 2).expect("a scene that runs");
    checkpoint
        .restore(resumed.world_mut())
        .expect("the same run");
    for _ in 0..5 {
        let [a, b] = [&mut run, &mut resumed].map(|run| run.step().expect("a step"));
        assert_eq!((a.time, a.kinetic_energy), (b.time, b.kinetic_energy));
    }
}
