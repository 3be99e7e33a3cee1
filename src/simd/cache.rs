//! Hints to the cache.

/// Hints that `place` will be used soon, so that several distant cache lines are fetched at a time.
#[inline(always)]
pub(crate) fn prefetch<T>(place: &T) {
    #[cfg(target_arch = "x86_64")]
    super::x86::prefetch(place);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
