//! Taking in a robot's report.

use super::coordinate::KeptChange;
use super::robot::Candidate;
use super::run::Deed;
use super::{Alarm, BadReport, Manager};
use crate::journal::{AccessRecord, Entry};
use contract::level;
use contract::wire::{Access, RobotReport};
use contract::{VERSION, Version};

impl Manager {
    /// Takes in a report, however late, repeated or out of order it is.
    pub fn report(&mut self, report: &RobotReport, now_ns: u64) {
        self.counters.reports += 1;
        let Some(&robot) = self.robot_index.get(&report.robot_id) else {
            self.counters.bad += 1;
            let alarm = Alarm::UnknownRobot(report.robot_id.clone());
            self.refuse_stranger(report, alarm.to_string());
            self.alarms.push(alarm);
            return;
        };
        if self.robots[robot].is_retired(report.boot_epoch) {
            self.counters.stale += 1;
            return;
        }
        if !self.admit(robot, report, now_ns) || !self.recognise(robot, report, now_ns) {
            return;
        }
        let first_heard = !self.robots[robot].registered;
        self.hear(robot, now_ns);
        for access in &report.access {
            let merged = match self.merge(robot, access, now_ns) {
                Err(BadReport::Merge(_)) if first_heard => self.adopt(robot, access, now_ns),
                merged => merged,
            };
            if let Err(what) = merged {
                self.complain(robot, access, what);
            }
        }
        self.merge_revocations(robot, report, first_heard);
        self.place(robot, report);
        self.merge_control(robot, report, first_heard, now_ns);
        self.coordinate(now_ns);
        self.serve();
    }

    /// Whether the report is of the process that speaks for the robot, in its order, and to this mediator.
    fn recognise(&mut self, robot: usize, report: &RobotReport, now_ns: u64) -> bool {
        let state = &mut self.robots[robot];
        let present = state.session > 0 && state.boot_epoch == report.boot_epoch;
        let candidate = state
            .candidate
            .filter(|candidate| candidate.boot_epoch == report.boot_epoch && !present);
        if let Some(candidate) = candidate {
            if report.session != candidate.session || report.mediator_epoch != self.epoch {
                self.tell(robot);
                return false;
            }
            state.promote(candidate);
            self.store_robot(robot);
        } else if !present {
            state.invite(report.boot_epoch, now_ns);
            self.store_robot(robot);
            self.tell(robot);
            return false;
        }
        let state = &mut self.robots[robot];
        if report.sequence <= state.sequence {
            self.counters.stale += 1;
            return false;
        }
        state.sequence = report.sequence;
        if report.session != state.session || report.mediator_epoch != self.epoch {
            // It has not heard of this session yet: what it says may be from before.
            self.tell(robot);
            return false;
        }
        true
    }

    /// Whether the robot speaks our language and drives by our map; otherwise it is told why not.
    fn admit(&mut self, robot: usize, report: &RobotReport, now_ns: u64) -> bool {
        let id = || report.robot_id.clone();
        let alarm = if let Err(mismatch) = VERSION.accept(Version::from(report.version)) {
            Some(Alarm::Version {
                robot: id(),
                mismatch,
            })
        } else if report.site != self.site {
            Some(Alarm::Site {
                robot: id(),
                found: report.site.clone(),
                expected: self.site.clone(),
            })
        } else {
            None
        };
        let Some(alarm) = alarm else {
            if !self.robots[robot].refusal(report.boot_epoch).is_empty() {
                self.robots[robot].refused = None;
                self.robots[robot].candidate = None;
            }
            return true;
        };
        let refusal = alarm.to_string();
        if self.robots[robot].refusal(report.boot_epoch) != refusal {
            self.alarms.push(alarm);
        }
        let state = &mut self.robots[robot];
        state.refused = Some((report.boot_epoch, refusal));
        if state.session == 0 || state.boot_epoch != report.boot_epoch {
            state.candidate = Some(Candidate::refused(report.boot_epoch, now_ns));
        }
        self.tell(robot);
        false
    }

    fn hear(&mut self, robot: usize, now_ns: u64) {
        let state = &mut self.robots[robot];
        state.heard_ns = now_ns;
        let was_heard = state.is_heard();
        let was_silent = std::mem::take(&mut state.silent);
        if was_silent && state.registered {
            let robot = state.id.clone();
            self.alarms.push(Alarm::Back { robot });
        }
        self.robots[robot].registered = true;
        if let Some(place) = self.awaited.iter().position(|&awaited| awaited == robot) {
            self.awaited.swap_remove(place);
            if self.awaited.is_empty() {
                self.touch_all();
            }
        }
        if !was_heard {
            for area in self.waits_for(robot) {
                self.touch(area);
            }
        }
    }

    fn merge(&mut self, robot: usize, access: &Access, now_ns: u64) -> Result<(), BadReport> {
        let level = level::decode(access.level.as_ref())?;
        let Some(&area) = self.area_index.get(&access.area) else {
            return Err(BadReport::UnknownArea);
        };
        let protocol = &self.protocol;
        let runs = &mut self.robots[robot].runs;
        let run = runs.get_or_insert_with(area, || protocol.begin());
        if !run.fence_fits(level, access.fence) {
            self.counters.other_fence += 1;
            return Ok(());
        }
        let news = run.merge(level)?;
        run.complained = false;
        if !news {
            return Ok(());
        }
        let mut changed = false;
        while let Some(run) = self.robots[robot].runs.get_mut(area)
            && let Some(deed) = self.protocol.next_deed(run)
        {
            changed = true;
            match deed {
                Deed::Requested => {
                    self.ticket += 1;
                    run.ticket = self.ticket;
                    run.asked_ns = now_ns;
                    run.why.0 = 0;
                    self.counters.requests += 1;
                    self.enqueue(area, robot);
                }
                Deed::Entered => self.concern(area, robot),
                Deed::GaveBack { entered } => {
                    self.counters.given_back += 1;
                    self.kept_changed(robot, area, KeptChange::GaveBack { entered });
                    self.unconcern(area, robot);
                    self.touch(area);
                }
            }
        }
        if changed {
            // A candidate was told of the level before this one, and must hear the present one first.
            self.robots[robot].candidate = None;
            self.store_run(robot, area);
            self.tell(robot);
        }
        Ok(())
    }

