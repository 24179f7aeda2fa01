//! The process data watchdog (ETG.1000.4 section 6.3): whether the MainDevice has written the outputs in time.

/// One tick of the undivided clock.
const TICK_NS: u64 = 40;

/// Watchdog of the outputs' SyncManager.
#[derive(Debug, Clone, Default)]
pub struct Watchdog {
    fed_ns: Option<u64>,
    // Its time is 0.
    off: bool,
    expired: bool,
    expirations: u8,
}

/// The time after which the watchdog expires; `None` when it is switched off.
#[must_use]
pub fn timeout_ns(divider: u16, time: u16) -> Option<u64> {
    (time > 0).then(|| (u64::from(divider) + 2) * TICK_NS * u64::from(time))
}

impl Watchdog {
    /// Starts or restarts the time: called on every complete write.
    pub fn feed(&mut self, now_ns: u64) {
        self.fed_ns = Some(now_ns);
        self.expired = false;
    }

    /// Stops waiting.
    pub fn stop(&mut self) {
        self.fed_ns = None;
    }

    /// Its time or divider was written. While it is off it has not expired, and when it is switched on the time begins.
    pub fn set(&mut self, timeout_ns: Option<u64>, now_ns: u64) {
        let was_off = std::mem::replace(&mut self.off, timeout_ns.is_none());
        if self.off {
            self.expired = false;
        } else if was_off && let Some(fed_ns) = &mut self.fed_ns {
            *fed_ns = now_ns;
        }
    }

    /// Looks at the clock; true once, when the watchdog expires.
    pub fn check(&mut self, now_ns: u64, timeout_ns: Option<u64>) -> bool {
        let (Some(fed_ns), Some(timeout_ns)) = (self.fed_ns, timeout_ns) else {
            return false;
        };
        if self.expired || now_ns.saturating_sub(fed_ns) <= timeout_ns {
            return false;
        }
        self.expired = true;
        self.expirations = self.expirations.saturating_add(1);
        true
    }

    /// Not expired, never started, or off.
    #[must_use]
    pub fn is_ok(&self) -> bool {
        !self.expired
    }

    /// How often it expired since the counter was cleared; stays at 255.
    #[must_use]
    pub fn expirations(&self) -> u8 {
        self.expirations
    }

    /// Clears the counter.
    pub fn clear_expirations(&mut self) {
        self.expirations = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn defaults_mean_100_ms() {
        assert_eq!(timeout_ns(0x09C2, 1000), Some(100 * MS));
        assert_eq!(timeout_ns(0x09C2, 0), None);
        assert!(timeout_ns(u16::MAX, u16::MAX).is_some());
    }

    #[test]
    fn expires_once_until_fed_again() {
        let mut dog = Watchdog::default();
        let timeout = Some(100 * MS);
        assert!(!dog.check(1000 * MS, timeout), "not started");
        dog.feed(1000 * MS);
        assert!(!dog.check(1100 * MS, timeout));
        assert!(dog.check(1101 * MS, timeout));
        assert!(!dog.check(1102 * MS, timeout));
        assert!(!dog.is_ok());
        dog.feed(1200 * MS);
        assert!(dog.is_ok());
        assert!(!dog.check(9000 * MS, None), "switched off");
        dog.stop();
        assert!(!dog.check(9000 * MS, timeout));
        assert_eq!(dog.expirations(), 1);
    }
}
