//! What `think` does: beats and received bytes in, frames out.

use amiro_ipf::config::{Config, Source};
use amiro_ipf::event::{BoardStatus, Boot, Event, Status};
use amiro_ipf::filter::ParticleSet;
use amiro_ipf::input::Input;
use amiro_ipf::node::Node;
use amiro_ipf::wire::Terminal;

use crate::budget::{CAPACITY, INPUT_ROOM, RECEIVE_QUEUE};
use crate::clock::{BEATS, CycleCounter, uptime_ms};
use crate::link::{Inbox, Outbox};
use crate::sampler::{Report, Reported, want_calibration};

/// The portable program between its queues.
pub(crate) struct Program {
    terminal: Terminal<'static, CAPACITY>,
    reported: Reported,
    inbox: Inbox,
    outbox: Outbox,
    cycles: CycleCounter,
    steps_seen: u32,
    status: BoardStatus,
}

impl Program {
    /// A program that has introduced itself and begun with the robot's own senses.
    pub(crate) fn start(
        particles: &'static mut ParticleSet<CAPACITY>,
        (boot, boot_id): (Boot, u8),
        seed: u64,
        reported: Reported,
        (inbox, mut outbox): (Inbox, Outbox),
    ) -> Self {
        let mut terminal = Terminal::new(Node::new(particles), boot, boot_id);
        let own = Config {
            seed,
            source: Source::Board,
            ..Config::default()
        };
        let mut send = |frame: &[u8], importance| outbox.send(frame, importance);
        terminal.introduce(&mut send);
        terminal.inject(&Input::Configure(own), &mut send);
        Self {
            terminal,
            reported,
            inbox,
            outbox,
            cycles: CycleCounter::new(boot.core_hz),
            steps_seen: 0,
            status: BoardStatus::default(),
        }
    }

    /// Attends to beats, to one report and to one input, until there is none of them.
    pub(crate) fn think(&mut self) {
        loop {
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
        self.timed(|terminal, outbox| {
            let mut send = |frame: &[u8], importance| outbox.send(frame, importance);
            match report {
                Report::Input(input) => terminal.inject(&input, &mut send),
                Report::Health(health) => terminal.tell(&Event::Health(health), &mut send),
                Report::Offsets(offsets) => terminal.tell(&Event::Offsets(offsets), &mut send),
            }
        });
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
            self.timed(|terminal, outbox| {
                terminal.inject(&Input::Tick { stamp_us }, &mut |frame, importance| {
                    outbox.send(frame, importance);
                });
            });
        }
        self.status.dropped_frames = self.outbox.dropped();
        self.status.broken_frames = self.terminal.broken_frames();
        self.status.lost_bytes = self.inbox.lost();
        let status = Status {
            node: *self.terminal.node().status(),
            board: self.status,
        };
        let outbox = &mut self.outbox;
        self.terminal.report(status, &mut |frame, importance| {
            outbox.send(frame, importance)
        });
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
        work: impl FnOnce(&mut Terminal<'static, CAPACITY>, &mut Outbox) -> T,
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
                0
            };
            self.status.step_cycles = cycles;
            self.status.step_cycles_max = most.max(cycles);
            self.steps_seen = steps;
        }
        result
    }
}
