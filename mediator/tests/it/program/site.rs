//! Site files of any size, for robots without wheels.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Square areas side by side, robots that start in them.
pub struct Site {
    pub name: String,
    /// Names and capacities.
    pub areas: Vec<(String, u32)>,
    /// Ids, roles, and in which area they start.
    pub robots: Vec<(String, &'static str, usize)>,
    /// What every state machine understands besides, and what it outputs then.
    pub events: Vec<(&'static str, &'static str)>,
    /// What follows in the file.
    pub more: String,
    /// Shipped nets that it needs.
    pub nets: Vec<&'static str>,
    /// Names and texts of other ones.
    pub own_nets: Vec<(String, String)>,
}

const SIDE_M: f64 = 8.0;

impl Site {
    pub fn write(&self, folder: &Path) {
        let make = |path: PathBuf, text: &str| {
            std::fs::create_dir_all(path.parent().expect("it has one")).expect("a folder");
            std::fs::write(&path, text).expect("it can be written");
        };
        make(
            folder.join(format!("sites/{}.toml", self.name)),
            &self.text(),
        );
        let shipped = { self.nets.iter() }.map(|&net| (net.to_owned(), shipped_net(net)));
        for (net, text) in shipped.chain(self.own_nets.iter().cloned()) {
            make(folder.join(format!("nets/{net}.toml")), &text);
        }
    }

    /// The site file.
    pub fn text(&self) -> String {
        let mut text = format!("name = \"{}\"\n{FLOOR}", self.name);
        let first = &self.areas[0].0;
        let mut transitions = String::new();
        let mut external = "\"go\"".to_owned();
        for (event, output) in &self.events {
            let _ = write!(external, ", \"{event}\"");
            let _ = writeln!(
                transitions,
                "    {{ from = \"in-{first}\", on = \"{event}\", to = \"in-{first}\", outputs = [\"{output}\"] }},"
            );
        }
        let mut states = String::new();
        for (place, (id, capacity)) in self.areas.iter().enumerate() {
            let x_m = place as f64 * SIDE_M;
            let _ = write!(
                text,
                "[areas.{id}]\nregion = {{ min_m = [{x_m:.1}, 0.0], max_m = [{:.1}, {SIDE_M:.1}] }}\n\
                 capacity = {capacity}\nmanoeuvre = \"any\"\nspeed_limit_m_s = 0.4\ndeviation_limit_m = 0.3\n",
                x_m + SIDE_M
            );
            let next = &self.areas[(place + 1) % self.areas.len()].0;
            let _ = writeln!(
                transitions,
                "    {{ from = \"in-{id}\", on = \"go\", to = \"in-{next}\" }},"
            );
            let _ = writeln!(states, "in-{id} = {{ area = \"{id}\", skill = \"stop\" }}");
        }
        let roles: BTreeSet<&str> = self.robots.iter().map(|(_, role, _)| *role).collect();
        for role in roles {
            let _ = write!(
                text,
                "[fsm.{role}]\ninitial = \"in-{first}\"\nexternal = [{external}]\ntransitions = [\n{transitions}]\n\
                 [fsm.{role}.states]\n{states}"
            );
        }
        for (id, role, place) in &self.robots {
            let x_m = (*place as f64 + 0.5) * SIDE_M;
            let _ = write!(
                text,
                "[robots.{id}]\nrole = \"{role}\"\nstart = {{ x_m = {x_m:.1}, y_m = 4.0, theta_rad = 0.0 }}\nstart_state = \"in-{}\"\n",
                self.areas[*place].0
            );
        }
        text + &self.more
    }
}

/// The text of a net that ships.
pub fn shipped_net(net: &str) -> String {
    let nets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/nets");
    std::fs::read_to_string(nets.join(format!("{net}.toml"))).expect("it ships")
}

/// A net that takes in one robot and lets it go again: its name and its text.
pub fn idle_net(name: &str) -> (String, String) {
    (name.to_owned(), format!("name = \"{name}\"\n{IDLE}"))
}

/// Any robot may play in it, which never asks for an area while it stands in that other one.
pub fn idle_coordination(net: &str, asks: &str, stands_in: &str) -> String {
    format!(
        "[coordinations.{net}]\nnet = \"{net}\"\nalarm_after_s = 30.0\n\
         situations.called = {{ guest = {{ role = \"normal\", asks = [\"{asks}\"], stands_in = [\"{stands_in}\"] }} }}\n"
    )
}

const IDLE: &str = r#"
about = "a robot is taken in and let go"

[roles.guest]
protocol = "visiting"
about = "asks for an area"

[protocols.visiting]
keeper = "mediator"
flags = [{ mediator = "acquire" }, { robot = "acquired" }, { mediator = "release" }, { robot = "released" }]

[places]
outside = "it drives by itself"
taken = "it is asked for its discrete control"
leaving = "it gets its discrete control back"
gone = "it drives by itself again"

[sources]
acquired = "guest.acquired"
released = "guest.released"

[sinks]
acquire = "guest.acquire"
release = "guest.release"

[transitions]
take = { from = ["outside"], to = ["taken", "acquire"] }
let-in = { from = ["taken", "acquired"], to = ["leaving", "release"] }
let-go = { from = ["leaving", "released"], to = ["gone"] }

[ends]
visited = ["gone"]

[situations.called]
about = "it asks for an area"
marked = ["outside"]
"#;

const FLOOR: &str = r#"
[walls.south]
from_m = [0.0, 0.0]
to_m = [8.0, 0.0]

[lanes.east]
from_m = [1.0, 2.0]
to_m = [7.0, 2.0]

[areas]
managed = true

[perception.kinds.none]
tracks = []

[skills.stop]
controller = "stop"
perception = "none"
monitors = []

[monitors.done]
kind = "manoeuvre-done"

"#;

/// The shipped net by which an emergency robot overtakes a normal one, on a site with the areas and events of the corridor.
pub const OVERTAKING: &str = r#"
[roles.emergency]
priority = 1

[coordinations.overtaking]
net = "overtaking"
alarm_after_s = 4.0

[coordinations.overtaking.situations.normal-ahead]
emergency = { role = "emergency", asks = ["1"], holds = ["7"] }
normal = { role = "normal", stands_in = ["1"], holds = ["1"], without = ["2"] }

[coordinations.overtaking.flags.emergency]
e1 = { event = "go-1" }
done1 = { on_output = "in-1" }
e2 = { event = "go-2" }
done2 = { on_output = "in-2" }
release = { event = "resume" }

[coordinations.overtaking.flags.normal]
e5 = { event = "aside" }
done5 = { on_output = "parked" }
e1 = { event = "back" }
done1 = { on_output = "back-in-1" }
release = { event = "resume" }
"#;
