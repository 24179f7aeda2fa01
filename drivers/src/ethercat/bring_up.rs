//! From nothing to OP, with everything checked on the way.

use super::al::{AlState, AlStatus};
use super::bus::Bus;
use super::error::{BringUpError, Phase, ProcessData};
use super::expectation::{BringUpOptions, Expectation, FoundSubDevice};
use super::links::Link;
use super::sub_device::{
    FIRST_ADDRESS, Group, MAX_SUB_DEVICES, PROCESS_DATA_WKC, UnmappedGroup, read_status,
    request_state,
};
use super::transport::{Channel, Patience, Pump, Resend, Stopped};
use super::watchdog;
use ethercrab::error::Error;
use ethercrab::{Command, MainDevice, RegisterAddress};
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

/// Exactly one SubDevice per bus is supported.
const SUB_DEVICES: u16 = 1;
/// Time to read the SubDevice's state after a failed step, for the error message.
const POST_MORTEM: Duration = Duration::from_millis(50);

impl Bus {
    /// Brings the one SubDevice behind `link` from any state to OP and checks it against `expected`.
    ///
    /// Takes at most `options.timeout`, plus 50 ms for reading the state after a failure. Allocates; not for real-time
    /// threads.
    ///
    /// # Errors
    /// [`BringUpError`] names the link, the step and what was found instead of what was expected. The link is closed.
    pub fn bring_up(
        link: Box<dyn Link>,
        expected: &Expectation,
        options: BringUpOptions,
    ) -> Result<Bus, BringUpError> {
        Self::bring_up_noting(link, expected, options, &mut false)
    }

    /// As [`Bus::bring_up`]; and whether it succeeds or not, `lost_power` becomes true if the SubDevice is found to have lost its
    /// power since the last bring-up. It has an address when this one fails, so that only the caller can still know then.
    ///
    /// # Errors
    /// As [`Bus::bring_up`].
    pub fn bring_up_noting(
        link: Box<dyn Link>,
        expected: &Expectation,
        options: BringUpOptions,
        lost_power: &mut bool,
    ) -> Result<Bus, BringUpError> {
        let channel = Channel::take().ok_or(BringUpError::TooManyBuses)?;
        let pump = Pump::new(link);
        let mut steps = Steps {
            deadline_ns: { pump.clock.now_ns() }.saturating_add(nanoseconds(options.timeout)),
            pump,
            channel,
            options,
        };
        steps.count()?;
        let had_address = steps.has_address()?;
        *lost_power |= !had_address;
        let group = steps.initialise()?;
        let identity = FoundSubDevice {
            had_address,
            ..steps.identify(&group, expected)?
        };
        let group = steps.map(group, expected)?;
        let (outputs, watchdog_ms) = (expected.outputs_bytes, expected.watchdog_ms);
        steps.run(Phase::Watchdog, async |main_device| {
            watchdog::arm(main_device, FIRST_ADDRESS, outputs, watchdog_ms).await
        })??;
        steps.reach_safe_op()?;
        steps.reach_op(&group)?;
        Ok(Bus::new(
            steps.pump,
            steps.channel,
            group,
            identity,
            expected,
        ))
    }
}

struct Steps {
    pump: Pump,
    channel: Channel,
    options: BringUpOptions,
    deadline_ns: u64,
}

