//! What a safe net has not is refused, with line, element and what was expected.

use coordination::petri::NetModel;
use coordination::pnml::{Document, MAX_DEPTH, read};

use super::document;

fn refused(text: &str) -> String {
    read(text).expect_err("it is wrong").to_string()
}

#[test]
fn what_our_nets_cannot_have_is_named() {
    let nodes = r#"<place id="p"/><transition id="t"/>"#;
    let cases = [
        (
            "<place id=\"p\"><initialMarking>\n<text>2</text></initialMarking></place>".to_owned(),
            "line 4, place `p`: found 2 tokens; expected 0 or 1, as the net is safe",
        ),
        (
            "<place id=\"p\"><initialMarking><text>-1</text></initialMarking></place>".to_owned(),
            "line 4, initialMarking: found `-1`; expected 0 or 1, as the net is safe",
        ),
        (
            format!("{nodes}\n<arc id=\"a\" source=\"p\" target=\"t\"><inscription><text>2</text></inscription></arc>"),
            "line 5, arc `a`: found weight 2; expected weight 1, as the net is safe",
        ),
        (
            format!("{nodes}\n<arc id=\"a\" source=\"p\" target=\"t\"><inscription><text>0</text></inscription></arc>"),
            "line 5, arc `a`: found weight 0; expected weight 1, as the net is safe",
        ),
        (
            format!("{nodes}<arc id=\"a\" source=\"p\" target=\"t\"/>\n<arc id=\"b\" source=\"p\" target=\"t\"/>"),
            "line 5, arc `b`: a second arc from `p` to `t` makes two tokens; expected arcs of weight 1",
        ),
        (
            format!("{nodes}<arc id=\"a\" source=\"p\" target=\"t\">\n<type value=\"inhibitor\"/></arc>"),
            "line 5, type: found an element that no place/transition net has here; expected an element `name`, `inscription`, `graphics`, `toolspecific`",
        ),
        (
            format!("{nodes}<place id=\"p\"/>"),
            "line 4, place `p`: this id is taken, by the element in line 4; expected one of its own",
        ),
        (
            format!("{nodes}<arc id=\"a\" source=\"p\" target=\"p\"/>"),
            "line 4, arc `a`: `p` is a place; expected a transition of this net",
        ),
        (
            format!("{nodes}<arc id=\"a\" source=\"t\" target=\"x\"/>"),
            "line 4, arc `a`: `x` is no node of this net; expected a place of this net",
        ),
        (
            format!("{nodes}<arc id=\"a\" source=\"g\" target=\"t\"/>"),
            "line 4, arc `a`: `g` is no node of this net; expected a place or transition of this net",
        ),
        (
            format!("{nodes}<referencePlace id=\"r\" ref=\"t\"/>"),
            "line 4, referencePlace `r`: `t` is a transition; expected a place or reference place of this net",
        ),
        (
            "<referencePlace id=\"r\" ref=\"s\"/><referencePlace id=\"s\" ref=\"r\"/>".to_owned(),
            "line 4, referencePlace `r`: the references go round in a circle; expected them to lead to a node",
        ),
        ("<place/>".to_owned(), "line 4, place: id is missing"),
        (
            "<arc id=\"a\" source=\"p\"/>".to_owned(),
            "line 4, arc `a`: target is missing",
        ),
        (
            "<place id=\"p\">token</place>".to_owned(),
            "line 4, place `p`: found the text `token`; expected an element `name`, `initialMarking`, `graphics`, `toolspecific`",
        ),
        (
            "<place id=\"p\"><toolspecific tool=\"coordination\" version=\"2\"/></place>".to_owned(),
            "line 4, toolspecific: found version `2`; expected version `1`",
        ),
        (
            "<place id=\"p\"><toolspecific tool=\"coordination\" version=\"1\"><sink/></toolspecific></place>".to_owned(),
            "line 4, sink: found something else; expected one `source` or `sink`, with `event` or with `protocol` and `flag`",
        ),
    ];
    for (content, expected) in cases {
        assert_eq!(refused(&document(&content)), expected);
    }
}

#[test]
fn other_kinds_of_nets_and_documents_are_refused() {
    let symmetric = document("").replace("grammar/ptnet", "grammar/symmetricnet");
    assert_eq!(
        refused(&symmetric),
        "line 3, net `n`: found a net of type `http://www.pnml.org/version-2009/grammar/symmetricnet`; \
         expected a place/transition net, `http://www.pnml.org/version-2009/grammar/ptnet`"
    );
    assert!(
        refused("<html/>")
            .starts_with("line 1, html: found `html` of namespace ``; expected `pnml`")
    );
    assert_eq!(refused("<pnml/>"), "the document has 0 nets; expected one");
    assert!(
        refused(&document("<place id=\"p\">")).starts_with("line 5: no XML"),
        "{}",
        refused(&document("<place id=\"p\">"))
    );
    let foreign = document("<z:place xmlns:z=\"urn:z\" id=\"p\"/>");
    assert!(refused(&foreign).contains("an element of another namespace"));
}

#[test]
fn pages_nest_only_so_deep() {
    let nested = |depth: usize| {
        let open: String = (0..depth)
            .map(|page| format!("<page id=\"d{page}\">"))
            .collect();
        document(&(open + &"</page>".repeat(depth)))
    };
    // One page stands around them.
    assert!(read(&nested(MAX_DEPTH - 1)).is_ok());
    assert!(refused(&nested(MAX_DEPTH)).contains("more than 64 pages in each other"));
}

#[test]
fn what_cannot_be_said_is_not_written() {
    let mut net = NetModel::new("n");
    net.place("p").mark("p").transition("t", &["p"], &["q"]);
    let error = Document::new(&net).err().unwrap().to_string();
    assert!(
        error.starts_with("the net does not compile: net `n`: "),
        "{error}"
    );
    net.place("q").end("over", &["q"]);
    assert!(Document::new(&net).is_ok());
    net.transition("bell\u{7}\u{1}", &["q"], &["p"]);
    let error = Document::new(&net).err().unwrap().to_string();
    assert_eq!(
        error,
        "`bell\\u{7}\\u{1}` has the character U+0007, which XML cannot hold"
    );
}
