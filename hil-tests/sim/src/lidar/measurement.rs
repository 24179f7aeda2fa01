//! One turn's readings as SCIP writes them.

use super::codec::{data_lines, encode, summed_line};
use super::command::Section;
use crate::range_source::RANGE_STEPS;

/// Readings under this are error codes.
const FIRST_LENGTH_MM: u16 = 20;

/// A turn that has been measured.
#[derive(Debug, Clone)]
pub(super) struct Measurement {
    /// The device's timer at step 0.
    pub(super) device_ms: u32,
    pub(super) readings_mm: [u16; RANGE_STEPS],
}

impl Measurement {
    /// Appends the time stamp line, the data lines and the empty line.
    pub(super) fn write(&self, section: &Section, out: &mut Vec<u8>) {
        let mut stamp = Vec::with_capacity(4);
        encode(self.device_ms, 4, &mut stamp);
        summed_line(&stamp, out);
        data_lines(&self.data(section), out);
        out.push(b'\n');
    }

    /// The encoded readings of a section, without lines or sums.
    pub(super) fn data(&self, section: &Section) -> Vec<u8> {
        let steps = section.last_step - section.first_step + 1;
        let mut data = Vec::with_capacity(steps * section.characters as usize);
        let readings = self.readings_mm.get(section.first_step..=section.last_step);
        for cluster in readings.unwrap_or_default().chunks(section.cluster) {
            encode(u32::from(merged(cluster)), section.characters, &mut data);
        }
        data
    }
}

/// The shortest distance in a cluster. Without any, an error code that means "unknown" takes precedence over 0,
/// "nothing in sight".
fn merged(cluster: &[u16]) -> u16 {
    let lengths = cluster.iter().copied().filter(|r| *r >= FIRST_LENGTH_MM);
    let worst = cluster.iter().copied().max().unwrap_or(0);
    lengths.min().unwrap_or(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cluster_gives_its_shortest_length() {
        assert_eq!(merged(&[1000, 900, 1100]), 900);
        assert_eq!(merged(&[0, 900, 6]), 900);
        assert_eq!(merged(&[0, 6, 0]), 6);
        assert_eq!(merged(&[0, 0]), 0);
    }

    #[test]
    fn one_reading_by_hand() {
        let mut measurement = Measurement {
            device_ms: 16_000_000,
            readings_mm: [0; RANGE_STEPS],
        };
        measurement.readings_mm[44] = 1234;
        let section = Section {
            first_step: 44,
            last_step: 44,
            cluster: 1,
            characters: 2,
        };
        let mut out = Vec::new();
        measurement.write(&section, &mut out);
        // m + 2 + @ + 0 = 0x6D + 0x32 + 0x40 + 0x30 = 0x10F: 0x0F + 0x30 = '?'. C + B = 0x85: 0x05 + 0x30 = '5'.
        assert_eq!(out, b"m2@0?\nCB5\n\n");
    }
}
