//! Look-ups of a hash table, remembered for the cells nearby.
//!
//! Two cells side by side ask for 18 of their 27 neighbours in common, and used cells that follow each other along the
//! Z-curve lie side by side: most of what a thread asks it has asked a moment ago. What it heard stands in 512 places in
//! the first cache, by the lowest bits of the coordinates, where the table and the list of used cells would be fetched from
//! further away, a line for each of 27 cells. Links from every used cell to its neighbours would do as much, at 108
//! bytes a cell and with every coming and going of a cell to be told to 26 others.

use std::{
    cell::RefCell,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

use glam::IVec3;

use super::Run;

/// Places along an axis, a power of two: more than the cells that a block of the search spans with what is around it.
const SPAN: usize = 8;

/// What a thread remembers.
struct Lookups {
    places: Vec<Place>,
}

/// One answer.
#[derive(Clone, Copy)]
struct Place {
    /// The state of an index that gave it; no state has 0.
    state: u64,
    cell: IVec3,
    run: Run,
}

thread_local! {
    static LOOKUPS: RefCell<Lookups> = const { RefCell::new(Lookups { places: Vec::new() }) };
}

/// Names a state of an index: what was remembered of another does not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct State(u64);

impl State {
    /// A state unlike all before, of this index and of others.
    pub(super) fn new() -> Self {
        static LAST: AtomicU64 = AtomicU64::new(0);
        Self(LAST.fetch_add(1, Relaxed) + 1)
    }
}

/// Calls `found` with the run of every one of `cells`, remembered or from `look_up`.
///
/// What is not known is looked up at once. To gather it first, so that the loads of several look-ups overlap, took longer.
#[inline(always)]
pub(super) fn each(
    state: State,
    cells: impl Iterator<Item = IVec3>,
    look_up: impl Fn(IVec3) -> Run,
    mut found: impl FnMut(Run),
) {
    LOOKUPS.with_borrow_mut(|lookups| {
        if lookups.places.is_empty() {
            let nothing = Place {
                state: 0,
                cell: IVec3::ZERO,
                run: Run { start: 0, len: 0 },
            };
            lookups.places.resize(SPAN * SPAN * SPAN, nothing);
        }
        for cell in cells {
            let [x, y, z] = cell.to_array().map(|c| c as usize % SPAN);
            let place = &mut lookups.places[(z * SPAN + y) * SPAN + x];
            if place.state != state.0 || place.cell != cell {
                *place = Place {
                    state: state.0,
                    cell,
                    run: look_up(cell),
                };
            }
            found(place.run);
        }
    });
}
