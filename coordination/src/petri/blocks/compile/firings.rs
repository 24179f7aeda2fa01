//! What a firing changes beside the local conditions of its block; see [blocks](crate::petri::blocks).

use alloc::vec;
use alloc::vec::Vec;

use super::tables::Tables;
use crate::event::EventId;
use crate::petri::bits::lowest;
use crate::petri::blocks::layout::{
    BLOCK, Block, Flip, Layout, More, Need, Position, SLOTS, Special, WordBits, set_words, users_of,
};
use crate::petri::blocks::state::State;
use crate::petri::demand::{Demand, for_conditions};
use crate::petri::id::PlaceId;
use crate::petri::model::{PlaceKind, Structure};
use crate::petri::ports::PortChange;
use crate::petri::span::{Span, span};

/// What else each firing does.
pub(in crate::petri) struct Firings<'a> {
    tables: Tables,
    structure: &'a Structure,
    sources: &'a [(PlaceId, EventId)],
    sinks: &'a [(PlaceId, EventId)],
    specials: Vec<Special>,
    more: Vec<More>,
    needs_of: Vec<Span>,
    needs: Vec<Need>,
    far: Vec<Flip>,
    ports: Vec<PortChange>,
    word_bits: Vec<WordBits>,
    /// Of the transition at hand, in order.
    touched: Vec<Touched>,
    /// As a set of blocks has words.
    wakes: Vec<u64>,
}

/// A shared place in the conditions of a transition.
struct Touched {
    shared: u32,
    demand: Demand,
}

impl<'a> Firings<'a> {
    /// The complete layout, and the initial state.
    pub(in crate::petri) fn of(
        tables: Tables,
        structure: &'a Structure,
        sources: &'a [(PlaceId, EventId)],
        sinks: &'a [(PlaceId, EventId)],
    ) -> (Layout, State) {
        let mut firings = Self::new(tables, structure, sources, sinks);
        for block in 0..firings.tables.blocks.len() {
            firings.add_specials(block);
        }
        firings.finish()
    }

    fn new(
        tables: Tables,
        structure: &'a Structure,
        sources: &'a [(PlaceId, EventId)],
        sinks: &'a [(PlaceId, EventId)],
    ) -> Self {
        let behind_last = |of: fn(&Block) -> u64| {
            let last = tables.blocks.iter().rposition(|block| of(block) != 0);
            last.map_or(0, |last| {
                (last + 1) * BLOCK - of(&tables.blocks[last]).leading_zeros() as usize
            })
        };
        let specials = behind_last(|block| block.special);
        let several = behind_last(|block| block.several);
        let wakes = vec![0; set_words(tables.blocks.len())];
        Self {
            specials: vec![Special::NOTHING; specials],
            needs_of: vec![Span::default(); several],
            tables,
            structure,
            sources,
            sinks,
            more: Vec::new(),
            needs: Vec::new(),
            far: Vec::new(),
            ports: Vec::new(),
            word_bits: Vec::new(),
            touched: Vec::new(),
            wakes,
        }
    }

    fn add_specials(&mut self, block: usize) {
        let gates = self.tables.gates_of[block];
        for (gate, index) in gates.of(&self.tables.gates).iter().zip(gates.start..) {
            self.tables.gate_of[gate.shared as usize] = index;
            let open = gate.closed[0] | gate.closed[1];
            let marks = word_of(gate.shared);
            for (transitions, marks_it) in gate.closed.into_iter().zip([false, true]) {
                let mut gated = transitions & self.tables.gated[block];
                if gated == 0 {
                    continue;
                }
                let special = Special {
                    open,
                    marks: marks.bits,
                    wakes: self.users_of(gate.shared, marks_it)[0],
                    marks_word: marks.word,
                    wakes_word: 0,
                    more: Special::NO_MORE,
                };
                while let Some(lane) = lowest(gated) {
                    gated &= gated - 1;
                    self.specials[block * BLOCK + lane] = special;
                }
            }
        }
        let Block {
            special, several, ..
        } = self.tables.blocks[block];
        let mut others = special & !self.tables.gated[block];
        while let Some(lane) = lowest(others) {
            others &= others - 1;
            self.add_special(block * BLOCK + lane, gates, several >> lane & 1 == 1);
        }
    }

    fn add_special(&mut self, transition: usize, gates: Span, several: bool) {
        let tables = &self.tables;
        let block = transition / BLOCK;
        let starts = (self.far.len(), self.ports.len());
        self.touched.clear();
        for_conditions(self.structure.arcs_of(transition), |id, demand| {
            let place = &tables.places[id.index()];
            if let Some(shared) = place.as_shared() {
                self.touched.push(Touched { shared, demand });
            } else if place.is_in_several_blocks() && demand.changes() {
                for &position in place.positions(&tables.positions) {
                    if position.block() != block {
                        add_flip(&mut self.far, starts.0, position);
                    }
                }
            }
            let index_of = |ports: &[(PlaceId, EventId)]| {
                ports.partition_point(|&(other, _)| other < id) as u16
            };
            match self.structure.kind(id) {
                PlaceKind::Source if demand.changes() => {
                    let source = index_of(self.sources);
                    self.ports.push(PortChange::SourceEmptied(source));
                }
                PlaceKind::Sink => {
                    let sink = index_of(self.sinks);
                    self.ports.push(PortChange::SinkFilled(sink));
                }
                _ => {}
            }
        });
        self.touched.sort_unstable_by_key(|touched| touched.shared);
        let open = self.open_of_touched(gates);
        let (marks, further_marks) = self.marks_of_touched();
        let (wakes, further_wakes) = self.wakes_of_touched();
        let more = More {
            far: span(starts.0, self.far.len()),
            ports: span(starts.1, self.ports.len()),
            marks: further_marks,
            wakes: further_wakes,
        };
        let is_nothing = {
            let all = [more.far, more.ports, more.marks, more.wakes];
            all.iter().all(|span| span.start == span.end)
        };
        let index = if is_nothing {
            Special::NO_MORE
        } else {
            self.more.push(more);
            self.more.len() as u32 - 1
        };
        if several {
            self.needs_of[transition] = self.needs_of_touched();
        }
        self.specials[transition] = Special {
            open,
            marks: marks.bits,
            wakes: wakes.bits,
            marks_word: marks.word,
            wakes_word: wakes.word,
            more: index,
        };
    }

