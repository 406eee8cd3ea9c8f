//! What `think` does: beats and received bytes in, frames out.

use amiro_ipf::filter::ParticleSet;
use amiro_ipf::link::{BoardStatus, DeviceEndpoint, Message};
use amiro_ipf::node::{Config, Input, Node, Source};
use amiro_ipf::supervision::{LoadGuard, Mode, Supervision, Task};

use crate::board::{self, Introduction, Loader};
use crate::clock::{BEATS, CycleCounter, uptime_ms};
use crate::link::{Inbox, Outbox};
use crate::sampler::{Report, Reported, want_calibration};
use crate::watch::{ROLL, is_shutdown_wanted};
use amiro_ipf::board::budget::{CAPACITY, INPUT_ROOM, RECEIVE_QUEUE};

/// Beats between two looks at the stack: a second.
const SUPERVISED_EVERY: u32 = 8;

/// How long a step may take, microseconds: four fifths of a beat.
const STEP_BUDGET_US: u64 = 100_000;

/// The portable program between its queues.
pub(crate) struct Program {
    terminal: DeviceEndpoint<'static, CAPACITY>,
    reported: Reported,
    inbox: Inbox,
    outbox: Outbox,
    cycles: CycleCounter,
    cycles_per_us: u32,
    steps_seen: u32,
    status: BoardStatus,
    supervision: Supervision,
    load: LoadGuard,
    loader: Option<Loader>,
    beats: u32,
}

impl Program {
    /// A program that has introduced itself and, unless something keeps it from that,
    /// begun with the robot's own senses.
    pub(crate) fn start(
        particles: &'static mut ParticleSet<CAPACITY>,
        introduction: Introduction,
        (reported, inbox, outbox): (Reported, Inbox, Outbox),
    ) -> Self {
        let Introduction {
            boot,
            boot_id,
            seed,
            post_mortem,
            supervision,
            loader,
        } = introduction;
        let mut program = Self {
            terminal: DeviceEndpoint::new(Node::new(particles), boot, boot_id),
            reported,
            inbox,
            outbox,
            cycles: CycleCounter::new(boot.core_hz),
            cycles_per_us: boot.core_hz / 1_000_000,
            steps_seen: 0,
            status: BoardStatus::default(),
            supervision,
            load: LoadGuard::new(STEP_BUDGET_US),
            loader,
            beats: 0,
        };
        let Self {
            terminal, outbox, ..
        } = &mut program;
        terminal.introduce(&mut |frame, importance| outbox.send(frame, importance));
        if let Some(post_mortem) = post_mortem {
            program.publish(&Message::PostMortem(post_mortem));
        }
        program.publish(&Message::Supervision(supervision));
        if supervision.mode == Mode::Normal {
            program.inject(&Input::Configure(Config {
                seed,
                source: Source::Board,
                ..Config::default()
            }));
        } else {
            program.terminal.enter_safe_mode();
        }
        program
    }

    fn publish(&mut self, message: &Message) {
        let outbox = &mut self.outbox;
        self.terminal.publish(message, &mut |frame, importance| {
            outbox.send(frame, importance)
        });
    }

    fn inject(&mut self, input: &Input) {
        self.timed(|terminal, outbox| {
            terminal.inject(input, &mut |frame, importance| {
                outbox.send(frame, importance);
            });
        });
    }

    /// Attends to beats, to one report and to one input, until there is none of them.
    pub(crate) fn think(&mut self) {
        loop {
            ROLL.report(Task::Think);
            self.attend_to_beats();
            let reported = self.attend_to_report();
            if !self.attend_to_input() && !reported {
                break;
            }
        }
    }

    /// Takes what the robot's senses report; whether there was anything.
    ///
    /// Waits for no room: a robot that drives cannot be stopped by a slow line. Particle
    /// frames are dropped then, and counted.
    fn attend_to_report(&mut self) -> bool {
        let Some(report) = self.reported.dequeue() else {
            return false;
        };
        match report {
            Report::Input(input) => self.inject(&input),
            Report::Health(health) => self.publish(&Message::Health(health)),
            Report::Offsets(offsets) => self.publish(&Message::Offsets(offsets)),
        }
        true
    }