impl Steps {
    /// Runs one piece of work on the bus.
    fn run<T>(
        &mut self,
        phase: Phase,
        work: impl AsyncFnOnce(&MainDevice<'static>) -> Result<T, Error>,
    ) -> Result<T, BringUpError> {
        match self.run_until(self.deadline_ns, work) {
            Ok(Ok(done)) => Ok(done),
            Ok(Err(source)) => {
                let status = self.post_mortem();
                Err(BringUpError::Protocol {
                    link: self.pump.describe(),
                    phase,
                    source,
                    status,
                })
            }
            Err(stopped) => Err(self.explain(phase, stopped)),
        }
    }

    fn run_until<T>(
        &mut self,
        deadline_ns: u64,
        work: impl AsyncFnOnce(&MainDevice<'static>) -> T,
    ) -> Result<T, Stopped> {
        let resend = Resend {
            after_ns: nanoseconds(self.options.frame_timeout),
            attempts: self.options.frame_attempts,
        };
        let (tx, rx, main_device) = self.channel.split();
        let future = pin!(work(main_device));
        self.pump.run(
            (tx, rx),
            future,
            Patience {
                deadline_ns,
                resend: Some(resend),
            },
        )
    }

    fn explain(&mut self, phase: Phase, stopped: Stopped) -> BringUpError {
        let link = self.pump.describe();
        match stopped {
            Stopped::Deadline => self.timed_out(phase),
            Stopped::Unanswered => BringUpError::NoAnswer {
                link,
                phase,
                attempts: self.options.frame_attempts,
                waited_ms: (self.options.frame_timeout * self.options.frame_attempts).as_millis()
                    as u64,
                echoed_frames: self.pump.counters.echoed_frames,
            },
            Stopped::Link(source) => BringUpError::Link {
                link,
                phase,
                source,
            },
            Stopped::Stuck => BringUpError::Protocol {
                link,
                phase,
                source: Error::SendFrame,
                status: None,
            },
        }
    }

    fn timed_out(&mut self, phase: Phase) -> BringUpError {
        let status = self.post_mortem();
        let limit_ms = self.options.timeout.as_millis() as u64;
        BringUpError::TimedOut {
            link: self.pump.describe(),
            phase,
            limit_ms,
            status,
        }
    }

    /// The SubDevice's state after a failure, if it still answers.
    fn post_mortem(&mut self) -> Option<AlStatus> {
        let deadline_ns = self.now_ns().saturating_add(nanoseconds(POST_MORTEM));
        self.run_until(deadline_ns, read_status).ok()?.ok()
    }

    fn count(&mut self) -> Result<(), BringUpError> {
        let counted = self.run(Phase::Counting, async |main_device| {
            // Every SubDevice that answers a broadcast read adds one to the working counter.
            let read = Command::brd(RegisterAddress::Type.into()).with_wkc(SUB_DEVICES);
            Ok(match read.receive::<u8>(main_device).await {
                Err(Error::WorkingCounter { received, .. }) => received,
                other => other.map(|_| SUB_DEVICES)?,
            })
        })?;
        match counted {
            SUB_DEVICES => Ok(()),
            found => Err(BringUpError::SubDeviceCount {
                link: self.pump.describe(),
                expected: SUB_DEVICES,
                found,
            }),
        }
    }

    /// Whether the SubDevice has the address that bring-ups give, before this one does: controllers start without one.
    fn has_address(&mut self) -> Result<bool, BringUpError> {
        let address = self.run(Phase::Counting, async |main_device| {
            let register = RegisterAddress::ConfiguredStationAddress;
            Command::aprd(0, register.into())
                .receive::<u16>(main_device)
                .await
        })?;
        Ok(address == FIRST_ADDRESS)
    }

    fn initialise(&mut self) -> Result<UnmappedGroup, BringUpError> {
        let clock = Arc::clone(&self.pump.clock);
        self.run(Phase::Initialising, async |main_device| {
            main_device
                .init::<MAX_SUB_DEVICES, _>(
                    || clock.now_ns(),
                    UnmappedGroup::default(),
                    |group, _| Ok(group),
                )
                .await
        })
    }

    fn identify(
        &mut self,
        group: &UnmappedGroup,
        expected: &Expectation,
    ) -> Result<FoundSubDevice, BringUpError> {
        let link = self.pump.describe();
        let (_, _, main_device) = self.channel.split();
        let sub_device =
            group
                .subdevice(main_device, 0)
                .map_err(|source| BringUpError::Protocol {
                    link: link.clone(),
                    phase: Phase::Initialising,
                    source,
                    status: None,
                })?;
        let (address, name) = (
            sub_device.configured_address(),
            sub_device.name().to_owned(),
        );
        let found = sub_device.identity();
        if found.vendor_id != expected.vendor_id {
            return Err(BringUpError::Vendor {
                address,
                name,
                expected: expected.vendor_id,
                found: found.vendor_id,
            });
        }
        if !expected.product_codes.contains(&found.product_id) {
            let (expected, found) = (expected.product_codes.clone(), found.product_id);
            return Err(BringUpError::Product {
                address,
                name,
                expected,
                found,
            });
        }
        let ethercrab::SubDeviceIdentity {
            vendor_id,
            product_id: product_code,
            revision,
            serial,
        } = found;
        Ok(FoundSubDevice {
            link,
            address,
            name,
            vendor_id,
            product_code,
            revision,
            serial,
            had_address: false,
        })
    }

    fn map(&mut self, group: UnmappedGroup, expected: &Expectation) -> Result<Group, BringUpError> {
        let (group, outputs, inputs) = self.run(Phase::Mapping, async |main_device| {
            let group = group.into_pre_op_pdi(main_device).await?;
            let sub_device = group.subdevice(main_device, 0)?;
            let (outputs, inputs) = (
                sub_device.outputs_raw().len(),
                sub_device.inputs_raw().len(),
            );
            Ok((group, outputs, inputs))
        })?;
        for (direction, found, expected) in [
            (ProcessData::Outputs, outputs, expected.outputs_bytes),
            (ProcessData::Inputs, inputs, expected.inputs_bytes),
        ] {
            if found != expected {
                return Err(BringUpError::ProcessDataSize {
                    address: FIRST_ADDRESS,
                    direction,
                    expected,
                    found,
                });
            }
        }
        Ok(group)
    }

    fn request(&mut self, phase: Phase, wanted: AlState) -> Result<(), BringUpError> {
        self.run(phase, async |main_device| {
            request_state(main_device, wanted).await
        })
    }

    /// Looks once whether the SubDevice has reached `wanted`. An error if it has refused, or at the deadline.
    fn has_reached(&mut self, phase: Phase, wanted: AlState) -> Result<bool, BringUpError> {
        let status = self.run(phase, read_status)?;
        if status.error {
            return Err(BringUpError::Refused {
                address: FIRST_ADDRESS,
                wanted,
                status,
            });
        }
        if status.state != wanted && self.now_ns() >= self.deadline_ns {
            return Err(self.timed_out(phase));
        }
        Ok(status.state == wanted)
    }

    fn reach_safe_op(&mut self) -> Result<(), BringUpError> {
        self.request(Phase::SafeOp, AlState::SafeOp)?;
        while !self.has_reached(Phase::SafeOp, AlState::SafeOp)? {
            self.pause(self.now_ns());
        }
        Ok(())
    }

    /// SubDevices go to OP only while process data is running; the outputs are all zero meanwhile.
    fn reach_op(&mut self, group: &Group) -> Result<(), BringUpError> {
        let exchange = async |main_device: &MainDevice<'static>| {
            group
                .tx_rx(main_device)
                .await
                .map(|response| response.working_counter)
        };
        self.run(Phase::Op, exchange)?;
        self.request(Phase::Op, AlState::Op)?;
        loop {
            let started_ns = self.now_ns();
            let found = self.run(Phase::Op, exchange)?;
            if self.has_reached(Phase::Op, AlState::Op)? {
                if found == PROCESS_DATA_WKC {
                    return Ok(());
                }
                if self.now_ns() >= self.deadline_ns {
                    let (address, expected) = (FIRST_ADDRESS, PROCESS_DATA_WKC);
                    return Err(BringUpError::WorkingCounter {
                        address,
                        expected,
                        found,
                    });
                }
            }
            self.pause(started_ns);
        }
    }

    fn now_ns(&self) -> u64 {
        self.pump.clock.now_ns()
    }

    fn pause(&self, started_ns: u64) {
        let until_ns = started_ns.saturating_add(nanoseconds(self.options.cycle));
        self.pump.clock.sleep_until(until_ns);
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
