//! Bounded queues from one producer to one consumer.

use alloc::sync::Arc;
use core::sync::atomic::{AtomicU64, Ordering};

use rtrb::{Consumer, Producer, RingBuffer};
use thiserror::Error;

/// The queue was full; the event comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the event queue is full")]
pub struct QueueFull<E>(pub E);

/// A queue for `capacity` events (at least one) between two threads. Allocates.
#[must_use]
pub fn queue<E: Copy + Send>(capacity: usize) -> (Sender<E>, Receiver<E>) {
    let (producer, consumer) = RingBuffer::new(capacity.max(1));
    let refused = Arc::new(AtomicU64::new(0));
    (
        Sender {
            producer,
            refused: Arc::clone(&refused),
        },
        Receiver { consumer, refused },
    )
}

/// The producing end of a queue.
#[derive(Debug)]
pub struct Sender<E> {
    producer: Producer<E>,
    refused: Arc<AtomicU64>,
}

impl<E: Copy + Send> Sender<E> {
    /// Puts `event` at the end of the queue; a full queue counts it as refused and gives it back.
    ///
    /// # Errors
    /// [`QueueFull`] with the event.
    pub fn send(&mut self, event: E) -> Result<(), QueueFull<E>> {
        self.producer.push(event).map_err(|full| {
            let rtrb::PushError::Full(event) = full;
            self.refused.fetch_add(1, Ordering::Relaxed);
            QueueFull(event)
        })
    }

    /// How many events the queue has refused so far.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// How many more events fit at the moment; the consumer can only make it more.
    pub fn free(&self) -> usize {
        self.producer.slots()
    }

    /// Whether the consumer is gone, so that nobody will ever receive.
    pub fn is_abandoned(&self) -> bool {
        self.producer.is_abandoned()
    }
}

/// The consuming end of a queue.
#[derive(Debug)]
pub struct Receiver<E> {
    consumer: Consumer<E>,
    refused: Arc<AtomicU64>,
}

impl<E: Copy + Send> Receiver<E> {
    /// Takes the oldest event out of the queue.
    pub fn receive(&mut self) -> Option<E> {
        self.consumer.pop().ok()
    }

    /// How many events the queue has refused so far.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// How many events wait at the moment; the producer can only make it more.
    pub fn len(&self) -> usize {
        self.consumer.slots()
    }

    /// Whether no event waits at the moment.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the producer is gone; events that it sent before may still wait.
    pub fn is_abandoned(&self) -> bool {
        self.consumer.is_abandoned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_leave_in_the_order_they_came() {
        let (mut sender, mut receiver) = queue(3);
        for event in 1..=3 {
            sender.send(event).unwrap();
        }
        assert_eq!((receiver.len(), sender.free()), (3, 0));
        assert_eq!(
            std::iter::from_fn(|| receiver.receive()).collect::<Vec<_>>(),
            [1, 2, 3]
        );
        assert!(receiver.is_empty());
    }

    #[test]
    fn a_full_queue_gives_the_event_back_and_counts_it() {
        let (mut sender, mut receiver) = queue(1);
        sender.send('a').unwrap();
        assert_eq!(sender.send('b'), Err(QueueFull('b')));
        assert_eq!(sender.send('c'), Err(QueueFull('c')));
        assert_eq!((sender.refused(), receiver.refused()), (2, 2));
        assert_eq!(receiver.receive(), Some('a'));
        sender.send('d').unwrap();
        assert_eq!(receiver.receive(), Some('d'));
    }

    #[test]
    fn what_was_sent_outlives_the_sender() {
        let (mut sender, mut receiver) = queue(2);
        sender.send(7).unwrap();
        drop(sender);
        assert!(receiver.is_abandoned());
        assert_eq!(receiver.receive(), Some(7));
        assert_eq!(receiver.receive(), None);
    }

    #[test]
    fn a_queue_without_room_still_takes_one() {
        let (mut sender, _receiver) = queue(0);
        assert_eq!(sender.send(1), Ok(()));
        assert_eq!(sender.send(2), Err(QueueFull(2)));
    }

    #[test]
    fn two_threads_lose_nothing() {
        const EVENTS: u32 = 100_000;
        let (mut sender, mut receiver) = queue(64);
        let producer = std::thread::spawn(move || {
            for event in 0..EVENTS {
                while sender.send(event).is_err() {
                    std::thread::yield_now();
                }
            }
        });
        let mut expected = 0;
        while expected < EVENTS {
            match receiver.receive() {
                Some(event) => {
                    assert_eq!(event, expected);
                    expected += 1;
                }
                None => std::thread::yield_now(),
            }
        }
        producer.join().unwrap();
        assert!(receiver.is_empty());
    }
}
