use super::*;

const SECOND_NS: u64 = 1_000_000_000;
const FAULTS: Blame<'_> = Blame::Faults {
    blamed: &|_, _| true,
    lasts: false,
};
const NOBODY: Blame<'_> = Blame::Faults {
    blamed: &|_, _| false,
    lasts: false,
};

/// By a fault that is to blame for anything.
fn hindered(lasts: bool) -> Blame<'static> {
    Blame::Faults {
        blamed: &|_, _| true,
        lasts,
    }
}

fn latched(fault: Fault) -> FaultTable {
    let mut faults = FaultTable::default();
    faults.raise(fault, 10 * SECOND_NS);
    faults
}

#[test]
fn a_latch_that_something_else_is_to_blame_for_is_reset_and_counted() {
    let faults = latched(Fault::Overruns);
    let stall_ns = 9 * SECOND_NS;
    let stalled = |from_ns, to_ns| (from_ns..=to_ns).contains(&stall_ns);
    for blame in [Blame::Stalls(&stalled), FAULTS] {
        let mut caretaker = Caretaker::default();
        let mut look = |at_s| {
            let care = caretaker.look(&faults, at_s * SECOND_NS, true, blame);
            (care, caretaker.resets)
        };
        assert_eq!(look(10), (Care::None, 0));
        assert_eq!(look(12), (Care::None, 0), "as a person does");
        assert_eq!(look(14), (Care::Reset, 1));
        assert_eq!(look(15), (Care::None, 1), "it takes a while");
        assert_eq!(look(18), (Care::Reset, 2));
        assert_eq!(look(41), (Care::GiveUp(Fault::Overruns), 2), "in vain");
        let gone = caretaker.look(&FaultTable::default(), 50 * SECOND_NS, true, blame);
        assert_eq!((gone, caretaker.resets), (Care::None, 2));
    }
}

/// As of a pivot that is jammed.
#[test]
fn what_comes_back_after_each_reset_is_waited_for_longer_and_longer() {
    let mut caretaker = Caretaker::default();
    let mut faults = FaultTable::default();
    let mut resets_s = Vec::new();
    for at_s in 10..90 {
        faults.raise(Fault::WheelsDisobey, at_s * SECOND_NS);
        if caretaker.look(&faults, at_s * SECOND_NS, false, hindered(true)) == Care::Reset {
            faults.clear(Fault::WheelsDisobey);
            resets_s.push(at_s);
        }
    }
    assert_eq!(resets_s, [14, 22, 36, 62, 88]);
    // What comes much later is another one.
    faults.clear(Fault::WheelsDisobey);
    faults.raise(Fault::WheelsDisobey, 100 * SECOND_NS);
    let mut look = |at_s| caretaker.look(&faults, at_s * SECOND_NS, false, hindered(true));
    assert_eq!([look(103), look(104)], [Care::None, Care::Reset]);
}

#[test]
fn any_other_latch_ends_the_run_at_once() {
    // A stall long before it does not count.
    let stalled = |from_ns, _| from_ns <= 7 * SECOND_NS;
    for blame in [Blame::Stalls(&stalled), NOBODY] {
        let look = |fault, at_s: f64| {
            let at_ns = (at_s * 1e9) as u64;
            Caretaker::default().look(&latched(fault), at_ns, true, blame)
        };
        assert_eq!(look(Fault::Overruns, 10.05), Care::None);
        assert_eq!(look(Fault::Overruns, 10.2), Care::GiveUp(Fault::Overruns));
        assert_eq!(look(Fault::MotorsOff, 10.2), Care::GiveUp(Fault::MotorsOff));
        assert_eq!(look(Fault::BusLost, 100.0), Care::None, "ends by itself");
        let uncertain = Fault::PoseUncertain;
        assert_eq!(look(uncertain, 20.0), Care::None, "it may end by itself");
        assert_eq!(look(uncertain, 41.0), Care::GiveUp(uncertain));
    }
}

