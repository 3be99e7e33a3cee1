//! What is measured while the scene runs.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::Bounds;
use crate::measure::{Curve, CurveError};

/// One instrument: what it measures, how often, over which time it averages, and what it is compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// Names its file, `gauges/<name>.csv`: letters, digits, `-` and `_`.
    pub name: String,
    /// What it measures.
    pub kind: GaugeKind,
    /// How often it is read.
    #[serde(default)]
    pub every: Rate,
    /// Time that its means are taken over \[s]: the last readings that began within it, each the mean over all steps
    /// since the reading before. 0 for no means.
    #[serde(default)]
    pub window: f32,
    /// A known curve that it is drawn beside.
    #[serde(default)]
    pub reference: Option<GaugeReference>,
}

/// How often a gauge is read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Rate {
    /// At the ends of the steps nearest to the multiples of a time \[s]. Steps are not shortened for it, so gauges
    /// leave the result as it is.
    Seconds(f32),
    /// After every n-th step.
    Steps(u32),
}

impl Default for Rate {
    fn default() -> Self {
        Self::Steps(1)
    }
}

/// What a gauge measures. Radii are those of the scene's kernel function, the scene's support radius if absent.
///
/// "Connected" is fluid without a gap of more than the support radius, seen along the direction of the measure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum GaugeKind {
    /// Level of the fluid in a column against gravity (along +y without gravity): the upper side, half a spacing above
    /// its centre, of the highest particle of the largest connected part \[m].
    Height {
        /// A point on the axis of the column \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        at: Vec3,
        /// Radius of the column \[m]; one spacing if absent.
        #[serde(default)]
        radius: Option<f32>,
    },
    /// How far the fluid has come along a direction: the outer side of the foremost particle of the largest connected
    /// part \[m].
    Front {
        /// Where 0 is \[m].
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        from: Vec3,
        /// Along what; any length but zero.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        direction: Vec3,
        /// Particles outside of this box do not count; all count if absent.
        #[serde(default)]
        within: Option<Bounds>,
    },
    /// Pressure at a point of the fluid \[Pa]: a linear function fitted to the particles around it, weighted by the
    /// kernel.
    Pressure {
        /// Where \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        at: Vec3,
        /// Radius of the kernel \[m].
        #[serde(default)]
        radius: Option<f32>,
    },
    /// Pressure on a wall \[Pa]: the same fit to the particles on the wall's wet side alone, 0 where it is dry.
    WallPressure {
        /// A point of the wall's face \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        at: Vec3,
        /// Direction from the wall into the fluid; any length but zero.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        normal: Vec3,
        /// Radius of the kernel \[m].
        #[serde(default)]
        radius: Option<f32>,
        /// The `name` of a boundary that the point moves with, from time 0 on; it stands if absent.
        #[serde(default)]
        boundary: Option<String>,
    },
    /// Velocity at a point \[m/s]: a linear function fitted to the particles around it, weighted by the kernel.
    Velocity {
        /// Where \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        at: Vec3,
        /// Radius of the kernel \[m].
        #[serde(default)]
        radius: Option<f32>,
    },
    /// Force \[N; N/m in 2-D] and torque \[N m; N in 2-D] of the fluid on the boundaries of a name.
    Force {
        /// The boundaries' `name`; several of one name are one body.
        boundary: String,
        /// The point that the torque is about \[m].
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        about: Vec3,
    },
    /// Volume that passes a parallelogram, in 2-D a segment, a second \[m³/s; m²/s in 2-D]. Each particle counts for
    /// its volume in all, spread over the support radius before and behind the surface.
    Flux {
        /// A corner; in 2-D an end \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        corner: Vec3,
        /// From there to the next corner; in 2-D to the other end \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        along: Vec3,
        /// From the first corner to the one on its other side \[m]; not in 2-D, where it points along z. Flow counts as
        /// positive along `along × across`.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        across: Vec3,
    },
    /// Energies of all fluid \[J; J/m in 2-D]: kinetic, potential in the scene's gravity (0 at the origin), that of
    /// compression (equations of state store some, methods that solve for the pressure none), and what the steps so
    /// far have dissipated: what they took away of the three in all, gained if negative.
    Energy,
}

