//! A thrown ball of fluid: no internal process moves or turns the whole.

use super::texts;
use crate::{
    scene::Scene,
    validate::{Case, Figure, Findings, Runner, Stopped, particles_of, rigid_motion},
};

pub(in crate::validate) const CASE: Case = Case {
    name: "free_flight",
    title: "A thrown, turning ball",
    texts: texts!("free_flight"),
    across: "radius",
    resolution: 5,
    resolutions: [5, 10, 20],
    sound_speed: 8.0,
    measure,
};

/// The centre compared with `x0 + v0 t + g t (t + dt)/2`, the parabola of semi-implicit Euler.
fn measure(scene: &Scene, ball: &mut Runner) -> Result<Findings, Stopped> {
    let start = rigid_motion(&particles_of(ball.world()));
    let g = scene.gravity.as_dvec3();
    let (mut path, mut velocity, mut turn) = (0.0_f64, 0.0_f64, 0.0_f64);
    ball.steps(f64::from(scene.duration), |world, report| {
        let now = rigid_motion(&particles_of(world));
        let (t, dt) = (report.time, f64::from(report.dt));
        let center = start.center + start.velocity * t + g * (0.5 * t * (t + dt));
        path = path.max((now.center - center).length());
        velocity = velocity.max((now.velocity - start.velocity - g * t).length());
        turn = turn.max((now.angular_momentum - start.angular_momentum).length());
    })?;
    let velocity = velocity / start.velocity.length();
    let turn = turn / start.angular_momentum.length();
    Ok(Findings {
        figures: vec![
            Figure::residual("off the parabola [m]", path),
            Figure::residual("velocity of the centre [v0]", velocity),
            Figure::residual("angular momentum [L0]", turn),
        ],
        comparisons: Vec::new(),
    })
}
