//! Hints to the cache.

/// Hints that `place` is about to be used, so that many places far from each other are fetched at a time.
#[inline(always)]
pub(crate) fn prefetch<T>(place: &T) {
    #[cfg(target_arch = "x86_64")]
    super::x86::prefetch(place);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
