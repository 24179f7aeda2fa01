//! The process-data watchdog (ETG.1000.4 section 6.3): the SubDevice stops by itself when the MainDevice falls silent.
//!
//! It acts when the outputs have not been written for the time of register 0x0420, counted in ticks of
//! (divider 0x0400 + 2) · 40 ns, and only if the control byte of the outputs' SyncManager enables it.
//!
//! All of this is set and read back at each bring-up, since registers outlive INIT. What somebody else writes to them while the
//! SubDevice is in OP is not noticed before the next one.

use super::error::BringUpError;
use ethercrab::error::Error;
use ethercrab::{Command, MainDevice, RegisterAddress};

const SYNC_MANAGER_COUNT: u16 = 0x0005;
const SYNC_MANAGERS: u16 = 0x0800;
const SYNC_MANAGER_SIZE: u16 = 8;
const MAX_SYNC_MANAGERS: u8 = 16;

/// Divider for ticks of 100 µs, the value after a reset.
const DIVIDER_100_US: u16 = 2498;

/// SyncManager control byte (ETG.1000.4 table 59): buffered, not mailbox, and written by the MainDevice.
const CONTROL_OUTPUTS_MASK: u8 = 0b0000_1111;
const CONTROL_OUTPUTS: u8 = 0b0000_0100;
const CONTROL_WATCHDOG: u8 = 0x40;
const ACTIVATED: u8 = 0x01;

/// Offsets of a SyncManager's control byte and of the one that activates it.
const CONTROL: u16 = 4;
const ACTIVATE: u16 = 6;

/// Sets the time and arms the watchdog, where the SubDevice's EEPROM has it off. The SyncManagers must be configured.
pub(super) async fn arm(
    main_device: &MainDevice<'_>,
    address: u16,
    outputs_bytes: usize,
    watchdog_ms: u32,
) -> Result<Result<(), BringUpError>, Error> {
    let Some(ticks) = ticks(watchdog_ms) else {
        return Ok(Err(BringUpError::WatchdogRange { watchdog_ms }));
    };
    let expected_us = u64::from(watchdog_ms) * 1000;
    let mut found_us = read_us(main_device, address).await?;
    if !close(found_us, expected_us) {
        // The divider is common to all SyncManagers and to the PDI watchdog, whose time this keeps in ticks.
        let write = |register: RegisterAddress| Command::fpwr(address, register.into());
        write(RegisterAddress::WatchdogDivider)
            .send(main_device, DIVIDER_100_US)
            .await?;
        write(RegisterAddress::SyncManagerWatchdog)
            .send(main_device, ticks)
            .await?;
        found_us = read_us(main_device, address).await?;
    }
    if !close(found_us, expected_us) {
        return Ok(Err(BringUpError::WatchdogTime {
            address,
            expected_us,
            found_us,
        }));
    }
    arm_sync_manager(main_device, address, outputs_bytes).await
}

/// Has the SyncManager of the outputs feed the watchdog, and reads that back.
async fn arm_sync_manager(
    main_device: &MainDevice<'_>,
    address: u16,
    outputs_bytes: usize,
) -> Result<Result<(), BringUpError>, Error> {
    let found = Command::fprd(address, SYNC_MANAGER_COUNT)
        .receive::<u8>(main_device)
        .await?;
    let sync_managers = found.min(MAX_SYNC_MANAGERS);
    for sync_manager in 0..sync_managers {
        let register = SYNC_MANAGERS + SYNC_MANAGER_SIZE * u16::from(sync_manager);
        let read = async || {
            Command::fprd(address, register)
                .receive::<[u8; 8]>(main_device)
                .await
        };
        let [_, _, length_low, length_high, control, _, activate, _] = read().await?;
        let length = usize::from(u16::from_le_bytes([length_low, length_high]));
        let carries_outputs = control & CONTROL_OUTPUTS_MASK == CONTROL_OUTPUTS
            && activate & ACTIVATED != 0
            && length == outputs_bytes;
        if !carries_outputs {
            continue;
        }
        if control & CONTROL_WATCHDOG != 0 {
            return Ok(Ok(()));
        }
        // A SyncManager takes no settings while it is active.
        for (offset, value) in [
            (ACTIVATE, activate & !ACTIVATED),
            (CONTROL, control | CONTROL_WATCHDOG),
            (ACTIVATE, activate),
        ] {
            Command::fpwr(address, register + offset)
                .send(main_device, value)
                .await?;
        }
        let [_, _, _, _, control, _, activate, _] = read().await?;
        let armed = control & CONTROL_WATCHDOG != 0 && activate & ACTIVATED != 0;
        return Ok(if armed {
            Ok(())
        } else {
            Err(BringUpError::WatchdogDisarmed {
                address,
                sync_manager,
                control,
            })
        });
    }
    Ok(Err(BringUpError::OutputSyncManager {
        address,
        sync_managers,
        expected: outputs_bytes,
    }))
}

async fn read_us(main_device: &MainDevice<'_>, address: u16) -> Result<u64, Error> {
    let read = |register: RegisterAddress| Command::fprd(address, register.into());
    let divider = read(RegisterAddress::WatchdogDivider)
        .receive::<u16>(main_device)
        .await?;
    let ticks = read(RegisterAddress::SyncManagerWatchdog)
        .receive::<u16>(main_device)
        .await?;
    Ok(time_us(divider, ticks))
}

fn time_us(divider: u16, ticks: u16) -> u64 {
    (u64::from(divider) + 2) * 40 * u64::from(ticks) / 1000
}

/// Ticks of 100 µs; `None` for a time that would switch the watchdog off or does not fit.
fn ticks(watchdog_ms: u32) -> Option<u16> {
    u16::try_from(watchdog_ms.checked_mul(10)?)
        .ok()
        .filter(|&ticks| ticks > 0)
}

/// Within one percent: with a divider other than the usual one the time may not be exact.
fn close(found_us: u64, expected_us: u64) -> bool {
    found_us.abs_diff(expected_us) * 100 <= expected_us
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reset_values_are_a_hundred_milliseconds() {
        assert_eq!(time_us(DIVIDER_100_US, 1000), 100_000);
        assert_eq!(ticks(100), Some(1000));
        assert_eq!(time_us(u16::MAX, u16::MAX), 65_537 * 40 * 65_535 / 1000);
    }

    #[test]
    fn times_that_cannot_be_set_are_refused() {
        for (watchdog_ms, expected) in [
            (0, None),
            (1, Some(10)),
            (6553, Some(65_530)),
            (6554, None),
            (u32::MAX, None),
        ] {
            assert_eq!(ticks(watchdog_ms), expected, "{watchdog_ms}");
        }
    }

    #[test]
    fn a_percent_is_close_and_off_is_not() {
        assert!(close(99_000, 100_000) && close(101_000, 100_000));
        assert!(!close(98_999, 100_000) && !close(0, 100_000));
    }
}
