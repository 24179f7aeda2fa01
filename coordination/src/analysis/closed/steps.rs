//! The steps between the states of a closed net.

use super::super::refusal::Reason;
use super::super::usage::Use;
use super::net::{Bound, Closed, Move};
use crate::protocol::Position;

impl Closed<'_> {
    /// Shows every step from `from` to `visit`, with the transition's or protocol's state behind it.
    /// Returns how many things were looked at. Stops at the first fault.
    pub(in crate::analysis) fn steps(
        &self,
        from: &[u64],
        scratch: &mut Vec<u64>,
        mut visit: impl FnMut(Move, &[u64]) -> Result<(), Box<Reason>>,
    ) -> Result<u64, Box<Reason>> {
        let mut looks = 1;
        for (word, &bits) in self.layout.marking(from).iter().enumerate() {
            let mut bits = bits;
            while bits != 0 {
                let place = word * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                looks += self.first_input[place].len() as u64;
                for &transition in &self.first_input[place] {
                    if self.is_enabled(from, transition)? {
                        self.fire(from, transition, scratch);
                        visit(Move::Fire(transition), scratch)?;
                    }
                }
            }
        }
        for (number, (used, bound)) in (0..).zip(self.uses.iter().zip(&self.bound)) {
            looks += 1 + bound.sinks.len() as u64;
            self.protocol_steps(from, number, used, bound, scratch, &mut visit)?;
        }
        looks += (self.event_sources.len() + self.event_sinks.len()) as u64;
        for &source in &self.event_sources {
            if !self.layout.is_marked(from, source) {
                copy(scratch, from);
                self.layout.mark(scratch, source);
                visit(Move::Fill(source), scratch)?;
            }
        }
        for &sink in &self.event_sinks {
            if self.layout.is_marked(from, sink) {
                copy(scratch, from);
                self.layout.clear(scratch, sink);
                visit(Move::Empty(sink), scratch)?;
            }
        }
        Ok(looks)
    }

    pub(in crate::analysis) fn is_enabled(
        &self,
        state: &[u64],
        transition: u32,
    ) -> Result<bool, Box<Reason>> {
        let arcs = &self.transitions[transition as usize].1;
        let marked = |&place: &u32| self.layout.is_marked(state, place);
        if !arcs.inputs.iter().all(marked) || arcs.sinks.iter().any(marked) {
            return Ok(false);
        }
        match arcs.internal.iter().find(|place| marked(place)) {
            None => Ok(true),
            Some(&place) => Err(Box::new(self.second_token(transition, place))),
        }
    }

    fn fire(&self, from: &[u64], transition: u32, state: &mut Vec<u64>) {
        copy(state, from);
        let arcs = &self.transitions[transition as usize].1;
        for &place in &arcs.taken {
            self.layout.clear(state, place);
            // What waits for an emptied source fills it again.
            if let Some(counter) = self.counters[place as usize] {
                let waiting = self.layout.waiting(state, counter);
                if waiting > 0 {
                    self.layout.set_waiting(state, counter, waiting - 1);
                    self.layout.mark(state, place);
                }
            }
        }
        for &place in arcs.internal.iter().chain(&arcs.sinks) {
            self.layout.mark(state, place);
        }
    }

    fn protocol_steps(
        &self,
        from: &[u64],
        number: u16,
        used: &Use,
        bound: &Bound,
        scratch: &mut Vec<u64>,
        visit: &mut impl FnMut(Move, &[u64]) -> Result<(), Box<Reason>>,
    ) -> Result<(), Box<Reason>> {
        let (protocol, index) = (&used.protocol, usize::from(number));
        let at = self.position(from, index);
        // What comes behind an abort stays unread until the net has dealt with the abort.
        let is_unread = |&(source, _): &(u32, usize)| self.layout.is_marked(from, source);
        let deaf = bound.aborts.iter().any(is_unread);
        for (flag, to) in protocol.next(at) {
            if !deaf && protocol.owner(flag) == Some(used.net_party.other()) {
                copy(scratch, from);
                self.layout.set_position(scratch, index, used.after(to));
                for &(source, counter) in &bound.sources[flag.index()] {
                    self.offer(scratch, source, counter)?;
                }
                visit(Move::Set(number, flag), scratch)?;
            }
        }
        for &(sink, flag) in &bound.sinks {
            if self.layout.is_marked(from, sink)
                && let Some(to) = protocol.after(at, flag)
            {
                copy(scratch, from);
                self.layout.set_position(scratch, index, used.after(to));
                self.layout.clear(scratch, sink);
                visit(Move::Empty(sink), scratch)?;
            }
        }
        if !deaf && !bound.aborts.is_empty() && at != Position::START {
            copy(scratch, from);
            self.layout.set_position(scratch, index, Position::START);
            // Void what belongs to the run.
            for &(source, counter) in bound.sources.iter().flatten() {
                self.layout.clear(scratch, source);
                self.layout.set_waiting(scratch, counter, 0);
            }
            for &(sink, _) in &bound.sinks {
                self.layout.clear(scratch, sink);
            }
            for &(source, counter) in &bound.aborts {
                self.offer(scratch, source, counter)?;
            }
            visit(Move::Abort(number), scratch)?;
        }
        Ok(())
    }

    /// Fills a source, or lets the event wait for it.
    fn offer(&self, state: &mut [u64], source: u32, counter: usize) -> Result<(), Box<Reason>> {
        if !self.layout.is_marked(state, source) {
            self.layout.mark(state, source);
            return Ok(());
        }
        let waiting = self.layout.waiting(state, counter);
        if waiting >= self.max_waiting {
            return Err(Box::new(self.overflow(source, waiting)));
        }
        self.layout.set_waiting(state, counter, waiting + 1);
        Ok(())
    }
}

fn copy(to: &mut Vec<u64>, from: &[u64]) {
    to.clear();
    to.extend_from_slice(from);
}
