//! Whether a new process of a robot is its next one, or of another body: the one before may be where it was, though nobody hears it.

use super::seconds::{Judged, Speaker};
use super::table::Areas;
use crate::journal::Before;
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;

/// What a report says of the process before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Former {
    /// The journal must know.
    pub(crate) is_news: bool,
    /// It is another body, for all that is known: its boot epoch.
    pub(crate) another: Option<u64>,
}

impl Areas {
    /// A new process speaks for the robot, or may: the one that did until now was last in the areas in which it stood, or which it had and may
    /// have entered unheard; perhaps in none.
    pub(crate) fn note_before(&mut self, robot: usize, speaker: Option<Speaker>) {
        let occupant = &mut self.robots[robot];
        let Some(speaker) = speaker.filter(|_| occupant.is_known) else {
            return;
        };
        let held = { occupant.claims.iter() }.filter(|(_, claim)| claim.is_held());
        let mut areas: Vec<usize> = held.map(|(area, _)| area).collect();
        areas.extend(&occupant.stands_in);
        areas.sort_unstable();
        areas.dedup();
        let stood = if occupant.stands_in.is_empty() {
            Before::Outside
        } else {
            Before::Inside
        };
        occupant.seconds.note_before(speaker, stood, &areas);
    }

    /// The process that speaks for the robot was heard, and its areas are taken in: once it knows where it stands it is the next one of the one
    /// before, or another body is where that was last.
    pub(crate) fn judge_before(&mut self, robot: usize, effects: &mut Effects) -> Former {
        let occupant = &mut self.robots[robot];
        if !occupant.located {
            return self.keep_before(robot);
        }
        match occupant.seconds.judge_before(&occupant.stands_in) {
            None => Former::default(),
            Some(Judged::Next(areas)) => {
                self.free_of_seconds(robot, &areas);
                Former {
                    is_news: true,
                    another: None,
                }
            }
            Some(Judged::Another { process, areas }) => {
                let here = self.names.area_list(occupant.stands_in.iter().copied());
                effects.counters.elsewhere += 1;
                effects.alarms.push(Alarm::StartedElsewhere {
                    robot: self.names.robot_id(robot),
                    here: if here.is_empty() {
                        "no area".to_owned()
                    } else {
                        format!("area {here}")
                    },
                    areas: self.names.area_list(areas.iter().copied()),
                });
                for area in areas {
                    self.concern(area, robot);
                    self.touch(area);
                }
                Former {
                    is_news: true,
                    another: Some(process),
                }
            }
        }
    }

    /// One that does not know where it is and gives areas back all the same says nothing of whoever was in them before.
    fn keep_before(&mut self, robot: usize) -> Former {
        let occupant = &mut self.robots[robot];
        let mut seconds = std::mem::take(&mut occupant.seconds);
        let appear = seconds.keep_before(|area| occupant.has(area));
        occupant.seconds = seconds;
        let is_news = !appear.is_empty();
        for area in appear {
            self.concern(area, robot);
            self.touch(area);
        }
        Former {
            is_news,
            another: None,
        }
    }
}
