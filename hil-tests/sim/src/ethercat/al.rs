//! The application layer's state machine (ETG.1000.6 section 6.4.1): INIT, PREOP, SAFEOP, OP, the error bit and its
//! acknowledgement.

/// Acknowledges an error, in AL control; error pending, in AL status (ETG.1000.6 table 9).
const ERROR_OR_ACKNOWLEDGE: u16 = 0x10;
/// Bits of a state.
const STATE: u16 = 0x0F;

/// Why a SubDevice refused a state or left one: the AL status code (ETG.1000.6 table 11).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlCode(pub u16);

impl AlCode {
    /// No error.
    pub const NONE: AlCode = AlCode(0);
    /// The step is not one of the state machine's.
    pub const INVALID_STATE_CHANGE: AlCode = AlCode(0x0011);
    /// The requested number is no state.
    pub const UNKNOWN_STATE: AlCode = AlCode(0x0012);
    /// BOOT is not offered.
    pub const BOOTSTRAP_NOT_SUPPORTED: AlCode = AlCode(0x0013);
    /// A mailbox SyncManager is set up wrongly.
    pub const INVALID_MAILBOX: AlCode = AlCode(0x0016);
    /// Synchronisation was lost.
    pub const SYNCHRONISATION_ERROR: AlCode = AlCode(0x001A);
    /// Outputs were not written in time.
    pub const WATCHDOG: AlCode = AlCode(0x001B);
    /// The outputs' SyncManager is set up wrongly.
    pub const INVALID_OUTPUTS: AlCode = AlCode(0x001D);
    /// The inputs' SyncManager is set up wrongly.
    pub const INVALID_INPUTS: AlCode = AlCode(0x001E);
    /// The outputs' SyncManager feeds a watchdog whose time is 0.
    pub const INVALID_WATCHDOG: AlCode = AlCode(0x001F);
}

/// A state; states are ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum AlState {
    /// Registers only.
    Init = 1,
    /// Mailbox, if there is one.
    PreOp = 2,
    /// Inputs are valid, outputs are ignored.
    SafeOp = 4,
    /// Outputs act.
    Op = 8,
}

/// State and error of one SubDevice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlStatus {
    state: AlState,
    error: bool,
    code: AlCode,
}

impl Default for AlStatus {
    fn default() -> AlStatus {
        AlStatus {
            state: AlState::Init,
            error: false,
            code: AlCode::NONE,
        }
    }
}

impl AlStatus {
    /// The state.
    #[must_use]
    pub fn state(&self) -> AlState {
        self.state
    }

    /// The last error's code; [`AlCode::NONE`] after a success or an acknowledgement.
    #[must_use]
    pub fn code(&self) -> AlCode {
        self.code
    }

    /// Content of the AL status register.
    #[must_use]
    pub fn register(&self) -> u16 {
        self.state as u16 | if self.error { ERROR_OR_ACKNOWLEDGE } else { 0 }
    }

    /// Takes a write to AL control. `check` judges the SubDevice's settings for a state that is to be entered from
    /// below.
    ///
    /// With an error pending, only a request that acknowledges it, or one for INIT, has any effect.
    pub fn request(&mut self, control: u16, check: impl FnOnce(AlState) -> Result<(), AlCode>) {
        let acknowledges = control & ERROR_OR_ACKNOWLEDGE != 0;
        let wanted = control & STATE;
        if self.error {
            if !acknowledges && wanted != AlState::Init as u16 {
                return;
            }
            self.error = false;
        }
        self.code = AlCode::NONE;
        let wanted = match wanted {
            1 => AlState::Init,
            2 => AlState::PreOp,
            3 => return self.refuse(AlCode::BOOTSTRAP_NOT_SUPPORTED),
            4 => AlState::SafeOp,
            8 => AlState::Op,
            _ => return self.refuse(AlCode::UNKNOWN_STATE),
        };
        let one_up = matches!(
            (self.state, wanted),
            (AlState::Init, AlState::PreOp)
                | (AlState::PreOp, AlState::SafeOp)
                | (AlState::SafeOp, AlState::Op)
        );
        if wanted <= self.state {
            self.state = wanted;
        } else if !one_up {
            self.refuse(AlCode::INVALID_STATE_CHANGE);
        } else if let Err(code) = check(wanted) {
            self.refuse(code);
        } else {
            self.state = wanted;
        }
    }

