//! Stands in for the lidar activity: scans are measured in the world, and arrive after their time on the serial line.

use coordination::symbols::Writer;
use onboard::activities::lidar::Settings;
use onboard::symbols::values::{MAX_STEPS, RangeScan};
use onboard::symbols::wiring::LidarSymbols;
use sim::world::{RANGE_STEPS, Random, RangeFinder, RangeModel, STEPS_PER_TURN, World};

/// A URG-04LX turns ten times a second.
const TURN_NS: u64 = 100_000_000;
/// The device's clock counts milliseconds: its stamps are off by up to this, by the same amount throughout a run.
const STAMP_ERROR_NS: f64 = 1e6;
/// Smaller readings are error codes, not lengths (SCIP 2.0).
const FIRST_LENGTH_MM: u16 = 20;
/// Its phase and the error of its stamps come from the seed.
const LIDAR_STREAM: u64 = 0x4C49_4441;

/// One robot's lidar, streaming from the first turn on.
pub(super) struct SteppedLidar {
    finder: RangeFinder,
    scans: Writer<RangeScan>,
    settings: Settings,
    turn_start_ns: u64,
    stamp_error_ns: i64,
    line_ns: u64,
    readings_mm: Box<[u16; RANGE_STEPS]>,
    value: Box<RangeScan>,
    /// The scan on the line: when it arrives, and its stamp.
    sent: Option<(u64, u64)>,
    turns: u64,
}

impl SteppedLidar {
    pub(super) fn new(
        world: &World,
        robot: usize,
        settings: Settings,
        symbols: LidarSymbols,
        now_ns: u64,
    ) -> Self {
        let mut random = Random::new(world.seed(), LIDAR_STREAM + robot as u64);
        let line_ns = settings.format.wire_bytes() as u64 * 10 * 1_000_000_000
            / u64::from(settings.options.bit_rate);
        Self {
            finder: RangeFinder::new(world, robot, RangeModel::default()),
            scans: symbols.scan,
            line_ns,
            settings,
            turn_start_ns: now_ns + (random.unit() * TURN_NS as f64) as u64,
            stamp_error_ns: random.symmetric(STAMP_ERROR_NS) as i64,
            readings_mm: Box::new([0; RANGE_STEPS]),
            value: Box::default(),
            sent: None,
            turns: 0,
        }
    }

    /// Does what is due; true when a scan has arrived.
    pub(super) fn cycle(&mut self, world: &World, now_ns: u64) -> bool {
        let step_ns = TURN_NS / STEPS_PER_TURN as u64;
        if now_ns >= self.turn_start_ns + step_ns * RANGE_STEPS as u64 {
            self.measure(world, now_ns);
        }
        match self.sent {
            Some((arrives_ns, stamp_ns)) if now_ns >= arrives_ns => {
                self.sent = None;
                self.value.sequence += 1;
                self.scans.write(stamp_ns, &self.value);
                true
            }
            _ => false,
        }
    }

    fn measure(&mut self, world: &World, now_ns: u64) {
        let format = &self.settings.format;
        let wanted = self.turns.is_multiple_of(u64::from(format.skip) + 1);
        if wanted {
            self.finder.capture(world, self.turn_start_ns, TURN_NS);
            self.finder.cast(&mut self.readings_mm);
            let (first, last) = (
                usize::from(format.first_step),
                usize::from(format.last_step),
            );
            let readings = self.readings_mm.get(first..=last).unwrap_or_default();
            let clusters = readings.chunks(usize::from(format.cluster.max(1)));
            let mut count = 0;
            for (value, cluster) in self.value.ranges_mm.iter_mut().zip(clusters) {
                *value = merged(cluster);
                count += 1;
            }
            self.value.count = count.min(MAX_STEPS as u64);
            let first_beam_ns = TURN_NS * u64::from(format.first_step) / STEPS_PER_TURN as u64;
            let stamp_ns =
                (self.turn_start_ns + first_beam_ns).saturating_add_signed(self.stamp_error_ns);
            self.sent = Some((now_ns + self.line_ns, stamp_ns));
        }
        self.turns += 1;
        self.turn_start_ns += TURN_NS;
    }
}

/// The shortest range of a cluster; without any, its largest error code.
fn merged(cluster: &[u16]) -> u16 {
    let lengths = cluster.iter().copied().filter(|mm| *mm >= FIRST_LENGTH_MM);
    let code = cluster.iter().copied().max().unwrap_or(0);
    lengths.min().unwrap_or(code)
}

#[cfg(test)]
mod tests {
    use super::merged;

    #[test]
    fn clusters_are_merged_as_the_sensor_does() {
        assert_eq!(merged(&[1000, 900, 1100]), 900);
        assert_eq!(merged(&[0, 900, 6]), 900);
        assert_eq!(merged(&[0, 6, 0]), 6);
    }
}
