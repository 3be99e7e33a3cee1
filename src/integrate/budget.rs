//! The energy that pressure may give the fluid, for the failure guard.
//!
//! Pressure of a fluid that keeps its volume does no work but what walls that move and emitters hand on. A solver's
//! does: it pushes out what compression it finds, and returns after an impact some of what it took. [`EnergyBudget`]
//! bounds what it gives in all over the last steps, by energies that do not depend on the length of the present step:
//! pressures that run away grow with 1/dt², and each of the shorter steps that follow looks harmless for what it found.

use serde::{Deserialize, Serialize};

/// What remains after a step of the energy that was gained before, or could be \[-]: the guard looks back about thirty
/// steps. Errors that viscosity takes away again never add up to more.
const KEPT: f64 = 0.97;

/// The same for the energy that an equation of state may return after an impact: sound crosses the fluid meanwhile.
const KEPT_BY_SPRINGS: f64 = 0.999;

/// Compression \[-] that may always be pushed out: fluid that nothing drives has no energy to compare with, and solvers
/// leave errors of this order.
const LEAST_COMPRESSION: f32 = 0.01;

/// Most by which a pressure that lasts rises in a step \[-], and the part of a higher one that counts at once.
const RISE: f32 = 1.1;
const AT_ONCE: f32 = 0.02;

/// Energies per mass, summed over particles \[m²/s²], of the last steps.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct EnergyBudget {
    /// Work that pressure did since it last took energy.
    gained: f64,
    /// Kinetic energy at that time, and what other forces, walls, emitters and a host have added since.
    given: f64,
    /// Kinetic energy at the end of the last step.
    kinetic: f64,
    /// Largest pressure \[Pa] that has lasted.
    pressure: f32,
    /// Longest of the last steps \[s].
    step: f32,
}

/// Sums over particles, for a mass of 1 each.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Work {
    /// Squares of the speeds at the start \[m²/s²].
    pub(super) speed_squared: f64,
    /// Gain of half of them, less the work of all forces but pressure: the work of pressure \[m²/s²].
    pub(super) pressure: f64,
    /// Work of those forces \[m²/s²].
    pub(super) forces: f64,
    /// Squares of what they change velocities by \[m²/s²].
    pub(super) change_squared: f64,
    /// Work of the pressure of walls that move \[m²/s²].
    pub(super) walls: f64,
}

impl Work {
    pub(super) fn add(&mut self, other: Self) {
        self.speed_squared += other.speed_squared;
        self.pressure += other.pressure;
        self.forces += other.forces;
        self.change_squared += other.change_squared;
        self.walls += other.walls;
    }
}

/// What a step did, and the state that it did it in.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepWork {
    /// Work of pressure and of other forces.
    pub(super) work: Work,
    /// Work of walls that move and of emitters \[m²/s²].
    pub(super) passed_on: f64,
    /// Kinetic energy at its end \[m²/s²].
    pub(super) kinetic: f64,
    /// Whether pressure is an equation of state, a spring that returns what it took.
    pub(super) is_elastic: bool,
    /// Number of particles.
    pub(super) rows: f64,
    /// Length \[s].
    pub(super) dt: f32,
    /// Largest pressure at its start \[Pa].
    pub(super) pressure: f32,
    /// Rest density \[kg/m³].
    pub(super) rest_density: f32,
    /// Largest compression at its start \[-].
    pub(super) compression: f32,
    /// Distance over which compression is pushed out, the support radius \[m].
    pub(super) distance: f32,
    /// Difference of potential between the highest and the lowest particle \[m²/s²].
    pub(super) heights: f64,
}

