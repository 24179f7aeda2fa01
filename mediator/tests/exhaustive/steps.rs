//! Which steps are possible, and what they do.

use super::action::{Action, Fate, Left, ROBOTS};
use super::robot::Robot;
use super::world::{
    AWAY, BEFORE, CUTS, FENCES, MEDIATOR, MESSAGES, MINDS, PROCESSES, SECOND, World,
};

impl World {
    pub fn actions(&self, actions: &mut Vec<Action>) {
        let may = |kind: u8| self.limits.faults > 0 && self.limits.kinds & kind != 0;
        for robot in &self.robots {
            let number = robot.number;
            if robot.client.is_some() {
                if !robot.is_cut && !robot.talked {
                    actions.push(Action::Talk(number, Fate::Arrive));
                    if may(FENCES) {
                        actions.push(Action::Talk(number, Fate::OldFence));
                    }
                    if may(MESSAGES) && self.late.is_none() {
                        use Fate::{AnswerLate, AnswerTwice, ReportLate, ReportTwice};
                        let fates = [ReportLate, ReportTwice, AnswerLate, AnswerTwice];
                        actions.extend(fates.map(|fate| Action::Talk(number, fate)));
                    }
                }
                if robot.may_commit(self.tick, self.limits.without) {
                    actions.push(Action::Commit(number));
                }
                if robot.behind().is_some() {
                    actions.push(Action::Leave(number));
                }
                if may(PROCESSES) {
                    actions.push(Action::Crash(number));
                }
                if may(MINDS) {
                    actions.push(Action::Mind(number));
                }
                if may(CUTS | AWAY) && !robot.is_cut {
                    actions.push(Action::Cut(number));
                }
            } else if number < 2 || may(SECOND) && robot.boots == 0 {
                actions.push(Action::Start(number));
            }
            if robot.is_cut && self.limits.kinds & AWAY == 0 && !self.limits.gone {
                actions.push(Action::Mend(number));
            }
            if robot.committed.is_some() {
                actions.push(Action::Enter(number));
            }
        }
        if self.late.is_some() {
            actions.push(Action::Late);
        }
        if may(MEDIATOR) {
            actions.extend([Action::Restart(Left::All), Action::Restart(Left::Nothing)]);
            if self.journal.get().before.is_some() {
                actions.push(Action::Restart(Left::AllButLast));
            }
        }
        if self.limits.orders > 0 {
            self.orders(actions);
        }
        let heard = |own: &Robot| own.talked || own.is_cut || own.client.is_none();
        if self.tick < BEFORE + self.limits.ticks && self.robots.iter().all(heard) {
            actions.push(Action::Tick);
        }
    }

    /// An operator says only what he sees.
    pub(super) fn orders(&self, actions: &mut Vec<Action>) {
        let bodies = self
            .robots
            .iter()
            .fold(0, |bodies, robot| bodies | robot.body);
        let empty = (0..2).filter(|area| bodies & 1 << area == 0);
        actions.extend(empty.map(Action::Clear));
        let said = { self.robots[..2].iter() }.fold(0, |said, own| said | own.body & own.said_in);
        let full = (0..2).filter(|area| said & 1 << area != 0);
        actions.extend(full.map(Action::Mistake));
        for robot in &self.robots[..2] {
            let same = self.robots.iter().filter(|other| other.id() == robot.id());
            if same.clone().all(|other| other.body == 0) {
                actions.push(Action::Absent(robot.number));
            } else if robot.body != 0 && (robot.is_cut || robot.client.is_none()) {
                actions.push(Action::TakeAway(robot.number));
            }
        }
    }

    /// The state after a step; nothing if it changes nothing.
    pub fn after(&self, action: Action) -> Option<Self> {
        let mut world = self.clone();
        world.step(action)?;
        Some(world)
    }

    pub(super) fn step(&mut self, action: Action) -> Option<()> {
        let tick = self.tick;
        use Action::{Absent, Clear, Crash, Cut, Mind, Mistake, Restart, TakeAway};
        match action {
            Cut(_) | Crash(_) | Mind(_) | Restart(_) | Action::Start(2) => self.limits.faults -= 1,
            Action::Talk(_, fate) if fate != Fate::Arrive => self.limits.faults -= 1,
            Clear(_) | Mistake(_) | Absent(_) | TakeAway(_) => self.limits.orders -= 1,
            _ => {}
        }
        match action {
            Action::Tick => self.pass(),
            Action::Talk(robot, fate) => self.talk(usize::from(robot), fate),
            Action::Late => self.arrive(),
            Action::Commit(robot) => {
                let without = self.limits.without;
                self.robot(robot).commit(tick, without);
            }
            Action::Enter(robot) => self.enter(robot),
            Action::Leave(robot) => {
                self.robot(robot).leave();
            }
            Mind(robot) => self.robot(robot).wants ^= true,
            Cut(robot) => self.robot(robot).is_cut = true,
            Action::Mend(robot) => self.robot(robot).is_cut = false,
            Crash(robot) => self.robot(robot).client = None,
            Action::Start(robot) => self.robot(robot).start(),
            Restart(left) => self.restart(left),
            Clear(area) => return self.clear(area),
            Mistake(area) => return self.mistake(area),
            Absent(robot) => {
                for own in self
                    .robots
                    .iter_mut()
                    .filter(|own| own.id() == ROBOTS[usize::from(robot)])
                {
                    (own.client, own.committed) = (None, None);
                }
                return self.absent(robot);
            }
            TakeAway(robot) => {
                let own = self.robot(robot);
                let was = std::mem::take(&mut own.body);
                own.committed = None;
                own.look(tick);
                let areas = (0..2).filter(|area| was & 1 << area != 0);
                // All or nothing, so that a robot is not out of one of its areas only.
                for area in areas.collect::<Vec<u8>>() {
                    self.clear(area)?;
                }
            }
        }
        if self.limits.faults == 0 && self.journal.get().before.is_some() {
            // Nobody will ask for it any more.
            self.journal
                .change_by("is the last", |journal| journal.before = None);
        }
        Some(())
    }

    pub(super) fn robot(&mut self, robot: u8) -> &mut Robot {
        &mut self.robots[usize::from(robot)]
    }

    pub(super) fn enter(&mut self, robot: u8) {
        let own = self.robot(robot);
        let Some((area, _)) = own.committed.take() else {
            return;
        };
        own.body |= 1 << area;
        let fence = own.fence(area);
        let last = &mut self.fences[usize::from(area)];
        let old = fence < last.0 || fence == last.0 && robot != last.1;
        if fence > 0 && old && !self.lost && self.limits.without.is_none() {
            self.wrong = Some("a fence has not grown");
        }
        *last = (fence, robot).max(*last);
    }
}
