//! Any text as a net file: reading it returns, what it refuses can be shown, and what it accepts
//! compiles, can be drawn and analysed, and does nothing in a run that the analysis excludes.

#![no_main]

use config_fuzz::{LIMITS, run};
use coordination::petri::Dot;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let net = match config::parse_net("fuzz.toml", text) {
        Ok(net) => net,
        Err(error) => {
            assert!(!error.problems().is_empty());
            let shown: usize = error.problems().iter().map(|p| p.to_string().len()).sum();
            // Names are repeated in messages, but never without bound.
            assert!(shown < (1 << 20) + 1000 * text.len());
            return;
        }
    };
    let proofs = match net.analyse(&LIMITS) {
        Ok(proofs) => {
            assert_eq!(proofs.len(), net.situations.len());
            proofs
        }
        Err(refusal) => {
            assert!(!refusal.to_string().is_empty());
            Vec::new()
        }
    };
    let uses = net.uses();
    for (number, (situation, model)) in net.models().into_iter().enumerate().take(4) {
        assert_eq!(model.check(), [], "situation `{situation}`");
        assert!(Dot::new(&model).to_string().ends_with("}\n"));
        run(
            &model,
            &uses,
            proofs.get(number),
            text.len() as u64 * 31 + number as u64,
        );
    }
});