impl EnergyBudget {
    /// The budget after a step. `share` is the part of the available energies that pressure may give \[-].
    ///
    /// Fails with the work of pressure over the last steps and its limit \[m²/s²].
    pub(super) fn after(&self, step: &StepWork, share: f64) -> Result<Self, (f64, f64)> {
        let work = &step.work;
        let gained = (KEPT * self.gained + work.pressure - step.passed_on).max(0.0);
        let kinetic = 0.5 * work.speed_squared;
        let of_step = work.forces.max(0.0) + step.passed_on;
        let by_host = (kinetic - self.kinetic).max(0.0);
        let kept = if step.is_elastic {
            KEPT_BY_SPRINGS
        } else {
            KEPT
        };
        let before = kept * self.given;
        let given = if self.gained > 0.0 {
            before + by_host + of_step
        } else {
            before.max(kinetic) + of_step
        };
        let is_first = self.step == 0.0;
        let pressure = if is_first {
            step.pressure
        } else {
            (step.pressure).min(RISE * self.pressure + AT_ONCE * step.pressure)
        };
        let longest = step.dt.max(KEPT as f32 * self.step);
        let compression = step.compression.max(LEAST_COMPRESSION);
        let speed = f64::from(compression * step.distance / longest);
        let of_each = step.heights + f64::from(pressure / step.rest_density) + 0.5 * speed.powi(2);
        let returned = if step.is_elastic { given } else { 0.0 };
        let available = given + 0.5 * work.change_squared + step.rows * of_each;
        let limit = returned + share * available;
        if gained > limit {
            return Err((gained, limit));
        }
        Ok(Self {
            gained,
            given,
            kinetic: step.kinetic,
            pressure,
            step: longest,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten kilograms of water that have fallen through 0.2 m, in a step of 1 ms.
    fn falling(pressure_work: f64) -> StepWork {
        StepWork {
            work: Work {
                speed_squared: 10.0 * 2.0 * 9.81 * 0.2,
                pressure: pressure_work,
                ..Work::default()
            },
            passed_on: 0.0,
            kinetic: 10.0 * 9.81 * 0.2,
            is_elastic: false,
            rows: 10.0,
            dt: 1e-3,
            pressure: 0.0,
            rest_density: 1000.0,
            compression: 0.0,
            distance: 1e-3,
            heights: 0.2 * 9.81,
        }
    }

    /// What is available is 39 J, of motion and of height.
    #[test]
    fn pressure_gives_no_more_than_its_share_in_one_step_or_in_many() {
        let budget = EnergyBudget::default();
        assert!(budget.after(&falling(19.0), 0.5).is_ok());
        let (work, limit) = budget.after(&falling(20.0), 0.5).expect_err("too much");
        assert!((work - 20.0).abs() < 1e-9 && (limit - 19.62).abs() < 1e-2);
        let mut budget = EnergyBudget::default();
        let failed = (0..30).find(|_| match budget.after(&falling(2.0), 0.5) {
            Ok(next) => {
                budget = next;
                false
            }
            Err(_) => true,
        });
        assert!(
            failed.is_some_and(|step| (8..16).contains(&step)),
            "{failed:?}"
        );
    }

    #[test]
    fn what_compression_and_pressure_allow_does_not_grow_as_steps_shorten() {
        let long = EnergyBudget {
            step: 1e-3,
            ..EnergyBudget::default()
        };
        let mut short = falling(1000.0);
        (short.dt, short.compression, short.pressure) = (1e-6, 1.0, 1e6);
        let (_, limit) = long.after(&short, 0.5).expect_err("too much");
        assert!(limit < 130.0, "{limit}");
        short.dt = 1e-3;
        short.work.pressure = 19.0;
        assert!(long.after(&short, 0.5).is_ok());
    }

    #[test]
    fn walls_pass_on_their_work_and_springs_return_what_they_took() {
        let mut pushed = falling(1000.0);
        pushed.passed_on = 990.0;
        assert!(EnergyBudget::default().after(&pushed, 0.5).is_ok());
        let mut returned = falling(35.0);
        assert!(EnergyBudget::default().after(&returned, 0.5).is_err());
        returned.is_elastic = true;
        assert!(EnergyBudget::default().after(&returned, 0.5).is_ok());
    }

    /// Errors that viscosity takes away again are no gain.
    #[test]
    fn small_gains_of_a_long_run_do_not_add_up() {
        let mut budget = EnergyBudget::default();
        for _ in 0..10_000 {
            budget = budget.after(&falling(0.2), 0.5).expect("a small gain");
        }
    }
}
