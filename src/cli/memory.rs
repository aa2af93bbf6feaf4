//! How much memory the program keeps for later.

/// Has all threads share two heaps.
///
/// The allocator of the GNU system gives every thread its own, and in each lies idle what another thread has freed: a tenth of the peak of a report. A report is
/// made of few large pieces, so that the sharing costs no time; a batch of fits is not, and keeps its heaps.
pub fn share_heaps() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: sets a parameter of the allocator; it may be called at any time, and a refusal changes nothing.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 2);
    }
}