    /// Falls to `state` on the SubDevice's own account, with an error. Never raises the state.
    pub fn fall(&mut self, state: AlState, code: AlCode) {
        self.state = self.state.min(state);
        self.refuse(code);
    }

    fn refuse(&mut self, code: AlCode) {
        self.error = true;
        self.code = code;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: [AlState; 4] = [AlState::Init, AlState::PreOp, AlState::SafeOp, AlState::Op];

    fn ok(_: AlState) -> Result<(), AlCode> {
        Ok(())
    }

    fn in_state(state: AlState) -> AlStatus {
        AlStatus {
            state,
            ..AlStatus::default()
        }
    }

    #[test]
    fn one_step_up_any_step_down() {
        for (i, from) in STATES.into_iter().enumerate() {
            for (j, to) in STATES.into_iter().enumerate() {
                let mut al = in_state(from);
                al.request(to as u16, ok);
                if j <= i + 1 {
                    assert_eq!(
                        (al.register(), al.code()),
                        (to as u16, AlCode::NONE),
                        "{from:?} to {to:?}"
                    );
                } else {
                    assert_eq!(al.register(), from as u16 | 0x10, "{from:?} to {to:?}");
                    assert_eq!(al.code(), AlCode::INVALID_STATE_CHANGE);
                }
            }
        }
    }

    #[test]
    fn unknown_states_are_refused() {
        for (wanted, code) in [
            (3, AlCode::BOOTSTRAP_NOT_SUPPORTED),
            (0, AlCode::UNKNOWN_STATE),
            (15, AlCode(0x12)),
        ] {
            let mut al = in_state(AlState::PreOp);
            al.request(wanted, ok);
            assert_eq!((al.register(), al.code()), (0x12, code));
        }
    }

    #[test]
    fn settings_are_checked_only_on_the_way_up() {
        let mut al = in_state(AlState::PreOp);
        al.request(4, |state| {
            assert_eq!(state, AlState::SafeOp);
            Err(AlCode::INVALID_OUTPUTS)
        });
        assert_eq!((al.register(), al.code()), (0x12, AlCode::INVALID_OUTPUTS));
        let mut al = in_state(AlState::Op);
        al.request(2, |_| Err(AlCode::INVALID_OUTPUTS));
        assert_eq!(al.register(), 2);
    }

    #[test]
    fn an_error_stays_until_acknowledged() {
        let mut al = in_state(AlState::Op);
        al.fall(AlState::SafeOp, AlCode::WATCHDOG);
        assert_eq!((al.register(), al.code()), (0x14, AlCode::WATCHDOG));
        al.request(8, ok);
        assert_eq!((al.register(), al.code()), (0x14, AlCode::WATCHDOG));
        al.request(0x14, ok);
        assert_eq!((al.register(), al.code()), (0x04, AlCode::NONE));
        al.request(8, ok);
        assert_eq!(al.register(), 8);
        al.fall(AlState::SafeOp, AlCode::WATCHDOG);
        al.request(0x18, ok);
        assert_eq!(al.register(), 8, "acknowledged and raised in one request");
        al.fall(AlState::SafeOp, AlCode::WATCHDOG);
        al.request(1, ok);
        assert_eq!(al.register(), 1, "INIT is always granted");
    }

    #[test]
    fn a_fall_never_raises() {
        let mut al = in_state(AlState::PreOp);
        al.fall(AlState::SafeOp, AlCode::SYNCHRONISATION_ERROR);
        assert_eq!(al.register(), 0x12);
    }
}
