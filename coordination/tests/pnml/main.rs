//! PNML in and out: what is read and refused, that our nets come back as they were, and that bad
//! documents do no harm.

mod hostile;
mod reading;
mod refusing;
mod round_trip;

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
