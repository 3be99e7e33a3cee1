//! Why a scene is refused, and where.

use std::fmt;
use std::path::PathBuf;

/// A scene that cannot be read or makes no sense. Its message names the place, what is wrong and what would be right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot read the scene: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The text is no scene: RON's grammar, an unknown field, a value of another type.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: Place,
        /// What is wrong and what would be right.
        message: String,
    },
    /// The scene can be read but cannot be simulated.
    #[error("{place}: {message}")]
    Invalid {
        /// Where.
        place: Place,
        /// Path of the field concerned, as `--set` takes it.
        field: String,
        /// What is wrong and what would be right.
        message: String,
    },
}

/// The place an error speaks of.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// In a scene file.
    File {
        /// The file's name, as the caller gave it.
        file: String,
        /// From 1.
        line: usize,
        /// In characters, from 1.
        column: usize,
    },
    /// In an override, as the caller wrote it.
    Override(String),
    /// In a scene that was built in code: path of the field.
    Field(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { file, line, column } => write!(f, "{file}:{line}:{column}"),
            Self::Override(text) => write!(f, "--set {text}"),
            Self::Field(path) => f.write_str(path),
        }
    }
}

/// The message for a name that nobody knows: the nearest known one, and all of them.
pub(crate) fn unknown_name(what: &str, found: &str, of: Option<&str>, known: &[&str]) -> String {
    let of = of.map_or_else(String::new, |of| format!(" in `{of}`"));
    let list = known.join(", ");
    let is_dynamic = matches!(found, "mu" | "eta" | "dynamic_viscosity");
    if is_dynamic && known.contains(&"kinematic_viscosity") {
        return format!(
            "unknown {what} `{found}`{of}; did you mean `kinematic_viscosity`, the dynamic one divided by the density? \
             ({what}s: {list})"
        );
    }
    if let Some(hint) = elsewhere(&found.to_lowercase(), known) {
        return format!("unknown {what} `{found}`{of}: {hint} ({what}s: {list})");
    }
    match nearest(found, known) {
        Some(near) => {
            format!("unknown {what} `{found}`{of}; did you mean `{near}`? ({what}s: {list})")
        }
        None if known.is_empty() => format!("unknown {what} `{found}`{of}; there are none"),
        None => format!("unknown {what} `{found}`{of} ({what}s: {list})"),
    }
}

/// Where what people look for here is instead.
pub(crate) fn elsewhere(found: &str, known: &[&str]) -> Option<&'static str> {
    let are = |names: &[&str]| names.iter().all(|name| known.contains(name));
    let is_count = matches!(
        found,
        "threads" | "num_threads" | "n_threads" | "cores" | "cpus"
    );
    let is_even = matches!(found, "constant" | "uniform" | "gravity" | "acceleration");
    if is_count && are(&["executor", "duration"]) {
        Some("the number of threads is an option of the command, `--threads 4`")
    } else if is_even && are(&["Central", "Wave"]) {
        Some("an acceleration that is the same everywhere is added to `gravity`")
    } else {
        None
    }
}

/// Words of other programs and of formulas, and what they are called here.
const SYNONYMS: [(&str, &str); 65] = [
    ("density", "rest_density"),
    ("rho", "rest_density"),
    ("rho0", "rest_density"),
    ("nu", "kinematic_viscosity"),
    ("t_end", "duration"),
    ("tend", "duration"),
    ("t_max", "duration"),
    ("end_time", "duration"),
    ("simulation_time", "duration"),
    ("dt", "time_step"),
    ("dx", "spacing"),
    ("dp", "spacing"),
    ("particle_spacing", "spacing"),
    ("particle_size", "spacing"),
    ("h", "support"),
    ("smoothing_length", "support"),
    ("fps", "frames_per_second"),
    ("g", "gravity"),
    ("walls", "boundaries"),
    ("solver", "pressure"),
    ("tolerance", "max_density_error"),
    ("position", "at"),
    ("velocity", "speed"),
    ("omega", "angular_velocity"),
    ("wcsph", "Sesph"),
    ("tait", "Sesph"),
    ("eos", "Sesph"),
    ("isph", "Iisph"),
    ("hashing", "CompactHashing"),
    ("disc", "Sphere"),
    ("circle", "Disc"),
    ("circle", "Sphere"),
    ("ball", "Sphere"),
    ("cube", "Box"),
    ("delete", "Remove"),
    ("lists", "Stored"),
    ("list", "Stored"),
    ("grid", "UniformGrid"),
    ("body", "bodies"),
    ("obstacles", "boundaries"),
    ("colliders", "boundaries"),
    ("solids", "boundaries"),
    ("inflow", "emitters"),
    ("inlets", "emitters"),
    ("inlet", "emitters"),
    ("sources", "emitters"),
    ("outlets", "outflow"),
    ("outlet", "outflow"),
    ("drain", "outflow"),
    ("drains", "outflow"),
    ("sinks", "outflow"),
    ("probes", "gauges"),
    ("sensors", "gauges"),
    ("cfl", "time_step"),
    ("type", "kind"),
    ("path", "file"),
    ("filename", "file"),
    ("from", "start"),
    ("to", "end"),
    ("direction", "normal"),
    ("interval", "every"),
    ("seconds", "Time"),
    ("translation", "Velocity"),
    ("sine", "Oscillation"),
    ("slit", "Rectangle"),
];

/// The known name of what other programs call `found`.
pub(crate) fn known_as<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let synonyms = SYNONYMS.iter().filter(|(word, _)| *word == found);
    let mut meant = synonyms.flat_map(|(_, name)| known.iter().find(|known| *known == name));
    meant.next().copied()
}

/// The known name nearest to `found`, if one is near enough to be meant.
fn nearest<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let found = found.to_lowercase();
    if let Some(name) = known_as(&found, known) {
        return Some(name);
    }
    // Of equally near names the first.
    known
        .iter()
        .rev()
        .map(|&name| {
            let lower = name.to_lowercase();
            let mut likeness = strsim::jaro_winkler(&found, &lower);
            // `max_error` for `max_density_error`: a part of the words is as good as a typo.
            if found
                .split('_')
                .all(|word| lower.split('_').any(|other| other == word))
            {
                likeness = likeness.max(0.95);
            }
            (likeness, name)
        })
        .filter(|&(likeness, _)| likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
