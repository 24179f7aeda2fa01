//! A SubDevice in OP, and the exchange of process data with it.

use super::al::{AlState, AlStatus};
use super::error::{ExchangeError, ProcessData};
use super::expectation::{Expectation, FoundSubDevice};
use super::links::Link;
use super::sub_device::{Group, PROCESS_DATA_WKC, read_status, request_state};
use super::transport::{BusCounters, Channel, Patience, Pump, Stopped};
use ethercrab::MainDevice;
use ethercrab::error::Error;
use std::pin::pin;

/// A successful exchange.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exchange {
    /// When the frame was sent, on the link's clock.
    pub sent_ns: u64,
    /// When its answer was there, on the link's clock.
    pub received_ns: u64,
}

/// One SubDevice in OP.
///
/// Dropping a bus leaves the SubDevice to its watchdog; call [`Bus::shut_down`] first to stop it at once.
pub struct Bus {
    pump: Pump,
    channel: Channel,
    group: Group,
    identity: FoundSubDevice,
    outputs_bytes: usize,
    inputs_bytes: usize,
}

impl Bus {
    pub(super) fn new(
        mut pump: Pump,
        channel: Channel,
        group: Group,
        identity: FoundSubDevice,
        expected: &Expectation,
    ) -> Bus {
        pump.counters = BusCounters::default();
        let Expectation {
            outputs_bytes,
            inputs_bytes,
            ..
        } = *expected;
        Bus {
            pump,
            channel,
            group,
            identity,
            outputs_bytes,
            inputs_bytes,
        }
    }

    /// What was found at bring-up.
    pub fn identity(&self) -> &FoundSubDevice {
        &self.identity
    }

    /// What happened since bring-up.
    pub fn counters(&self) -> BusCounters {
        self.pump.counters
    }

    /// Writes `outputs`, reads `inputs`, and looks at the SubDevice's state, in one frame.
    ///
    /// Real-time. Returns at `deadline_ns` (on the link's clock) at the latest; an answer that comes later is recognised
    /// and dropped by the exchange that receives it. `inputs` changes only on success. After an error the outputs may
    /// or may not have reached the SubDevice.
    ///
    /// # Errors
    /// [`ExchangeError`]; every one but [`ExchangeError::ImageSize`] is counted in [`Bus::counters`].
    pub fn exchange(
        &mut self,
        outputs: &[u8],
        inputs: &mut [u8],
        deadline_ns: u64,
    ) -> Result<Exchange, ExchangeError> {
        self.check_sizes(outputs, inputs)?;
        let exchanged = self.exchange_uncounted(outputs, inputs, deadline_ns);
        let counters = &mut self.pump.counters;
        counters.cycles += 1;
        match exchanged {
            Ok(_) => {}
            Err(ExchangeError::Lost) => counters.lost_frames += 1,
            Err(ExchangeError::WorkingCounter { .. }) => counters.wkc_errors += 1,
            Err(ExchangeError::NotOperational { .. }) => counters.not_operational += 1,
            Err(_) => counters.errors += 1,
        }
        exchanged
    }

    fn exchange_uncounted(
        &mut self,
        outputs: &[u8],
        inputs: &mut [u8],
        deadline_ns: u64,
    ) -> Result<Exchange, ExchangeError> {
        let group = &self.group;
        {
            let (_, _, main_device) = self.channel.split();
            let sub_device = group
                .subdevice(main_device, 0)
                .map_err(ExchangeError::Protocol)?;
            sub_device.outputs_raw_mut().copy_from_slice(outputs);
        }
        let response = run(
            &mut self.pump,
            &mut self.channel,
            deadline_ns,
            async |main_device| group.tx_rx(main_device).await,
        )?;
        let exchange = Exchange {
            sent_ns: self.pump.sent_ns,
            received_ns: self.pump.received_ns,
        };
        match response
            .subdevice_states
            .first()
            .copied()
            .map(AlState::from)
        {
            Some(AlState::Op) => {}
            // No SubDevice answered at that address: the working counter below reports it.
            None | Some(AlState::Other(0)) => {}
            Some(state) => {
                // The AL status code takes a second frame, if there is time left.
                let unknown = AlStatus {
                    state,
                    error: false,
                    code: None,
                };
                let status = self.al_status(deadline_ns).unwrap_or(unknown);
                return Err(ExchangeError::NotOperational {
                    address: self.identity.address,
                    status,
                });
            }
        }
        if response.working_counter != PROCESS_DATA_WKC {
            let (found, expected) = (response.working_counter, PROCESS_DATA_WKC);
            return Err(ExchangeError::WorkingCounter { found, expected });
        }
        let (_, _, main_device) = self.channel.split();
        let sub_device = self
            .group
            .subdevice(main_device, 0)
            .map_err(ExchangeError::Protocol)?;
        inputs.copy_from_slice(&sub_device.inputs_raw());
        Ok(exchange)
    }

    /// Reads AL state and status code. Real-time.
    ///
    /// # Errors
    /// [`ExchangeError`], as for [`Bus::exchange`]; nothing is counted.
    pub fn al_status(&mut self, deadline_ns: u64) -> Result<AlStatus, ExchangeError> {
        run(&mut self.pump, &mut self.channel, deadline_ns, read_status)
    }

    /// Takes the SubDevice out of OP to INIT, so that it stops without its watchdog's help. Sends one frame; the bus
    /// cannot exchange afterwards.
    ///
    /// # Errors
    /// [`ExchangeError`]: the request may not have arrived, and the SubDevice is left to its watchdog.
    pub fn shut_down(&mut self, deadline_ns: u64) -> Result<(), ExchangeError> {
        run(
            &mut self.pump,
            &mut self.channel,
            deadline_ns,
            async |main_device| request_state(main_device, AlState::Init).await,
        )
    }

    /// Gives the link back, to bring the bus up again on the same socket.
    pub fn release(self) -> Box<dyn Link> {
        self.pump.into_link()
    }

    fn check_sizes(&self, outputs: &[u8], inputs: &[u8]) -> Result<(), ExchangeError> {
        for (direction, found, expected) in [
            (ProcessData::Outputs, outputs.len(), self.outputs_bytes),
            (ProcessData::Inputs, inputs.len(), self.inputs_bytes),
        ] {
            if found != expected {
                return Err(ExchangeError::ImageSize {
                    direction,
                    expected,
                    found,
                });
            }
        }
        Ok(())
    }
}

/// A bus is brought up by one thread and may be used by another.
const _: fn() = || {
    fn sendable<T: Send>() {}
    sendable::<Bus>();
};

/// Runs work of one frame, which is sent once.
fn run<T>(
    pump: &mut Pump,
    channel: &mut Channel,
    deadline_ns: u64,
    work: impl AsyncFnOnce(&MainDevice<'static>) -> Result<T, Error>,
) -> Result<T, ExchangeError> {
    let (tx, rx, main_device) = channel.split();
    // Dropped with this call, which frees the frame of an exchange that was given up.
    let future = pin!(work(main_device));
    let patience = Patience {
        deadline_ns,
        resend: None,
    };
    match pump.run((tx, rx), future, patience) {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(error)) => Err(ExchangeError::Protocol(error)),
        Err(Stopped::Deadline | Stopped::Unanswered) => Err(ExchangeError::Lost),
        Err(Stopped::Link(error)) => Err(ExchangeError::Io {
            kind: error.kind(),
            os_error: error.raw_os_error(),
        }),
        Err(Stopped::Stuck) => Err(ExchangeError::Protocol(Error::SendFrame)),
    }
}
