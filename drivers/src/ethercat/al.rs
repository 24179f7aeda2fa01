//! The application-layer (AL) state of a SubDevice: ETG.1000.6 section 6.4.1.

use ethercrab::{AlStatusCode, EtherCrabWireRead, SubDeviceState};
use std::fmt;

/// AL state, as in the AL control and AL status registers 0x0120 and 0x0130 (ETG.1000.6 table 9, ETG.1000.4 table 35).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlState {
    /// No communication but registers.
    Init,
    /// Mailbox.
    PreOp,
    /// Firmware update.
    Boot,
    /// Inputs only.
    SafeOp,
    /// Inputs and outputs.
    Op,
    /// A value that the standard does not define, or the states of several SubDevices OR-ed together.
    Other(u8),
}

impl AlState {
    pub(super) fn from_bits(bits: u8) -> AlState {
        match bits & 0x0F {
            1 => AlState::Init,
            2 => AlState::PreOp,
            3 => AlState::Boot,
            4 => AlState::SafeOp,
            8 => AlState::Op,
            other => AlState::Other(other),
        }
    }

    pub(super) fn bits(self) -> u8 {
        match self {
            AlState::Init => 1,
            AlState::PreOp => 2,
            AlState::Boot => 3,
            AlState::SafeOp => 4,
            AlState::Op => 8,
            AlState::Other(bits) => bits,
        }
    }
}

impl From<SubDeviceState> for AlState {
    fn from(state: SubDeviceState) -> AlState {
        AlState::from_bits(u8::from(state))
    }
}

impl fmt::Display for AlState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AlState::Init => f.write_str("INIT"),
            AlState::PreOp => f.write_str("PREOP"),
            AlState::Boot => f.write_str("BOOT"),
            AlState::SafeOp => f.write_str("SAFEOP"),
            AlState::Op => f.write_str("OP"),
            AlState::Other(bits) => write!(f, "state {bits:#x}"),
        }
    }
}

/// AL state, error flag and status code (registers 0x0130 and 0x0134).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlStatus {
    /// The state the SubDevice is in.
    pub state: AlState,
    /// Whether it is there because of an error that has not been acknowledged.
    pub error: bool,
    /// AL status code: the reason (ETG.1000.6 table 11). `None` when it could not be read.
    pub code: Option<u16>,
}

impl AlStatus {
    /// From six bytes that start at register 0x0130.
    pub(super) fn from_registers(bytes: [u8; 6]) -> AlStatus {
        AlStatus {
            state: AlState::from_bits(bytes[0]),
            error: bytes[0] & 0x10 != 0,
            code: Some(u16::from_le_bytes([bytes[4], bytes[5]])),
        }
    }
}

impl fmt::Display for AlStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.state)?;
        if self.error {
            f.write_str(" with error")?;
        }
        match self.code {
            Some(0) => Ok(()),
            // ethercrab's text begins with the number.
            Some(code) => match AlStatusCode::unpack_from_slice(&code.to_le_bytes()) {
                Ok(meaning) => write!(f, ", AL status code {meaning}"),
                Err(_) => write!(f, ", AL status code {code:#06x}"),
            },
            None => f.write_str(", AL status code unknown"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_become_a_readable_status() {
        let status = AlStatus::from_registers([0x14, 0, 0, 0, 0x1B, 0]);
        assert_eq!(
            status,
            AlStatus {
                state: AlState::SafeOp,
                error: true,
                code: Some(0x001B)
            }
        );
        assert_eq!(
            status.to_string(),
            "SAFEOP with error, AL status code 0x001b: Sync manager watchdog"
        );
        assert_eq!(
            AlStatus::from_registers([8, 0, 0, 0, 0, 0]).to_string(),
            "OP"
        );
    }

    #[test]
    fn bits_and_states_agree() {
        for bits in 0..16 {
            assert_eq!(AlState::from_bits(bits).bits(), bits);
        }
    }
}
