//! The plugin in a headless bevy `App`.

use std::time::Duration;

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use overfall::{
    FluidPlugin, FluidStatus, FluidStopped, Pace,
    scene::{Scene, TimeStep},
    step::Clock,
    uninstall,
};

use super::orders::unordered;
use crate::common::{bits, bits_after};

fn time(app: &App) -> f64 {
    app.world().resource::<Clock>().time
}

#[test]
fn the_fluid_keeps_up_with_the_fixed_update() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, FluidPlugin::new(unordered())));
    let frame = Duration::from_millis(7);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    for _ in 0..12 {
        app.update();
    }
    let fixed = app.world().resource::<Time<Fixed>>().elapsed_secs_f64();
    assert!(fixed > 0.05);
    assert!(
        (0.0..2.1e-4).contains(&(fixed - time(&app))),
        "{fixed}, {}",
        time(&app)
    );
    let steps = app.world().resource::<Clock>().step as usize;
    assert!(bits(app.world_mut()) == bits_after(&unordered(), 2, steps));
}

#[test]
fn the_host_chooses_schedule_and_pace() {
    for (pace, steps) in [(Pace::Step, 6), (Pace::Seconds(1e-3), 30)] {
        let mut app = App::new();
        let plugin = FluidPlugin::new(unordered()).in_schedule(Update);
        app.add_plugins(plugin.at_pace(pace));
        for _ in 0..6 {
            app.update();
        }
        assert_eq!(app.world().resource::<Clock>().step, steps);
        assert!(matches!(app.world().resource(), FluidStatus::Running(_)));
    }
}

#[derive(Resource, Default)]
struct Told(Vec<String>);

fn app(scene: Scene, pace: Pace) -> App {
    let mut app = App::new();
    app.init_resource::<Told>();
    app.add_observer(|stopped: On<FluidStopped>, mut told: ResMut<Told>| {
        told.0.push(stopped.reason.clone());
    });
    app.add_plugins(FluidPlugin::new(scene).in_schedule(Update).at_pace(pace));
    app
}

#[test]
fn what_goes_wrong_is_told_once_and_the_app_goes_on() {
    let told = |app: &App| app.world().resource::<Told>().0.clone();
    // No scene.
    let mut no_scene = app(Scene::new("", -1.0), Pace::Step);
    no_scene.update();
    assert_eq!(told(&no_scene).len(), 1);
    assert!(matches!(
        no_scene.world().resource(),
        FluidStatus::NotInstalled(_)
    ));
    // No clock.
    let mut no_time = app(unordered(), Pace::Time);
    (0..3).for_each(|_| no_time.update());
    assert!(told(&no_time).len() == 1 && told(&no_time)[0].contains("TimePlugin"));
    // A failing step; then the level restarts.
    let scene = Scene {
        time_step: TimeStep::Fixed(1e-3),
        ..unordered()
    };
    let mut fails = app(scene.clone(), Pace::Step);
    fails.update();
    fails.world_mut().resource_mut::<Clock>().next_dt = -1.0;
    (0..3).for_each(|_| fails.update());
    assert_eq!(told(&fails).len(), 1);
    assert!(matches!(fails.world().resource(), FluidStatus::Stopped(_)));
    uninstall(fails.world_mut()).expect("a scene");
    fails.update();
    assert!(matches!(fails.world().resource(), FluidStatus::Waiting));
    overfall::install(fails.world_mut(), &scene).expect("a scene");
    (0..2).for_each(|_| fails.update());
    assert_eq!((time(&fails) * 1e3).round(), 2.0);
    assert_eq!(told(&fails).len(), 1);
}

#[cfg(feature = "bevy_reflect")]
#[test]
fn components_are_reflected() {
    use bevy_app::FixedUpdate;
    use bevy_ecs::reflect::ReflectComponent;
    use overfall::particle::{Position, Velocity};

    let mut app = App::new();
    app.add_plugins(FluidPlugin::new(unordered()).in_schedule(FixedUpdate));
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    for id in [
        std::any::TypeId::of::<Position>(),
        std::any::TypeId::of::<Velocity>(),
    ] {
        assert!(registry.get_type_data::<ReflectComponent>(id).is_some());
    }
}
