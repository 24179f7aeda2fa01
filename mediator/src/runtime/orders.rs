//! What operators have ordered: who, when, and what became of it.

use std::collections::BTreeMap;

use super::input::Asker;
use super::question::{Answer, Question};
use crate::journal::{Entry, OrderRecord};

/// So many are kept.
const KEPT: usize = 1000;

/// The last orders, by number.
#[derive(Debug, Default)]
pub(super) struct Orders(BTreeMap<u64, OrderRecord>);

impl Orders {
    pub(super) fn new(stored: BTreeMap<u64, OrderRecord>) -> Self {
        Self(stored)
    }

    /// Notes an order and what was answered. What is to be written to the journal.
    pub(super) fn note(
        &mut self,
        asker: Asker,
        question: &Question,
        answer: &Answer,
        entries: &mut Vec<Entry>,
    ) {
        let (done, answer) = match answer {
            Answer::Done(text) => (true, text.clone()),
            Answer::Refused(why) => (false, why.clone()),
            Answer::Status(_) | Answer::Orders(_) | Answer::Underway(_) => return,
        };
        let record = OrderRecord {
            at: asker.at,
            who: asker.who,
            order: question.to_string(),
            done,
            answer,
        };
        let number = { self.0.last_key_value() }.map_or(1, |(last, _)| last.saturating_add(1));
        self.0.insert(number, record.clone());
        let record = Some(record);
        entries.push(Entry::Order { number, record });
        while self.0.len() > KEPT {
            if let Some((number, _)) = self.0.pop_first() {
                let record = None;
                entries.push(Entry::Order { number, record });
            }
        }
    }

    /// The oldest first.
    pub(super) fn all(&self) -> Vec<OrderRecord> {
        self.0.values().cloned().collect()
    }
}
