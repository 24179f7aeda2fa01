//! Whether robots get on once nothing goes wrong any more.

use super::action::Fate;
use super::world::World;

/// Both robots have been in both areas after as many ticks.
const HEALS_WITHIN: u8 = 30;

impl World {
    /// What keeps a robot from its areas when nothing goes wrong any more.
    pub fn stays_stuck(&self) -> Option<String> {
        let mut world = self.clone();
        world.late = None;
        if world.robots[2].boots > 0 {
            // People have to end one of the two.
            return None;
        }
        for robot in &mut world.robots[..2] {
            (robot.is_cut, robot.wants) = (false, true);
            if robot.client.is_none() {
                robot.start();
            }
        }
        let mut been = [0; 2];
        for _ in 0..HEALS_WITHIN {
            for (robot, been) in been.iter_mut().enumerate() {
                let number = world.robots[robot].number;
                world.robots[robot].is_through = false;
                if !world.robots[robot].talked {
                    world.talk(robot, Fate::Arrive);
                }
                if world.robots[robot].may_commit(world.tick, None) {
                    world.robots[robot].commit(world.tick, None);
                }
                world.enter(number);
                *been |= world.robots[robot].body;
                if world.robots[robot].behind().is_some() {
                    world.robots[robot].leave();
                }
            }
            if let Some(what) = world.violation() {
                return Some(what);
            }
            if been == [3, 3] {
                return None;
            }
            world.pass();
            world.clear_what_was_left();
        }
        Some(format!(
            "robots have been in areas {been:?} only, as bits, though nothing went wrong for 29 s"
        ))
    }
}
