//! How long a computation takes: the least of a few repeats after a warm-up. The only clock below the command line; no result depends on it.

use std::time::{Duration, Instant};

use super::accuracy::Depth;

/// How often a computation is repeated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Repeats after the warm-up, at most.
    pub repeats: usize,
    /// … and so long in all: what takes longer is timed once more at least, or not at all where there are no repeats.
    pub patience: Duration,
}

impl Clock {
    /// Once where a look is quick; else so often that what disturbs a computation of milliseconds does not disturb all of its repeats.
    pub fn of(depth: Depth) -> Self {
        match depth {
            Depth::Quick => Clock { repeats: 0, patience: Duration::ZERO },
            Depth::Usual => Clock { repeats: 5, patience: Duration::from_millis(150) },
            Depth::Full => Clock { repeats: 20, patience: Duration::from_secs(1) },
        }
    }

    /// What `compute` returns, and its seconds.
    pub fn time<T>(&self, compute: impl Fn() -> T) -> (T, f64) {
        let begun = Instant::now();
        let result = compute();
        let mut least = begun.elapsed();
        for _ in 0..self.repeats {
            if self.patience < begun.elapsed() {
                break;
            }
            let again = Instant::now();
            std::hint::black_box(compute());
            least = least.min(again.elapsed());
        }
        (result, least.as_secs_f64())
    }
}
