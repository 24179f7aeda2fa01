//! What the examples show is so.

#[allow(dead_code, reason = "its main function is for the example")]
#[path = "../../examples/lossy_link.rs"]
mod lossy_link;
#[allow(dead_code, reason = "its main function is for the example")]
#[path = "../../examples/machine_and_net.rs"]
mod machine_and_net;

#[test]
fn a_machine_its_net_and_the_machine_of_that_agree() {
    let inputs = ["go", "go", "seen", "contact", "full", "lost", "clear", "go"];
    let lines = machine_and_net::run(&inputs).unwrap();
    assert_eq!(lines.len(), 1 + inputs.len());
    assert_eq!(lines[4], "contact  -> charging     says charge, stop");
    let error = machine_and_net::run(&["go", "fly"]).unwrap_err();
    assert_eq!(error.to_string(), "no `fly`");
}

#[test]
fn two_replicas_agree_however_many_levels_are_lost() {
    let mut rounds = 0;
    for percent in [0, 30, 60, 95] {
        for seed in 1..6 {
            let outcome = lossy_link::run(percent, seed).unwrap();
            assert_eq!(outcome.runs, 50);
            assert_eq!(outcome.lost > 0, percent > 0);
            rounds = outcome.rounds;
        }
    }
    assert!(rounds > 1_000, "with so many lost it takes long: {rounds}");
    let error = lossy_link::run(100, 1).unwrap_err().to_string();
    assert!(error.starts_with("they got stuck in run 0"), "{error}");
}
