//! What the general rules of keys cannot say of a net file: places of three kinds, sets, and protocols with or without
//! alternatives.

use ::coordination::petri::{Binding, PlaceKind};

use super::data::{
    FLAGS, NetArray, NetCommand, NetFlag, NetParty, NetPlace, NetProtocol, NetSet, Places, Sets,
};
use description::keys::{
    Fault, Field, KeyError, List, Map, Need, Page, Section, Source, Texts, Words as _, quoted_list,
};

const ARRAYS: Map = Map("sections [protocols.<id>.arrays.<id>]", Need::Required);
const STARTS: Texts = Texts("an array's id");

const KINDS: [(&str, PlaceKind, &str, &str); 3] = [
    (
        "places",
        PlaceKind::Internal,
        "what a token in the place means",
        "Internal places, each with what a token in it means.",
    ),
    (
        "sources",
        PlaceKind::Source,
        BINDING,
        "Places that a robot's flag, or an event, marks.",
    ),
    (
        "sinks",
        PlaceKind::Sink,
        BINDING,
        "Places whose token sets a flag of the mediator's, or raises an event.",
    ),
];
const MEMBER: &str = "a place's id";
const BINDING: &str = "a flag as \"<role>.<flag>\", or an event's name";

impl Field<Places> for Vec<NetPlace> {
    fn read(s: &dyn Source, _: &'static str, _: &Places, _: Option<Self>) -> Self {
        let mut places = Self::new();
        for (key, kind, expected, _) in KINDS {
            s.table(key, "a table", Need::Optional, &mut |s| {
                let texts = s.each_text(expected).into_iter();
                places.extend(texts.map(|(id, text)| place(id, kind, text)));
            });
        }
        places
    }

    fn document(page: &mut Page, _: &'static str, _: &Places, _: Option<Self>, _: &'static str) {
        for (key, _, expected, about) in KINDS {
            page.table(key, about, |page| {
                let none = Some("none".to_owned());
                page.key(
                    "<id>",
                    expected,
                    none,
                    "Unique among places and transitions.",
                );
            });
        }
    }
}

fn place(id: String, kind: PlaceKind, text: String) -> NetPlace {
    let (about, binding) = match (kind, text.split_once('.')) {
        (PlaceKind::Internal, _) => (text, None),
        (_, Some((role, flag))) => (String::new(), Some(Binding::flag(role, flag))),
        (_, None) => (String::new(), Some(Binding::event(&text))),
    };
    NetPlace {
        id,
        kind,
        about,
        binding,
    }
}

impl Field<Sets> for Vec<NetSet> {
    fn read(s: &dyn Source, key: &'static str, _: &Sets, _: Option<Self>) -> Self {
        let mut sets = Self::new();
        s.table(key, "a table", Need::Optional, &mut |s| {
            let texts = s.each_texts(MEMBER).into_iter();
            sets.extend(texts.map(|(id, places)| NetSet { id, places }));
        });
        sets
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &Sets,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.table(key, about, |page| {
            let (value, none) = (format!("an array: {}", MEMBER), "none".to_owned());
            page.key("<id>", value, Some(none), "The places of one set.");
        });
    }
}

impl Section for NetProtocol {
    const ABOUT: &'static str = "Flags in the order in which they are set: in one array, or in several that make alternatives.";
    const KEYS: &'static [&'static str] = &["keeper", "flags", "start", "arrays"];

    fn read(s: &dyn Source) -> Self {
        let keeper = s.word("keeper", NetParty::WORDS, Need::Optional);
        let (start, arrays) = if s.has("arrays") {
            let start = Field::read(s, "start", &STARTS, None);
            (start, Field::read(s, "arrays", &ARRAYS, None))
        } else {
            let array = NetArray {
                id: "flags".to_owned(),
                flags: Field::read(s, "flags", &List(FLAGS, Need::Required), None),
                then: Vec::new(),
            };
            (Vec::new(), vec![array])
        };
        Self {
            id: s.name().to_owned(),
            keeper: keeper.map(NetParty::of),
            start,
            arrays,
        }
    }

    fn check(&self) -> Result<(), KeyError> {
        Ok(())
    }

    fn document(page: &mut Page) {
        let or = |text: &str| Some(text.to_owned());
        page.key(
            "keeper",
            quoted_list(NetParty::WORDS, "or"),
            or("nobody"),
            "Who may give up a run in the middle.",
        );
        page.key(
            "flags",
            format!("an array of {FLAGS}"),
            or("`arrays`"),
            "The only array of a protocol without alternatives.",
        );
        <Vec<String> as Field<_>>::document(
            page,
            "start",
            &STARTS,
            None,
            "With `arrays`: those that a run can begin with; none: the first.",
        );
        page.table("flags[]", NetFlag::ABOUT, <NetFlag as Section>::document);
        page.table("arrays", "", |page| {
            page.table("<id>", NetArray::ABOUT, <NetArray as Section>::document);
        });
    }

    fn excuse(s: &dyn Source) {
        for key in Self::KEYS {
            let _ = s.has(key);
        }
    }
}

impl Section for NetFlag {
    const ABOUT: &'static str =
        "One entry of an array: a flag of the robot's or of the mediator's.";
    const KEYS: &'static [&'static str] = &["robot", "mediator"];

    fn read(s: &dyn Source) -> Self {
        let wrong = |key: &str, found: &str, expected: &str| {
            let (found, expected) = (found.to_owned(), expected.to_owned());
            s.refuse(Fault::Inconsistent, key, found, expected);
        };
        let one = "exactly one of `robot` and `mediator`";
        let (flag, by) = match (s.has("robot"), s.has("mediator")) {
            (true, false) => (s.id("robot", "a flag"), NetParty::Robot),
            (false, true) => (s.id("mediator", "a flag"), NetParty::Mediator),
            (true, true) => {
                wrong("mediator", "both of them", one);
                (String::new(), NetParty::Mediator)
            }
            // Reported as missing.
            (false, false) => (s.id("robot", one), NetParty::Robot),
        };
        let command = match by {
            NetParty::Mediator => <NetCommand as Section>::read(s),
            NetParty::Robot => {
                for key in NetCommand::KEYS {
                    if s.has(key) && !flag.is_empty() {
                        let found = format!("`{key}` with the robot's flag `{flag}`");
                        wrong(key, &found, "commands only with flags of the mediator");
                    }
                }
                NetCommand::default()
            }
        };
        Self { flag, by, command }
    }

    fn check(&self) -> Result<(), KeyError> {
        Section::check(&self.command)
    }

    fn document(page: &mut Page) {
        for (key, other) in [("robot", "`mediator`"), ("mediator", "`robot`")] {
            let about = "The flag, and who sets it.";
            page.key(key, "a flag", Some(other.to_owned()), about);
        }
        <NetCommand as Section>::document(page);
    }

    fn excuse(s: &dyn Source) {
        <NetCommand as Section>::excuse(s);
    }
}
