//! The range of a value in the last moments.

pub(super) const MILLISECOND_NS: u64 = 1_000_000;

/// From one to two of these count.
const BUCKET_NS: u64 = 25 * MILLISECOND_NS;

/// The least and the most of what was told in the last one to two buckets of time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    buckets: [[f64; 2]; 2],
    began_ns: u64,
}

impl Default for Window {
    fn default() -> Self {
        Self {
            buckets: [EMPTY; 2],
            began_ns: 0,
        }
    }
}

const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Window {
    pub(super) fn add(&mut self, value: f64, now_ns: u64) {
        if now_ns >= self.began_ns + BUCKET_NS {
            self.buckets = [self.buckets[1], EMPTY];
            self.began_ns = now_ns;
        }
        let [least, most] = &mut self.buckets[1];
        (*least, *most) = (least.min(value), most.max(value));
    }

    /// Both.
    pub(super) fn range(&self) -> [f64; 2] {
        let [before, now] = self.buckets;
        [before[0].min(now[0]), before[1].max(now[1])]
    }
}
