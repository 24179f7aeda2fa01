//! What the programs need is taken.

use std::fs;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::programs::bench::{Bench, RIG, said, shipped};
use crate::programs::late::once_more_if_late;

#[test]
fn a_robot_whose_fleet_port_is_taken_drives_and_a_second_one_of_its_name_is_refused() {
    once_more_if_late(|| {
        let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = taken.local_addr().expect("bound").to_string();
        let mut bench = Bench::new();
        bench.more = vec![format!("fleet.listen=[\"tcp/{address}\"]")];
        bench.start();
        bench.until_driving();
        assert!(bench.log().contains("fleet-network"), "{}", bench.log());

        let output = bench.run(&bench.robot_file());
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        let pid = bench.process().id().to_string();
        assert!(
            said(&output).contains(&pid),
            "expected pid {pid}: {}",
            said(&output)
        );
        assert!(said(&output).contains("amr-1"), "{}", said(&output));
        bench.drives_for(Duration::from_millis(500));
        bench.ask("pause");
        bench.finish();
    });
}

#[test]
fn it_waits_for_devices_that_come_late() {
    once_more_if_late(|| {
        let mut bench = Bench::new();
        // Else whoever released an emergency stop could have it drive off.
        bench.more.push("drive.awaited_s=30.0".to_owned());
        bench.devices.lidar_faults.unplug();
        bench.devices.bus_faults.disappear(0);
        bench.start();
        bench.until("it says what is missing", Duration::from_secs(5), |bench| {
            bench.publishes("lidar-lost") && bench.publishes("bus-lost")
        });
        bench.stands_for(Duration::from_millis(500));
        bench.devices.bus_faults.reappear(0);
        bench.devices.lidar_faults.replug();
        bench.until_driving();
        bench.finish();
    });
}

#[test]
fn devices_refuse_places_that_are_taken() {
    once_more_if_late(|| {
        let bench = Bench::new();
        let address = bench.bus_address();
        let output = devices(&format!("udp:{address}"), "unused");
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        let port = address.rsplit(':').next().expect("an address has a port");
        assert!(said(&output).contains(port), "{}", said(&output));

        let file = bench.path("ordinary");
        fs::write(&file, "mine").expect("written");
        let path = file.display().to_string();
        let output = devices("udp:127.0.0.1:0", &path);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        let message = said(&output).replace(' ', "");
        assert!(message.contains(&path), "{}", said(&output));
        assert_eq!(fs::read_to_string(&file).expect("still there"), "mine");

        let output = devices("no-such-interface", "unused");
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        assert!(
            said(&output).contains("no-such-interface"),
            "{}",
            said(&output)
        );
    });
}

fn devices(ethercat: &str, lidar: &str) -> Output {
    Command::new(RIG)
        .arg("devices")
        .arg("--robot")
        .arg(shipped("robots/amr-1.toml"))
        .arg("--site")
        .arg(shipped("sites/corridor.toml"))
        .args(["--ethercat", ethercat, "--lidar", lidar])
        .current_dir(std::env::temp_dir())
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}
