//! The list of all cases, and of those that are not supported yet.

use super::{
    Case,
    cases::{
        dam_break, elliptic_drop, free_flight, hydrostatic, rotating_patch, spheric_2,
        standing_wave,
    },
};

/// Every supported case, the least expensive first.
pub const CASES: [&Case; 10] = [
    &hydrostatic::IN_THE_PLANE,
    &hydrostatic::IN_SPACE,
    &free_flight::CASE,
    &elliptic_drop::CASE,
    &rotating_patch::CASE,
    &dam_break::KOSHIZUKA_OKA,
    &dam_break::MARTIN_MOYCE,
    &standing_wave::INVISCID,
    &standing_wave::VISCOUS,
    &spheric_2::CASE,
];

/// A case that is not supported yet.
#[derive(Debug)]
pub struct Waiting {
    /// Its name.
    pub name: &'static str,
    /// What a scene would need for it.
    pub needs: &'static str,
}

/// Cases with known answers that a scene cannot express yet.
pub const WAITING: [Waiting; 7] = [
    Waiting {
        name: "oscillating_drop",
        needs: "its measures: a scene can pose it with a central force (Monaghan & Rafiee 2013)",
    },
    Waiting {
        name: "taylor_green",
        needs: "periodic axes",
    },
    Waiting {
        name: "poiseuille",
        needs: "periodic axes and no-slip walls (Morris et al. 1997)",
    },
    Waiting {
        name: "couette",
        needs: "periodic axes and a wall that moves and holds the fluid (Morris et al. 1997)",
    },
    Waiting {
        name: "lid_driven_cavity",
        needs: "its measures: a scene can pose it with a no-slip wall in motion (Ghia et al. 1982)",
    },
    Waiting {
        name: "wave_maker",
        needs: "its measures: a scene can pose it with a piston in motion",
    },
    Waiting {
        name: "manufactured_solution",
        needs: "periodic axes and forces that vary in space and time",
    },
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
            let known = WAITING.iter().any(|waiting| waiting.name == case.name);
            assert!(!known, "{} waits for nothing", case.name);
        }
    }
}
