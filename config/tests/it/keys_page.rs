//! The reference page of all keys is the one that the code makes.

#[test]
fn the_reference_page_is_up_to_date() {
    assert!(
        config::reference_page() == include_str!("../../KEYS.md"),
        "run `cargo run -p config --example keys > config/KEYS.md`"
    );
}
