//! Energies of all fluid.

use super::{
    account::EnergyAccount,
    moment::{Moment, Probe},
};

/// All energies of the fluid.
pub(super) struct Energy;

impl Probe for Energy {
    fn read(&self, moment: &Moment, _: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let motion = &moment.state.motion;
        let account = moment.state.energy.as_deref();
        values.extend([
            Some(motion.kinetic_energy),
            Some(motion.potential_energy),
            account.map(EnergyAccount::compression),
            account.map(EnergyAccount::dissipated),
        ]);
    }
}
