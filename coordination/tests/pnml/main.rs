//! PNML in and out: what is read and refused, that our nets come back as they were, and that bad
//! documents do no harm.

#[allow(dead_code, reason = "its main function is for the example")]
#[path = "../../examples/pnml.rs"]
mod example;
mod hostile;
mod reading;
mod refusing;
mod round_trip;

#[test]
fn the_example_reads_and_writes_what_its_header_says() {
    example::run(&[]).unwrap();
    let file = |name: &str| format!("{}/tests/pnml/{name}.pnml", env!("CARGO_MANIFEST_DIR"));
    example::run(&[&file("printer")]).unwrap();
    example::run(&[&file("workflow"), "paid", "sent"]).unwrap();
    let error = example::run(&[&file("workflow"), "nowhere"]).unwrap_err();
    assert!(error.to_string().contains("nowhere"), "{error}");
    assert!(example::run(&[&file("not there")]).is_err());
}

/// A document with one net, and `content` in its page.
fn document(content: &str) -> String {
    format!(
        r#"<?xml version="1.0"?>
<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">
<net id="n" type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="g">
{content}
</page></net></pnml>"#
    )
}
