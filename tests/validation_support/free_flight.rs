//! A thrown ball of fluid: nothing within it moves or turns the whole.

use overfall::{Simulation, scene::Scene};

use super::{Case, Figure};
use crate::support::{particles_of, rigid_motion, run};

pub(crate) const CASE: Case = Case {
    scene: "free_flight",
    sound_speed: 8.0,
    measure,
};

/// The centre against `x0 + v0 t + g t (t + dt)/2`, the parabola of semi-implicit Euler.
fn measure(scene: &Scene, ball: &mut Simulation) -> Vec<Figure> {
    let start = rigid_motion(&particles_of(ball));
    let g = scene.gravity.as_dvec3();
    let (mut path, mut velocity, mut turn) = (0.0_f64, 0.0_f64, 0.0_f64);
    run(ball, f64::from(scene.duration), |ball, report| {
        let now = rigid_motion(&particles_of(ball));
        let (t, dt) = (report.time, f64::from(report.dt));
        let center = start.center + start.velocity * t + g * (0.5 * t * (t + dt));
        path = path.max((now.center - center).length());
        velocity = velocity.max((now.velocity - start.velocity - g * t).length());
        turn = turn.max((now.angular_momentum - start.angular_momentum).length());
    });
    vec![
        Figure::residual("off the parabola [m]", path),
        Figure::residual(
            "velocity of the centre [v0]",
            velocity / start.velocity.length(),
        ),
        Figure::residual(
            "angular momentum [L0]",
            turn / start.angular_momentum.length(),
        ),
    ]
}
