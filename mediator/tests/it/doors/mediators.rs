//! Two mediators of a site, behind mutual TLS.

use mediator::keys::Keys;

use super::PATIENCE;
use super::hall::{self, Hall};
use crate::program::{Program, folder, free_endpoint};

const NOTICED: &str = "another mediator, ";

/// Another mediator of the same site that connects to the hall's, with a journal of its own.
fn another(hall: &Hall, folder: &tempfile::TempDir, keys: &Keys) -> Program {
    let connect = vec![hall.endpoint.clone()];
    let mut program = Program::new(folder.path(), &hall::site(), connect);
    program.listen(&free_endpoint("tls"));
    program.add(&["--keys", &keys.folder().display().to_string()]);
    program.start();
    program.wait_ready(PATIENCE);
    program
}

#[test]
fn mediators_with_certificates_of_one_site_see_each_other_and_nobody_else() {
    let hall = Hall::open();
    let folders = [(); 3].map(|()| folder());
    let keys = Keys::new(folders[2].path().join("keys"));
    keys.begin("rooms", 30.0).expect("an authority");
    let stranger = another(&hall, &folders[0], &keys);
    let mut second = another(&hall, &folders[1], &hall.keys);
    hall.until("both see each other", || {
        [&hall.program, &second].map(|program| program.log().contains(NOTICED)) == [true; 2]
    });
    second.kill();
    hall.until("the second one is gone", || {
        hall.program.log().contains("is gone")
    });
    // By then the stranger has had longer to be seen.
    let told = |program: &Program| program.log().matches(NOTICED).count();
    assert_eq!((told(&hall.program), told(&stranger)), (1, 0));
    let status = stranger.status().expect("it answers");
    assert!(!status.stands_by);
}
