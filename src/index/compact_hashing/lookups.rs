//! Look-ups remembered for the cells nearby, where cells are too small for links.
//!
//! Two cells of h/2 side by side ask for 100 of their 125 neighbours in common, and used cells that follow each other along
//! the Z-curve lie side by side: most of what a thread asks it has asked a moment ago.

use std::{
    cell::RefCell,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

use glam::IVec3;

/// Places along an axis, a power of two: more than the cells that a block of the search spans with what is around it.
const SPAN: usize = 16;

/// One answer.
#[derive(Clone, Copy)]
struct Place {
    /// The state of an index that gave it; no state has 0.
    state: u64,
    cell: IVec3,
    holder: u32,
}

thread_local! {
    static PLACES: RefCell<Vec<Place>> = const { RefCell::new(Vec::new()) };
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

/// Calls `found` with every one of `cells` and its holder, remembered or from `holder`.
#[inline(always)]
pub(super) fn each(
    state: State,
    cells: impl Iterator<Item = IVec3>,
    holder: impl Fn(IVec3) -> u32,
    mut found: impl FnMut(IVec3, u32),
) {
    PLACES.with_borrow_mut(|places| {
        if places.is_empty() {
            let nothing = Place {
                state: 0,
                cell: IVec3::ZERO,
                holder: 0,
            };
            places.resize(SPAN * SPAN * SPAN, nothing);
        }
        for cell in cells {
            let [x, y, z] = cell.to_array().map(|c| c as usize % SPAN);
            let place = &mut places[(z * SPAN + y) * SPAN + x];
            if place.state != state.0 || place.cell != cell {
                *place = Place {
                    state: state.0,
                    cell,
                    holder: holder(cell),
                };
            }
            found(cell, place.holder);
        }
    });
}
