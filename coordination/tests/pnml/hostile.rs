//! Documents that mean harm: no panic, no hang, no memory beyond what their length allows.

use std::time::{Duration, Instant};

use coordination::petri::{Binding, NetModel};
use coordination::pnml::{Document, read, read_all};
use proptest::prelude::*;

use super::document;

/// A document of ours with something of everything, as a ground for mutations.
fn ground() -> String {
    let mut net = NetModel::new("gate");
    net.place("free").mark("free").place("inside");
    net.source("asked", Binding::flag("robot", "request"));
    net.sink("may", Binding::event("go"));
    net.transition("enter", &["asked", "free"], &["inside", "may"]);
    net.transition("leave", &["inside"], &["free"]);
    net.exclusion("one", &["free", "inside"])
        .end("idle", &["free"]);
    Document::new(&net).unwrap().to_string()
}

/// Pieces that a mutation puts in.
const PIECES: &[&str] = &[
    "<",
    ">",
    "/>",
    "&",
    "&lt;",
    "&#0;",
    "&#x110000;",
    "&a;",
    "]]>",
    "<![CDATA[",
    "<!--",
    "-->",
    "\"",
    "=",
    " ",
    "<page id=\"g2\">",
    "</page>",
    "<place id=\"p0\"/>",
    "<place id=\"p9\"/>",
    "<referencePlace id=\"r\" ref=\"r\"/>",
    "<arc id=\"a9\" source=\"p0\" target=\"t0\"/>",
    "<text>9</text>",
    "<?xml version=\"1.1\"?>",
    "<!DOCTYPE pnml>",
    "<initialMarking><text>99999999999999999999999</text></initialMarking>",
    "\u{0}",
    "\u{FFFF}",
    "xmlns=\"\"",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_documents_are_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..40_usize, 0..PIECES.len() + 1), 1..6)
    ) {
        let mut text = ground();
        for (at, removed, piece) in changes {
            let boundary = |mut at: usize| {
                while !text.is_char_boundary(at) {
                    at += 1;
                }
                at
            };
            let from = boundary(at.index(text.len()));
            let to = boundary((from + removed).min(text.len()));
            text.replace_range(from..to, PIECES.get(piece).unwrap_or(&""));
        }
        for net in read_all(&text).unwrap_or_default() {
            // What was read can be looked at, whatever it is.
            let _ = (net.check(), net.transitions().len());
        }
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,200}") {
        let _ = read_all(&text);
        let _ = read_all(&document(&text));
    }
}

/// Time is judged with much patience: what is quadratic takes minutes.
fn soon<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let begun = Instant::now();
    let result = work();
    assert!(
        begun.elapsed() < Duration::from_secs(30),
        "{what} takes {:?}",
        begun.elapsed()
    );
    result
}

#[test]
fn entities_are_not_expanded() {
    let mut bomb =
        String::from("<?xml version=\"1.0\"?>\n<!DOCTYPE pnml [\n<!ENTITY a0 \"aaaaaaaaaa\">\n");
    for level in 1..30 {
        bomb += &format!(
            "<!ENTITY a{level} \"{}\">\n",
            format!("&a{};", level - 1).repeat(10)
        );
    }
    bomb += "]>\n<pnml><net id=\"&a29;\"/></pnml>";
    let error = soon("a bomb", || read(&bomb)).unwrap_err().to_string();
    assert!(error.contains("no XML without a document type"), "{error}");
    let outside = "<!DOCTYPE pnml SYSTEM \"file:///etc/passwd\" [<!ENTITY e SYSTEM \"file:///etc/passwd\">]><pnml>&e;</pnml>";
    assert!(read(outside).is_err());
}

#[test]
fn a_million_levels_do_not_end_the_stack() {
    for element in ["<a>", "<page id=\"g\">", "<text>"] {
        let deep = element.repeat(1_000_000);
        assert!(soon("depth", || read(&document(&deep))).is_err());
        let closed = deep
            + &element
                .replace(" id=\"g\"", "")
                .replace('<', "</")
                .repeat(1_000_000);
        assert!(soon("closed depth", || read(&document(&closed))).is_err());
        let own = format!("<toolspecific tool=\"x\" version=\"1\">{closed}</toolspecific>");
        assert!(soon("depth of others", || read(&document(&own))).is_ok());
    }
}

#[test]
fn huge_ids_are_read_and_shown_short() {
    let id = "x".repeat(20_000_000);
    let node = format!("<place id=\"{id}\"/>");
    let net = soon("a long id", || read(&document(&node))).unwrap();
    assert_eq!(net.places().next().unwrap().name.len(), id.len());
    let twice = read(&document(&(node.clone() + &node)))
        .unwrap_err()
        .to_string();
    assert!(twice.len() < 400, "{} bytes", twice.len());
    let number = format!(
        "<place id=\"p\"><initialMarking><text>{}</text></initialMarking></place>",
        "9".repeat(1_000_000)
    );
    let error = read(&document(&number)).unwrap_err().to_string();
    assert!(error.len() < 400, "{} bytes", error.len());
}

#[test]
fn chains_of_references_take_no_square_of_their_length() {
    let count = 60_000;
    let mut text = String::from("<place id=\"r0\"/>");
    for number in 1..=count {
        text += &format!("<referencePlace id=\"r{number}\" ref=\"r{}\"/>", number - 1);
    }
    for number in 0..count {
        text += &format!(
            "<transition id=\"t{number}\"/><arc id=\"a{number}\" source=\"r{count}\" target=\"t{number}\"/>"
        );
    }
    let net = soon("a chain", || read(&document(&text))).unwrap();
    assert!(
        net.transitions()
            .all(|transition| transition.inputs == ["r0"])
    );
}

#[test]
fn more_than_a_net_holds_is_refused_early() {
    let count = NetModel::MAX_PLACES + 1;
    let text: String = (0..count)
        .map(|number| format!("<place id=\"p{number}\"/>"))
        .collect();
    let error = soon("places", || read(&document(&text)))
        .unwrap_err()
        .to_string();
    assert!(
        error.ends_with("place `p65536`: more than 65536 places"),
        "{error}"
    );
}