/// A known curve: two columns of a CSV file, which may begin with lines of comment (`#`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GaugeReference {
    /// The file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working directory).
    pub file: String,
    /// Heading of its column of times; if absent the one that is called `t`, `T`, `time` or `tau`, perhaps with a unit
    /// after it.
    #[serde(default)]
    pub time: Option<String>,
    /// Heading of its column of figures; if absent the only other column.
    #[serde(default)]
    pub value: Option<String>,
    /// The gauge's own column that it is drawn beside; the first if absent.
    #[serde(default)]
    pub quantity: Option<String>,
    /// What the file's times and figures are multiplied by to be in SI units \[-].
    #[serde(default = "one")]
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 2]"))]
    pub scale: Vec2,
    /// What is added to them after that, in SI units.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 2]"))]
    pub offset: Vec2,
}

/// A quantity that a gauge measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// Its name, which ends in its SI unit where it has one.
    pub name: &'static str,
    /// Whether it has a mean over time.
    pub is_averaged: bool,
}

const fn mean_of(name: &'static str) -> Quantity {
    Quantity {
        name,
        is_averaged: true,
    }
}

/// Particles that speak.
const NEIGHBOURS: Quantity = Quantity {
    name: "neighbours",
    is_averaged: false,
};

impl GaugeKind {
    /// What it measures.
    pub fn quantities(&self) -> &'static [Quantity] {
        match self {
            Self::Height { .. } => const { &[mean_of("height_m")] },
            Self::Front { .. } => const { &[mean_of("front_m")] },
            Self::Pressure { .. } | Self::WallPressure { .. } => {
                const { &[mean_of("pressure_Pa"), NEIGHBOURS] }
            }
            Self::Velocity { .. } => {
                const {
                    &[
                        mean_of("velocity_x_m_per_s"),
                        mean_of("velocity_y_m_per_s"),
                        mean_of("velocity_z_m_per_s"),
                        NEIGHBOURS,
                    ]
                }
            }
            Self::Force { .. } => {
                const {
                    &[
                        mean_of("force_x_N"),
                        mean_of("force_y_N"),
                        mean_of("force_z_N"),
                        mean_of("torque_x_N_m"),
                        mean_of("torque_y_N_m"),
                        mean_of("torque_z_N_m"),
                    ]
                }
            }
            Self::Flux { .. } => const { &[mean_of("volume_flux_m3_per_s")] },
            Self::Energy => {
                const {
                    &[
                        mean_of("kinetic_energy_J"),
                        mean_of("potential_energy_J"),
                        mean_of("compression_energy_J"),
                        mean_of("dissipated_energy_J"),
                    ]
                }
            }
        }
    }
}

impl Gauge {
    /// Names of its columns: its quantities, then, with a window, `mean_…` of those that have a mean.
    pub fn columns(&self) -> Vec<String> {
        let quantities = self.kind.quantities();
        let averaged = quantities
            .iter()
            .filter(|quantity| quantity.is_averaged && self.window > 0.0);
        let now = quantities.iter().map(|quantity| quantity.name.to_owned());
        now.chain(averaged.map(|quantity| format!("mean_{}", quantity.name)))
            .collect()
    }
}

impl GaugeReference {
    /// Reads the curve, in SI units.
    pub fn load(&self) -> Result<Curve, CurveError> {
        let columns = [self.time.as_deref(), self.value.as_deref()];
        let (scale, offset) = (self.scale.as_dvec2(), self.offset.as_dvec2());
        Curve::load(self.file.as_ref(), columns, |[time, value]| {
            (scale.x * time + offset.x, scale.y * value + offset.y)
        })
    }
}

fn one() -> Vec2 {
    Vec2::ONE
}
