//! The pressure methods that cases are run with.

/// A pressure method with its default parameters.
#[derive(Debug, Clone, Copy)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// Its name on the command line.
    pub key: &'static str,
    /// The method in a scene, as RON. SESPH and δ-SPH take a speed of sound \[m/s]: ten times the largest speed
    /// expected allows 1 % of compression.
    pub pressure: fn(sound_speed: f32) -> String,
}

/// Every pressure method.
pub const METHODS: [Method; 6] = [
    Method {
        name: "SESPH, gas",
        key: "sesph-gas",
        pressure: |c| format!("Sesph(equation: Gas(stiffness: {}))", c * c),
    },
    Method {
        name: "SESPH, Tait",
        key: "sesph-tait",
        pressure: |c| format!("Sesph(equation: Tait(stiffness: {}))", 1000.0 * c * c / 7.0),
    },
    Method {
        name: "PCISPH",
        key: "pcisph",
        pressure: |_| "Pcisph()".to_owned(),
    },
    Method {
        name: "IISPH",
        key: "iisph",
        pressure: |_| "Iisph()".to_owned(),
    },
    Method {
        name: "DFSPH",
        key: "dfsph",
        pressure: |_| "Dfsph()".to_owned(),
    },
    Method {
        name: "δ-SPH",
        key: "delta-sph",
        pressure: |_| "DeltaSph()".to_owned(),
    },
];