    /// After a beat: the board's own tick, if it is to make them, and a status.
    fn attend_to_beats(&mut self) {
        let beats = BEATS.take();
        if beats == 0 {
            return;
        }
        self.status.uptime_ms = uptime_ms();
        if self.terminal.node().status().own_ticks {
            self.status.overruns = self.status.overruns.wrapping_add(beats - 1);
            let stamp_us = self.status.uptime_ms * 1000;
            self.inject(&Input::Tick { stamp_us });
        }
        board::live_on(self.status.uptime_ms, self.steps_seen);
        self.supervise();
        self.status.sent_frames = self.outbox.sent();
        self.status.dropped_frames = self.outbox.dropped();
        self.status.broken_frames = self.terminal.broken_frames();
        self.status.lost_bytes = self.inbox.lost();
        let outbox = &mut self.outbox;
        self.terminal.report(self.status, &mut |frame, importance| {
            outbox.send(frame, importance)
        });
    }

    /// After a beat: what the board says of itself, once a second and when it is to be
    /// switched off.
    fn supervise(&mut self) {
        self.beats = self.beats.wrapping_add(1);
        if self.supervision.mode == Mode::ShuttingDown {
            // It was said a beat ago and is on its way.
            if let Some(loader) = self.loader {
                loader.shut_down();
            }
        } else if is_shutdown_wanted() {
            self.supervision.mode = Mode::ShuttingDown;
            self.publish(&Message::Supervision(self.supervision));
        }
        if self.beats.is_multiple_of(SUPERVISED_EVERY) {
            self.supervision.stack_unused = board::unused_stack();
            self.publish(&Message::Supervision(self.supervision));
        }
    }

    /// Lowers the number of particles if a step of the robot's own took too long. A
    /// host's inputs are never thinned out: it waits for its answers.
    fn mind_the_load(&mut self, cycles: u32) {
        let node = self.terminal.node();
        let is_own = node.config().source == Source::Board || node.status().own_ticks;
        let configured = node.config().particles_per_sensor;
        let step_us = u64::from(cycles / self.cycles_per_us.max(1));
        if is_own && let Some(particles_per_sensor) = self.load.took(step_us, configured) {
            let limit = Input::Limit {
                particles_per_sensor,
            };
            let outbox = &mut self.outbox;
            self.terminal.inject(&limit, &mut |frame, importance| {
                outbox.send(frame, importance);
            });
        }
    }

    /// Takes bytes up to the end of a frame, or a queue full of garbage, so that a
    /// beat never waits for more; whether there may be more.
    ///
    /// Waits, by doing nothing, until all events of an input have room in the queue:
    /// an injected run loses nothing. The line wakes `think` when that is so.
    fn attend_to_input(&mut self) -> bool {
        if self.outbox.room() < INPUT_ROOM {
            return false;
        }
        for _ in 0..RECEIVE_QUEUE {
            let Some(byte) = self.inbox.next() else {
                return false;
            };
            let handled = self.timed(|terminal, outbox| {
                terminal.receive(byte, &mut |frame, importance| {
                    outbox.send(frame, importance)
                })
            });
            if self.terminal.take_calibration() {
                want_calibration();
            }
            if handled {
                break;
            }
        }
        true
    }

    /// Does some work and, if it stepped the filter, notes how long that took.
    fn timed<T>(
        &mut self,
        work: impl FnOnce(&mut DeviceEndpoint<'static, CAPACITY>, &mut Outbox) -> T,
    ) -> T {
        let start = self.cycles.now();
        let result = work(&mut self.terminal, &mut self.outbox);
        let steps = self.terminal.node().status().steps;
        if steps != self.steps_seen {
            let cycles = (self.cycles.now() - start).min(u64::from(u32::MAX)) as u32;
            // A new configuration counts its steps, and their most cycles, anew.
            let most = if steps > self.steps_seen {
                self.status.step_cycles_max
            } else {
                self.load.start_over();
                0
            };
            self.status.step_cycles = cycles;
            self.status.step_cycles_max = most.max(cycles);
            self.steps_seen = steps;
            self.mind_the_load(cycles);
        }
        result
    }
}
