//! What has happened: faults that do not happen prove nothing.

use contract::client::ClientCounters;
use mediator::manager::Counters;

macro_rules! tally {
    ($($(#[$about:meta])* $name:ident),* $(,)?) => {
        /// How often each thing has happened.
        #[derive(Clone, Copy, Debug, Default)]
        pub struct Tally {
            $($(#[$about])* pub $name: u64,)*
        }

        impl std::ops::AddAssign for Tally {
            fn add_assign(&mut self, other: Self) {
                $(self.$name += other.$name;)*
            }
        }
    };
}

tally! {
    /// Areas entered.
    moves,
    grants,
    robot_crashes,
    mediator_crashes,
    /// Stops of the mediator before it has written what it was to write,
    before_journal,
    /// after it has, and nobody was told,
    after_journal,
    /// when half of the messages were sent,
    amid_messages,
    /// and when all were.
    after_messages,
    power_losses,
    /// Robots that were out of reach for a while,
    cuts,
    /// areas that an operator took from somebody,
    cleared,
    /// and those that he was not given, since a robot could still enter.
    not_yet_cleared,
    /// All orders of operators,
    orders,
    /// of which those that ended a coordination,
    ended,
    /// or closed an area.
    closed,
    /// Robots that were carried off the floor,
    taken_away,
    /// and said to be absent.
    absent,
    /// Robots that did not know where they are,
    lost,
    /// were wrong about it,
    mistaken,
    /// and stood where they should not.
    intruders,
    /// New processes that stood where the one before could not be, for all that the mediator knew.
    started_elsewhere,
    /// Second mediators,
    spares,
    /// of which those that ran when nothing went wrong any more, and stayed.
    stays,
    /// Writes of the journal that were lost with the power.
    writes_lost,
    /// Journals that were gone or older at the next start,
    journals_lost,
    /// and how often all robots were asked what they have, since another mediator was followed.
    asked,
    /// Second processes of robots,
    seconds,
    /// whose bodies came to the floor,
    bodies,
    /// stood there while nobody spoke for their robot,
    alone,
    /// and of which the mediator has told.
    doubled,
    /// Those of them that had another floor,
    others_floor,
    /// and how often one lost its pose.
    lost_seconds,
    /// Messages of long ago that were delivered.
    replayed,
    /// Reports that were sent with levels and fences of long ago.
    stale_levels,
    /// Reports that were sent to give areas back by fences of grants before.
    late_releases,
    /// Reports that the mediator knew to be from the past,
    stale_reports,
    /// levels of another grant than the present one,
    other_fence,
    /// of which it has told,
    refused,
    /// messages that robots knew to be from the past.
    stale_messages,
    /// Taken over from robots, since the journal lacked it.
    adopted,
    /// And not taken over, since an operator had said that they are absent.
    void,
    forgotten,
    bypassed,
    /// Coordinations begun, also again in another situation.
    coordinations,
    /// Those that ended.
    finished,
    preempted,
    /// Those that ended though a robot was in the way.
    let_go,
    /// The emergency robot drove past.
    passed,
    /// Grants asked back, and the answers.
    revocations,
    yielded,
    kept,
}

impl Tally {
    /// What a mediator has counted until it stopped.
    pub fn add_manager(&mut self, counters: &Counters) {
        self.grants += counters.grants;
        self.stale_reports += counters.stale;
        self.other_fence += counters.other_fence;
        self.revocations += counters.revocations;
    }

    /// What a robot's process has counted until it stopped.
    pub fn add_client(&mut self, counters: &ClientCounters) {
        self.stale_messages += counters.stale;
        self.yielded += counters.yielded;
        self.kept += counters.kept;
    }
}
