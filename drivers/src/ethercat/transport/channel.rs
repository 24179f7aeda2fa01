//! ethercrab's frame storage, in a pool.
//!
//! ethercrab needs storage with a `'static` lifetime that can be split only once. Storage is allocated when the pool is
//! empty and returns to it when its bus ends, so that bringing a bus up a thousand times costs the memory of one.

use super::seal::{MAX_FRAME, SEAL};
use ethercrab::{
    MainDevice, MainDeviceConfig, PduLoop, PduRx, PduStorage, PduTx, RetryBehaviour, Timeouts,
};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Frames that ethercrab may hold at once: one in flight, and one or two not yet freed.
const FRAMES: usize = 8;

/// Most buses alive at once in one process; each costs 12 KiB.
const MAX_CHANNELS: usize = 256;

/// Leaves room for the seal in an Ethernet frame.
type Storage = PduStorage<FRAMES, { MAX_FRAME - SEAL }>;

type Parts = (PduTx<'static>, PduRx<'static>, PduLoop<'static>);

struct Pool {
    free: Vec<Parts>,
    allocated: usize,
}

static POOL: Mutex<Pool> = Mutex::new(Pool {
    free: Vec::new(),
    allocated: 0,
});

/// A MainDevice with its frame storage. Gives the storage back when dropped.
pub struct Channel {
    /// `Some` until dropped.
    parts: Option<(PduTx<'static>, PduRx<'static>, MainDevice<'static>)>,
}

impl Channel {
    /// `None` when there are already [`MAX_CHANNELS`].
    pub fn take() -> Option<Channel> {
        let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
        let (tx, rx, pdu_loop) = match pool.free.pop() {
            Some(parts) => parts,
            None if pool.allocated < MAX_CHANNELS => {
                pool.allocated += 1;
                let storage: &'static Storage = Box::leak(Box::new(Storage::new()));
                storage.try_split().ok()?
            }
            None => return None,
        };
        let main_device = MainDevice::new(pdu_loop, no_timeouts(), config());
        Some(Channel {
            parts: Some((tx, rx, main_device)),
        })
    }

    /// The sending and receiving ends, and the MainDevice between them.
    pub fn split(
        &mut self,
    ) -> (
        &mut PduTx<'static>,
        &mut PduRx<'static>,
        &MainDevice<'static>,
    ) {
        match &mut self.parts {
            Some((tx, rx, main_device)) => (tx, rx, main_device),
            None => unreachable!("a channel has its parts until it is dropped"),
        }
    }
}

impl Drop for Channel {
    fn drop(&mut self) {
        if let Some((tx, rx, main_device)) = self.parts.take() {
            // SAFETY: a group is only ever used with the MainDevice of the channel next to it (in `Bus` and in
            // bring-up), and both are given up together.
            let pdu_loop = unsafe { main_device.release() };
            POOL.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .free
                .push((tx, rx, pdu_loop));
        }
    }
}

/// Infinite, because a finite timeout would start ethercrab's timer thread. Our deadlines bound everything.
fn no_timeouts() -> Timeouts {
    Timeouts {
        state_transition: Duration::MAX,
        pdu: Duration::MAX,
        eeprom: Duration::MAX,
        // Zero is no wait at all, and uses no timer either.
        wait_loop_delay: Duration::ZERO,
        mailbox_echo: Duration::MAX,
        mailbox_response: Duration::MAX,
    }
}

fn config() -> MainDeviceConfig {
    MainDeviceConfig {
        // One SubDevice is its own reference clock: there is nothing to synchronise.
        dc_static_sync_iterations: 0,
        // Our own poll loop sends again.
        retry_behaviour: RetryBehaviour::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn storage_is_used_again() {
        for _ in 0..10 * MAX_CHANNELS {
            assert!(Channel::take().is_some());
        }
        // Tests of other modules may hold channels at the same time.
        let allocated = POOL.lock().unwrap().allocated;
        assert!(allocated < MAX_CHANNELS / 2, "{allocated}");
    }
}