    /// After a power loss the journal may lack the last grants. Until every robot has reported nothing is granted, so what a
    /// robot has on its first report since the start was given to it before.
    fn adopt(&mut self, robot: usize, access: &Access, now_ns: u64) -> Result<(), BadReport> {
        let level = level::decode(access.level.as_ref())?;
        let Some(&area) = self.area_index.get(&access.area) else {
            return Err(BadReport::UnknownArea);
        };
        let behind = self.robots[robot]
            .run(area)
            .is_none_or(|run| run.is_behind(level));
        if !behind {
            return Ok(());
        }
        let record = AccessRecord {
            level,
            fence: access.fence,
            ticket: 0,
        };
        let mut run = self.protocol.resume(record)?;
        self.dequeue(area, robot);
        let asks = run.is_requested();
        if asks {
            self.ticket += 1;
            run.ticket = self.ticket;
            run.asked_ns = now_ns;
        }
        self.robots[robot].runs.set(area, run);
        if asks {
            self.enqueue(area, robot);
        }
        self.counters.adopted += 1;
        self.alarms.push(Alarm::Adopted {
            robot: self.robots[robot].id.clone(),
            area: self.areas[area].id.clone(),
        });
        if access.fence > self.areas[area].fence {
            self.areas[area].fence = access.fence;
            self.entries.push(Entry::Fence {
                area: self.areas[area].id.clone(),
                fence: access.fence,
            });
        }
        self.concern(area, robot);
        self.touch(area);
        self.store_run(robot, area);
        self.tell(robot);
        Ok(())
    }

    pub(super) fn complain(&mut self, robot: usize, access: &Access, what: BadReport) {
        self.counters.bad += 1;
        let area = self.area_index.get(&access.area);
        if let Some(&area) = area
            && let Some(run) = self.robots[robot].runs.get_mut(area)
            && std::mem::replace(&mut run.complained, true)
        {
            return;
        }
        self.alarms.push(Alarm::BadReport {
            robot: self.robots[robot].id.clone(),
            area: access.area.clone(),
            what,
        });
    }

    /// Takes over where the robot stands, and notices where it should not.
    fn place(&mut self, robot: usize, report: &RobotReport) {
        let relocated = self.robots[robot].located != report.located;
        self.robots[robot].located = report.located;
        if relocated {
            for area in self.waits_for(robot) {
                self.touch(area);
            }
        }
        let mut stands_in: Vec<usize> = Vec::with_capacity(report.stands_in.len());
        for id in &report.stands_in {
            match self.area_index.get(id) {
                Some(&area) => stands_in.push(area),
                None => {
                    self.counters.bad += 1;
                    self.alarms.push(Alarm::BadReport {
                        robot: self.robots[robot].id.clone(),
                        area: id.clone(),
                        what: BadReport::UnknownArea,
                    });
                }
            }
        }
        if !report.located {
            // Where it says it stands may be wrong: it may still be where it was.
            stands_in.extend_from_slice(&self.robots[robot].stands_in);
        }
        stands_in.sort_unstable();
        stands_in.dedup();
        let mut new_state = false;
        let mut first = false;
        if report.located {
            // Before that, a robot that has restarted does not know where it was and in which state: we do.
            let state = &mut self.robots[robot];
            first = !std::mem::replace(&mut state.placed, true);
            state.pose = report.pose;
            new_state = state.fsm_state != report.fsm_state;
            if new_state {
                state.fsm_state.clone_from(&report.fsm_state);
            }
        }
        let before = std::mem::replace(&mut self.robots[robot].stands_in, stands_in.clone());
        if first {
            let state = &self.robots[robot];
            let found: Vec<usize> = stands_in
                .iter()
                .copied()
                .filter(|&area| !state.holds(area))
                .collect();
            self.robots[robot].found_in = found;
        } else {
            self.robots[robot]
                .found_in
                .retain(|area| stands_in.contains(area));
        }
        let moved = before != stands_in;
        if moved || new_state {
            self.store_robot(robot);
        }
        for &area in before.iter().filter(|area| !stands_in.contains(area)) {
            self.unconcern(area, robot);
            self.touch(area);
        }
        for &area in stands_in.iter().filter(|area| !before.contains(area)) {
            self.concern(area, robot);
            self.touch(area);
        }
        self.judge_intrusion(robot, &stands_in);
    }

    fn judge_intrusion(&mut self, robot: usize, stands_in: &[usize]) {
        let state = &self.robots[robot];
        let intrudes_in: Vec<usize> = stands_in
            .iter()
            .copied()
            .filter(|&area| state.intrudes(area))
            .collect();
        let before = std::mem::replace(&mut self.robots[robot].intrudes_in, intrudes_in.clone());
        for area in intrudes_in
            .into_iter()
            .filter(|area| !before.contains(area))
        {
            self.touch(area);
            self.alarms.push(Alarm::Intruder {
                robot: self.robots[robot].id.clone(),
                area: self.areas[area].id.clone(),
            });
        }
    }
}
