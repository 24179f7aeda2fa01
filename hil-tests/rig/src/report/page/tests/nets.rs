//! Nets in a page.

use super::checks::{count, drawing, page};
use super::records::{FIRED, empty, overtaking};
use crate::testing::net;

#[test]
fn a_net_is_drawn_with_its_marking_and_the_order_of_its_firings() {
    let record = overtaking();
    let (page, _) = page(&record);
    let drawn = drawing(&page, "petri");
    let net = &record.nets[0];
    for place in net.places.iter().filter(|place| !place.about.is_empty()) {
        assert!(
            drawn.contains(&format!("<title>{}: ", place.id)),
            "{}",
            place.id
        );
    }
    for transition in &net.transitions {
        assert!(
            drawn.contains(&format!(">{}</text>", transition.id)),
            "{}",
            transition.id
        );
    }
    assert_eq!(
        count(drawn, "class=\"token\""),
        net.situations[0].marked.len()
    );
    let arcs: usize = net
        .transitions
        .iter()
        .map(|own| own.from.len() + own.to.len())
        .sum();
    // A token that is put back is one arc with two tips.
    let tips: usize = drawn
        .match_indices("class=\"tip\"")
        .map(|(at, _)| count(drawn[at..].lines().next().unwrap_or(""), "Z"))
        .sum();
    assert_eq!(tips + count(drawn, "class=\"iotip\""), arcs);
    for (index, name) in FIRED.iter().take(12).enumerate() {
        assert_eq!(count(drawn, "class=\"nrtext\" x="), 12, "{name}");
        assert!(drawn.contains(&format!(">{}</text>", index + 1)), "{name}");
    }
    // The pale ones are the transitions of the other situation, with their arcs.
    let pale = net
        .transitions
        .iter()
        .filter(|own| !FIRED.contains(&own.id.as_str()));
    assert_eq!(
        count(drawn, ">take-parked</text>") + count(drawn, ">stay-aside</text>"),
        pale.count()
    );
    assert!(drawn.contains("class=\"never\""));
    // Ports have the colours of the robots in the roles: `emergency` is amr-2, the second.
    let port = drawn
        .find(">emergency.acquire</text>")
        .expect("it is drawn");
    let group = drawn[..port].rfind("<g class=\"").expect("a group");
    assert!(drawn[group..].starts_with("<g class=\"r1\">"));
}

#[test]
fn a_net_that_never_ran_or_is_too_large_is_told() {
    let mut record = empty("t-junction");
    record.nets = vec![net("t-junction"), net("docking")];
    let (sound, texts) = page(&record);
    assert_eq!(count(&sound, "<svg class=\"petri\""), 2);
    assert_eq!(
        texts.iter().filter(|text| *text == "It never ran.").count(),
        2
    );
    let copies = record.nets[0].transitions.clone();
    for copy in 0..100 {
        record.nets[0]
            .transitions
            .extend(copies.iter().cloned().map(|mut own| {
                own.id = format!("{}-{copy}", own.id);
                own
            }));
    }
    let (large, _) = page(&record);
    assert_eq!(count(&large, "<svg class=\"petri\""), 1);
    assert!(large.contains("The net is too large to be drawn here"));
}