#[test]
fn a_stall_excuses_no_latch_that_lateness_cannot_cause() {
    for fault in Fault::ALL {
        let blame = Blame::Stalls(&|_, _| true);
        let care = Caretaker::default().look(&latched(fault), 14 * SECOND_NS, false, blame);
        let expected = match fault.resumes() {
            Resumes::ByItself => Care::None,
            Resumes::Operator if LATCHES.contains(&fault) => Care::Reset,
            Resumes::Operator => Care::GiveUp(fault),
        };
        assert_eq!(care, expected, "{fault:?}");
    }
    assert!(LATCHES.contains(&Fault::Overruns) && !LATCHES.contains(&Fault::MotorsOff));
}

#[test]
fn who_is_stopped_on_purpose_is_left_alone() {
    let look = |faults: &FaultTable, on_purpose| {
        Caretaker::default().look(faults, 20 * SECOND_NS, on_purpose, FAULTS)
    };
    let mut faults = latched(Fault::OperatorStop);
    assert_eq!(look(&faults, true), Care::None);
    assert_eq!(
        look(&faults, false),
        Care::Reset,
        "nobody is there any more"
    );
    faults.raise(Fault::MotorsOff, 11 * SECOND_NS);
    assert_eq!(
        look(&faults, true),
        Care::None,
        "a reset would end the stop"
    );
    let much_later = Caretaker::default().look(&faults, 50 * SECOND_NS, true, FAULTS);
    assert_eq!(much_later, Care::GiveUp(Fault::MotorsOff));
}

#[test]
fn whom_a_fault_hinders_for_long_is_given_up_some_time_after_it() {
    let faults = latched(Fault::BringUpLimit);
    let mut caretaker = Caretaker::default();
    let mut look = |at_s: u64, lasts| {
        let blame = hindered(lasts);
        caretaker.look(&faults, at_s * SECOND_NS, false, blame)
    };
    assert_eq!(look(60, true), Care::Reset);
    assert_eq!(look(70, true), Care::Reset);
    assert_eq!(look(99, false), Care::Reset);
    assert_eq!(look(101, false), Care::GiveUp(Fault::BringUpLimit));
}

/// As while a supervisor hangs.
#[test]
fn whom_a_fault_hinders_without_an_answer_is_given_up_some_time_after_it_too() {
    let faults = latched(Fault::BringUpLimit);
    let mut caretaker = Caretaker::default();
    let mut look = |at_s: u64, lasts| {
        let blame = hindered(lasts);
        let before = caretaker;
        let care = caretaker.look(&faults, at_s * SECOND_NS, false, blame);
        if care == Care::Reset {
            caretaker.asks_nothing(before);
        }
        (care, caretaker.resets)
    };
    assert_eq!(look(60, true), (Care::Reset, 0));
    assert_eq!(look(61, false), (Care::Reset, 0));
    assert_eq!(look(91, false), (Care::GiveUp(Fault::BringUpLimit), 0));
}

#[test]
fn what_is_the_robots_own_counts_more_than_a_stall() {
    let mut faults = latched(Fault::Overruns);
    faults.raise(Fault::DriveFault, 20 * SECOND_NS);
    let stalled = |_, to_ns| to_ns < 15 * SECOND_NS;
    let blame = Blame::Stalls(&stalled);
    let care = Caretaker::default().look(&faults, 21 * SECOND_NS, true, blame);
    assert_eq!(care, Care::GiveUp(Fault::DriveFault));
}

#[test]
fn a_reset_that_was_refused_is_tried_again_where_others_stop_on_purpose() {
    let mut caretaker = Caretaker::default();
    let mut faults = latched(Fault::DriveReturned);
    let at = |s: u64| s * SECOND_NS;
    assert_eq!(caretaker.look(&faults, at(14), true, FAULTS), Care::Reset);
    faults.raise(Fault::OperatorStop, at(14) + SECOND_NS / 3);
    assert_eq!(caretaker.look(&faults, at(16), true, FAULTS), Care::None);
    assert_eq!(caretaker.look(&faults, at(18), true, FAULTS), Care::Reset);
    // Of somebody else: long after the reset.
    faults.clear(Fault::OperatorStop);
    faults.raise(Fault::OperatorStop, at(21));
    assert_eq!(caretaker.look(&faults, at(25), true, FAULTS), Care::None);
}
