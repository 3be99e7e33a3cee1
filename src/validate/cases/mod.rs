//! The cases: measurements of each, and their references.

pub(super) mod cavity;
pub(super) mod dam_break;
pub(super) mod elliptic_drop;
pub(super) mod free_flight;
pub(super) mod hydrostatic;
pub(super) mod manufactured;
pub(super) mod oscillating_drop;
pub(super) mod plates;
pub(super) mod rotating_patch;
pub(super) mod spheric_2;
pub(super) mod standing_wave;
pub(super) mod taylor_green;
pub(super) mod wave_maker;

use super::figure::at;
use crate::{measure::Curve, validate::Stopped};

/// Two columns of a compiled reference file, converted to SI by `to_si`.
fn reference(
    text: &str,
    columns: [&str; 2],
    to_si: impl Fn([f64; 2]) -> (f64, f64),
) -> Result<Curve, Stopped> {
    let columns = columns.map(Some);
    Curve::parse(text, "assets/reference".as_ref(), columns, to_si)
        .map_err(|error| Stopped::Refused(error.to_string()))
}

/// A case's scene and page, from its folder.
macro_rules! texts {
    ($name:literal) => {
        (
            include_str!(concat!("../../../assets/cases/", $name, "/scene.ron")),
            include_str!(concat!("../../../assets/cases/", $name, "/page.md")),
        )
    };
}
use texts;