    /// The flips in `open` of the block whose gates these are.
    fn open_of_touched(&self, gates: Span) -> u64 {
        let tables = &self.tables;
        let changed = self.touched.iter().filter(|it| it.demand.changes());
        let gates = changed.filter_map(|touched| {
            let index = tables.gate_of[touched.shared as usize];
            gates.contains(index).then(|| &tables.gates[index as usize])
        });
        gates.fold(0, |open, gate| open | gate.closed[0] | gate.closed[1])
    }

    /// The shared places that change: the first word of them, and the others.
    fn marks_of_touched(&mut self) -> (WordBits, Span) {
        let mut first = WordBits::default();
        let start = self.word_bits.len();
        for touched in self.touched.iter().filter(|it| it.demand.changes()) {
            let more = word_of(touched.shared);
            if first.bits == 0 || first.word == more.word {
                first.word = more.word;
                first.bits |= more.bits;
                continue;
            }
            match self.word_bits[start..].last_mut() {
                Some(last) if last.word == more.word => last.bits |= more.bits,
                _ => self.word_bits.push(more),
            }
        }
        (first, span(start, self.word_bits.len()))
    }

    fn users_of(&self, shared: u32, when_marked: bool) -> &[u64] {
        users_of(
            &self.tables.users,
            self.tables.blocks.len(),
            shared,
            when_marked,
        )
    }

    /// The blocks that may have more to fire then: the first word of them, and the others.
    fn wakes_of_touched(&mut self) -> (WordBits, Span) {
        let mut wakes = core::mem::take(&mut self.wakes);
        wakes.fill(0);
        for touched in self.touched.iter().filter(|it| it.demand.changes()) {
            let marks_it = touched.demand == Demand::Empty;
            let users = self.users_of(touched.shared, marks_it);
            for (wakes, users) in wakes.iter_mut().zip(users) {
                *wakes |= users;
            }
        }
        self.wakes = wakes;
        let all = (0..).zip(&self.wakes).filter(|&(_, &bits)| bits != 0);
        let mut all = all.map(|(word, &bits)| WordBits { word, bits });
        let first = all.next().unwrap_or_default();
        let start = self.word_bits.len();
        self.word_bits.extend(all);
        (first, span(start, self.word_bits.len()))
    }

    /// What it needs of them.
    fn needs_of_touched(&mut self) -> Span {
        let start = self.needs.len();
        for touched in &self.touched {
            let WordBits { word, bits } = word_of(touched.shared);
            if self.needs[start..]
                .last()
                .is_none_or(|last| last.word != word)
            {
                self.needs.push(Need {
                    word,
                    care: 0,
                    value: 0,
                });
            }
            if let Some(need) = self.needs.last_mut() {
                need.care |= bits;
                need.value |= if touched.demand.is_met(true) { bits } else { 0 };
            }
        }
        span(start, self.needs.len())
    }

    fn finish(self) -> (Layout, State) {
        let tables = self.tables;
        // Special transitions may name the first word without any bit.
        let mut marks = vec![0; tables.shared.div_ceil(BLOCK).max(1)];
        for place in tables.places.iter().filter(|_| tables.shared > 0) {
            if let Some(shared) = place.as_shared() {
                let is_marked = u64::from(place.is_marked());
                marks[shared as usize / BLOCK] |= is_marked << (shared % u64::BITS);
            }
        }
        let layout = Layout {
            transitions: self.structure.transition_count(),
            own: tables.own.into(),
            specials: self.specials.into(),
            more: self.more.into(),
            needs_of: self.needs_of.into(),
            needs: self.needs.into(),
            far: self.far.into(),
            port_changes: self.ports.into(),
            word_bits: self.word_bits.into(),
            gates_of: tables.gates_of.into(),
            gates: tables.gates.into(),
            places: tables.places.into(),
            positions: tables.positions.into(),
            users: tables.users.into(),
        };
        let state = State::new(&layout, tables.blocks.into(), marks.into());
        (layout, state)
    }
}

fn word_of(shared: u32) -> WordBits {
    WordBits {
        word: (shared / u64::BITS) as u16,
        bits: 1 << (shared % u64::BITS),
    }
}

/// Combines a condition's flip with those from `first` on.
fn add_flip(flips: &mut Vec<Flip>, first: usize, position: Position) {
    let block = position.block() as u32;
    let known = flips[first..].iter().position(|flip| flip.block == block);
    let index = known.map_or(flips.len(), |index| first + index);
    if known.is_none() {
        let bits = [0; SLOTS];
        flips.push(Flip { block, bits });
    }
    flips[index].bits[position.slot()] ^= position.bit();
}
