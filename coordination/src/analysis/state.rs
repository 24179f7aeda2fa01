//! One state of a closed net in a few words: marking, positions of protocols, waiting events.

use crate::protocol::Position;

/// Where the parts of a state lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    positions_at: usize,
    waiting_at: usize,
    /// Words in a state.
    pub(super) words: usize,
}

impl Layout {
    pub(super) fn new(places: usize, protocols: usize, counted_sources: usize) -> Self {
        let positions_at = places.div_ceil(64);
        let waiting_at = positions_at + protocols.div_ceil(4);
        Self {
            positions_at,
            waiting_at,
            words: (waiting_at + counted_sources.div_ceil(8)).max(1),
        }
    }

    pub(super) fn is_marked(self, state: &[u64], place: u32) -> bool {
        state[place as usize / 64] >> (place % 64) & 1 == 1
    }

    pub(super) fn mark(self, state: &mut [u64], place: u32) {
        state[place as usize / 64] |= 1 << (place % 64);
    }

    pub(super) fn clear(self, state: &mut [u64], place: u32) {
        state[place as usize / 64] &= !(1 << (place % 64));
    }

    /// The words of the marking.
    pub(super) fn marking(self, state: &[u64]) -> &[u64] {
        &state[..self.positions_at]
    }

    pub(super) fn position(self, state: &[u64], protocol: usize) -> u16 {
        (state[self.positions_at + protocol / 4] >> (protocol % 4 * 16)) as u16
    }

    pub(super) fn set_position(self, state: &mut [u64], protocol: usize, position: Position) {
        let word = &mut state[self.positions_at + protocol / 4];
        let shift = protocol % 4 * 16;
        *word = *word & !(0xFFFF << shift) | (position.index() as u64) << shift;
    }

    pub(super) fn waiting(self, state: &[u64], counter: usize) -> u8 {
        (state[self.waiting_at + counter / 8] >> (counter % 8 * 8)) as u8
    }

    pub(super) fn set_waiting(self, state: &mut [u64], counter: usize, count: u8) {
        let word = &mut state[self.waiting_at + counter / 8];
        let shift = counter % 8 * 8;
        *word = *word & !(0xFF << shift) | u64::from(count) << shift;
    }

    /// Whether no more than `most` events wait for any source.
    #[cfg(feature = "symbolic")]
    pub(super) fn waits_at_most(self, state: &[u64], most: u8) -> bool {
        let counts = state[self.waiting_at..]
            .iter()
            .flat_map(|word| word.to_le_bytes());
        counts.max().unwrap_or(0) <= most
    }

    pub(super) fn nothing_waits(self, state: &[u64]) -> bool {
        state[self.waiting_at..].iter().all(|&word| word == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::ProtocolModel;

    #[test]
    fn parts_of_a_state_do_not_touch_each_other() {
        let mut model = ProtocolModel::new("p", "a", "b");
        let names: Vec<String> = (0..300).map(|number| format!("f{number}")).collect();
        let entries: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "a")).collect();
        model.array("all", &entries);
        let positions: Vec<Position> = model.compile().unwrap().positions().collect();

        let layout = Layout::new(65, 5, 9);
        assert_eq!(layout.words, 2 + 2 + 2);
        let mut state = vec![0; layout.words];
        layout.mark(&mut state, 0);
        layout.mark(&mut state, 64);
        for protocol in 0..5 {
            layout.set_position(&mut state, protocol, positions[290 + protocol]);
        }
        for counter in 0..9 {
            layout.set_waiting(&mut state, counter, 250 + counter as u8 % 5);
        }
        layout.set_waiting(&mut state, 3, 1);
        layout.set_position(&mut state, 2, positions[1]);
        layout.clear(&mut state, 0);
        assert!(!layout.is_marked(&state, 0) && layout.is_marked(&state, 64));
        assert_eq!(layout.position(&state, 2), 1);
        assert_eq!(layout.position(&state, 4), 294);
        assert_eq!(
            (layout.waiting(&state, 3), layout.waiting(&state, 8)),
            (1, 253)
        );
        assert!(!layout.nothing_waits(&state));
    }
}
