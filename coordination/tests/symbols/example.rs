//! What the example shows is so.

#[allow(dead_code, reason = "its main function is for the example")]
#[path = "../../examples/registration.rs"]
mod registration;

#[test]
fn an_arm_comes_and_goes() {
    let lines = registration::run().unwrap();
    assert_eq!(lines.len(), 7);
    assert_eq!(lines[0], "found urn:example:arms:2#joint/elbow, of `arm`");
    assert!(lines[4].starts_with("refused: `inspector` reads joint/elbow by the metamodel"));
    assert_eq!(lines[5], "the arm is gone: true");
}
