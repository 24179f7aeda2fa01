//! What stops must do, whatever the policy: from the sections of the drive and the lidar.

use description::keys::KeyError;

/// How the robot stops, and when for want of scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopRules {
    /// The deceleration that a stop can count on, `drive.stop_deceleration_m_s2`.
    pub deceleration_m_s2: f64,
    /// Without a valid scan for this long the robot stops, `lidar.scan_timeout_ms`.
    pub scan_timeout_s: f64,
    /// After that, and at start, scans must be good for this long, `lidar.good_scans_s`.
    pub good_scans_s: f64,
}

impl Default for StopRules {
    /// The platform of 0.4 m × 0.3 m.
    fn default() -> Self {
        Self {
            deceleration_m_s2: 2.0,
            scan_timeout_s: 0.25,
            good_scans_s: 2.0,
        }
    }
}

impl StopRules {
    pub(super) fn check(&self) -> Result<(), KeyError> {
        for (key, found, least, most) in [
            (
                "drive.stop_deceleration_m_s2",
                self.deceleration_m_s2,
                0.05,
                20.0,
            ),
            (
                "lidar.scan_timeout_ms",
                self.scan_timeout_s * 1e3,
                20.0,
                5000.0,
            ),
            ("lidar.good_scans_s", self.good_scans_s, 0.0, 60.0),
        ] {
            if !(least..=most).contains(&found) {
                let expected = format!("{least} to {most}");
                return Err(KeyError::new(key, format!("{found:?}"), expected));
            }
        }
        Ok(())
    }
}
