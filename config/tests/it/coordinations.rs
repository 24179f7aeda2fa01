//! `[roles]` and `[coordinations]` of site files.

use std::path::Path;

use config::{SiteConfig, parse_site};

const OVERTAKING: &str = r#"
[roles.normal]
priority = 1

[coordinations.overtaking]
net = "overtaking"

[coordinations.overtaking.situations.normal-ahead]
emergency = { robot = "amr-1", asks = ["1"] }
normal = { role = "normal", holds = ["1"], without = ["2"], states = ["drive-1"], within = { min_m = [1.5, -0.9], max_m = [3.0, 0.0] } }

[coordinations.overtaking.flags.normal]
e5 = { event = "aside" }
done5 = { on_output = "parked" }

[coordinations.overtaking.preempt]
after_s = 60.0
situation = "normal-aside"
yields.normal = { event = "halt", states = ["halt-1"], enters = ["5"] }
"#;

fn corridor() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sites/corridor.toml");
    let text = std::fs::read_to_string(path).expect("the corridor ships");
    text.replace("managed = false", "managed = true")
}

fn site(more: &str) -> Result<SiteConfig, String> {
    parse_site("site.toml", &(corridor() + more), &[])
        .map_err(|error| one_line(&format!("{:?}", miette::Report::new(error))))
}

/// Without line breaks, which depend on the width.
fn one_line(text: &str) -> String {
    let words = text.split_whitespace().filter(|word| *word != "│");
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn a_coordination_is_read_whole() {
    let site = site(OVERTAKING).expect("valid");
    assert_eq!(site.roles["normal"].priority, 1);
    let overtaking = &site.coordinations["overtaking"];
    assert_eq!(overtaking.net, "overtaking");
    assert_eq!(overtaking.alarm_after_s, 30.0);
    let [ahead] = &overtaking.situations[..] else {
        panic!("one situation");
    };
    assert_eq!(ahead.situation, "normal-ahead");
    assert_eq!(ahead.roles["emergency"].robot.as_deref(), Some("amr-1"));
    let normal = &ahead.roles["normal"];
    assert_eq!(
        (&normal.holds[..], &normal.without[..]),
        (&["1".to_owned()][..], &["2".to_owned()][..])
    );
    assert!(
        normal
            .within
            .is_some_and(|region| region.contains([2.0, -0.5].into()))
    );
    assert_eq!(
        overtaking.flags["normal"]["e5"].event.as_deref(),
        Some("aside")
    );
    assert_eq!(
        overtaking.flags["normal"]["done5"].on_output.as_deref(),
        Some("parked")
    );
    let preempt = overtaking.preempt.as_ref().expect("there is one");
    assert_eq!(preempt.situation.as_deref(), Some("normal-aside"));
    assert_eq!(preempt.yields["normal"].enters, ["5"]);
}

/// What must be said when one line of it is wrong.
#[test]
fn every_mistake_is_named() {
    for (right, wrong, said) in [
        ("[roles.normal]", "[roles.norml]", "norml"),
        ("priority = 1", "priority = -1", "priority"),
        ("priority = 1", "priorty = 1", "priorty"),
        ("robot = \"amr-1\"", "robot = \"amr-7\"", "amr-7"),
        ("role = \"normal\"", "role = \"nomal\"", "nomal"),
        ("robot = \"amr-1\", ", "", "neither `role` nor `robot`"),
        ("asks = [\"1\"]", "asks = [\"9\"]", "area `9`"),
        ("holds = [\"1\"]", "holds = \"1\"", "holds"),
        (
            "robot = \"amr-1\"",
            "robot = \"amr-1\", stands_in = [\"8\"]",
            "area `8`",
        ),
        ("without = [\"2\"]", "without = [\"22\"]", "area `22`"),
        (
            "states = [\"drive-1\"]",
            "states = [\"drive-9\"]",
            "drive-9",
        ),
        ("max_m = [3.0, 0.0]", "max_m = [1.0, 0.0]", "within"),
        (
            "{ event = \"aside\" }",
            "{ }",
            "neither `event` nor `on_output`",
        ),
        (
            "{ event = \"aside\" }",
            "{ event = \"a\", on_output = \"b\" }",
            "both",
        ),
        ("after_s = 60.0", "after_s = 6.0", "alarm_after_s"),
        ("after_s = 60.0", "", "after_s"),
        ("states = [\"halt-1\"]", "states = []", "out of the way"),
        ("enters = [\"5\"]", "enters = [\"55\"]", "area `55`"),
        ("net = \"overtaking\"", "", "net"),
    ] {
        assert!(OVERTAKING.contains(right), "{right}");
        let text = OVERTAKING.replace(right, wrong);
        let error = site(&text).expect_err(wrong);
        assert!(error.contains(said), "{wrong}: {error}");
    }
}

#[test]
fn a_site_without_mediator_coordinates_nobody() {
    let text = corridor().replace("managed = true", "managed = false") + OVERTAKING;
    let error = parse_site("site.toml", &text, &[]).expect_err("refused");
    let error = format!("{:?}", miette::Report::new(error));
    assert!(error.contains("areas.managed = true"), "{error}");
    // On the command line it is meant: one robot drives alone.
    let alone = ["areas.managed=false".parse().expect("an override")];
    let site = parse_site("site.toml", &(corridor() + OVERTAKING), &alone).expect("accepted");
    assert!(!site.areas_managed);
}
