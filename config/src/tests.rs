//! Tests.
#[test]
fn shipped_files_load() {
    let robot = crate::load_robot("robots/amr-1.toml", &[])
        .map_err(miette::Report::from)
        .unwrap();
    let site = crate::load_site("sites/corridor.toml", &[])
        .map_err(miette::Report::from)
        .unwrap();
    assert_eq!(robot.threads.len(), 5);
    assert_eq!(site.areas.len(), 7);
    crate::check_together(&robot, &site).unwrap();
}
