//! The list of all cases.

use super::{
    Case,
    cases::{
        cavity, dam_break, elliptic_drop, free_flight, hydrostatic, manufactured, oscillating_drop,
        plates, rotating_patch, spheric_2, standing_wave, taylor_green, wave_maker,
    },
};

/// Every case, the least expensive first.
pub const CASES: [&Case; 17] = [
    &hydrostatic::IN_THE_PLANE,
    &hydrostatic::IN_SPACE,
    &free_flight::CASE,
    &elliptic_drop::CASE,
    &rotating_patch::CASE,
    &dam_break::KOSHIZUKA_OKA,
    &dam_break::MARTIN_MOYCE,
    &standing_wave::INVISCID,
    &standing_wave::VISCOUS,
    &plates::POISEUILLE,
    &plates::COUETTE,
    &taylor_green::CASE,
    &manufactured::CASE,
    &oscillating_drop::CASE,
    &wave_maker::CASE,
    &spheric_2::CASE,
    &cavity::CASE,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::METHODS;

    #[test]
    fn every_case_has_a_scene_at_its_resolutions_with_every_method() {
        for case in CASES {
            assert!(case.resolutions.contains(&case.resolution), "{}", case.name);
            assert!(
                case.resolutions.windows(2).all(|r| r[1] == 2 * r[0]),
                "{}",
                case.name
            );
            for method in &METHODS {
                for resolution in case.resolutions {
                    let scene = case.scene(method, resolution);
                    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
                    assert_eq!(scene.name, case.name);
                }
            }
        }
    }
}
