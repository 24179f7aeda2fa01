//! Whether more robots had an area at once than it holds.

use config::SiteConfig;

use crate::network::observations::Owning;

/// Messages of two senders may be heard in the wrong order, and a lost one is repeated after 0.2 s.
const OVERLAP_NS: u64 = 300_000_000;

/// More owners than an area holds, as robot, time, and a sentence.
#[must_use]
pub fn two_owners(
    site: &SiteConfig,
    ownings: &[Owning],
    end_ns: u64,
) -> Vec<(String, u64, String)> {
    let mut found = Vec::new();
    for area in &site.areas {
        let own: Vec<&Owning> = ownings.iter().filter(|own| own.area == area.id).collect();
        for new in &own {
            let released_ns = |own: &Owning| own.released_ns.unwrap_or(end_ns);
            // Those that still had it for a while after this grant.
            let until_ns = new.granted_ns.saturating_add(OVERLAP_NS);
            let together: Vec<&str> = { own.iter() }
                .filter(|other| other.granted_ns <= new.granted_ns && released_ns(other) > until_ns)
                .map(|other| other.robot.as_str())
                .collect();
            let mut robots = together.clone();
            robots.sort_unstable();
            robots.dedup();
            if robots.len() > area.capacity as usize {
                let detail = format!(
                    "area {} holds {}, and {} have it at once, {} by fence {}",
                    area.id,
                    area.capacity,
                    robots.join(", "),
                    new.robot,
                    new.fence
                );
                found.push((new.robot.clone(), new.granted_ns, detail));
            }
        }
    }
    found
}
