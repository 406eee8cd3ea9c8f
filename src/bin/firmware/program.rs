//! The work of `run`: heartbeats, reports and received bytes in, frames out.

use amiro_ipf::board::supervision::{LoadGuard, Mode, Supervision, Task};
use amiro_ipf::filter::ParticleSet;
use amiro_ipf::link::{BoardStatus, DeviceEndpoint, Message};
use amiro_ipf::node::{Config, Input, Node, Source};

use crate::clock::{CycleCounter, HEARTBEATS, uptime_ms};
use crate::hal::{self, BootInfo, Loader};
use crate::link::{Inbox, Outbox};
use crate::requests::{TASKS, is_shutdown_requested};
use crate::sampler::{Report, Reported, request_calibration};
use amiro_ipf::board::budget::{CAPACITY, INPUT_ROOM, RECEIVE_QUEUE};

/// Heartbeats between two supervision messages: one second.
const SUPERVISED_EVERY: u32 = 8;

/// Budget of a step, microseconds: four fifths of a heartbeat.
const STEP_BUDGET_US: u64 = 100_000;

/// The portable program between its queues.
pub(crate) struct Program {
    endpoint: DeviceEndpoint<'static, CAPACITY>,
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
    heartbeats: u32,
}

impl Program {
    /// A program that has sent nothing.
    #[inline(always)]
    pub(crate) fn new(
        particles: &'static mut ParticleSet<CAPACITY>,
        boot_info: &BootInfo,
        (reported, inbox, outbox): (Reported, Inbox, Outbox),
    ) -> Self {
        let boot = boot_info.boot;
        Self {
            endpoint: DeviceEndpoint::new(Node::new(particles), boot, boot_info.boot_id),
            reported,
            inbox,
            outbox,
            cycles: CycleCounter::new(boot.core_hz),
            cycles_per_us: boot.core_hz / 1_000_000,
            steps_seen: 0,
            status: BoardStatus::default(),
            supervision: boot_info.supervision,
            load: LoadGuard::new(STEP_BUDGET_US),
            loader: boot_info.loader,
            heartbeats: 0,
        }
    }

    /// Sends the boot messages and, in normal mode, configures the node for the robot's own
    /// readings.
    #[inline(never)]
    pub(crate) fn start(&mut self, boot_info: &BootInfo) {
        let Self {
            endpoint, outbox, ..
        } = self;
        endpoint.introduce(&mut |frame, priority| outbox.send(frame, priority));
        if let Some(post_mortem) = &boot_info.post_mortem {
            self.publish(&Message::PostMortem(post_mortem.clone()));
        }
        self.publish(&Message::Supervision(boot_info.supervision));
        if boot_info.supervision.mode == Mode::Normal {
            self.handle(&Input::Configure(Config {
                seed: boot_info.seed,
                source: Source::Board,
                ..Config::default()
            }));
        } else {
            self.endpoint.enter_safe_mode();
        }
    }

    fn publish(&mut self, message: &Message) {
        let outbox = &mut self.outbox;
        self.endpoint
            .publish(message, &mut |frame, priority| outbox.send(frame, priority));
    }

    fn handle(&mut self, input: &Input) {
        self.timed(|endpoint, outbox| {
            endpoint.inject(input, &mut |frame, priority| {
                outbox.send(frame, priority);
            });
        });
    }

    /// Handles heartbeats, one report and one input at a time, until none is left.
    pub(crate) fn run(&mut self) {
        loop {
            TASKS.check_in(Task::Run);
            self.on_heartbeat();
            let reported = self.on_report();
            if !self.on_input() && !reported {
                break;
            }
        }
    }

    /// Handles one report of the sampler; whether there was one.
    ///
    /// Does not wait for room: a slow line must not delay a driving robot's steps.
    /// Particle frames are dropped then, and counted.
    fn on_report(&mut self) -> bool {
        let Some(report) = self.reported.dequeue() else {
            return false;
        };
        match report {
            Report::Input(input) => self.handle(&input),
            Report::Health(health) => self.publish(&Message::Health(health)),
            Report::Offsets(offsets) => self.publish(&Message::Offsets(offsets)),
        }
        true
    }

    /// After a heartbeat: the board's own tick, if it makes them, and a status.
    fn on_heartbeat(&mut self) {
        let heartbeats = HEARTBEATS.take();
        if heartbeats == 0 {
            return;
        }
        self.status.uptime_ms = uptime_ms();
        if self.endpoint.node().status().own_ticks {
            self.status.overruns = self.status.overruns.wrapping_add(heartbeats - 1);
            let stamp_us = self.status.uptime_ms * 1000;
            self.handle(&Input::Tick { stamp_us });
        }
        hal::record_uptime(self.status.uptime_ms, self.steps_seen);
        self.supervise();
        self.status.sent_frames = self.outbox.sent();
        self.status.dropped_frames = self.outbox.dropped();
        self.status.broken_frames = self.endpoint.broken_frames();
        self.status.lost_bytes = self.inbox.lost();
        let outbox = &mut self.outbox;
        self.endpoint.report(self.status, &mut |frame, priority| {
            outbox.send(frame, priority)
        });
    }

    /// After a heartbeat: the supervision message, once per second and when a shutdown was
    /// requested.
    fn supervise(&mut self) {
        self.heartbeats = self.heartbeats.wrapping_add(1);
        if self.supervision.mode == Mode::ShuttingDown {
            // The message was queued at the heartbeat before.
            if let Some(loader) = self.loader {
                loader.shut_down();
            }
        } else if is_shutdown_requested() {
            self.supervision.mode = Mode::ShuttingDown;
            self.publish(&Message::Supervision(self.supervision));
        }
        if self.heartbeats.is_multiple_of(SUPERVISED_EVERY) {
            self.supervision.stack_unused = hal::unused_stack();
            self.publish(&Message::Supervision(self.supervision));
        }
    }

    /// Lowers the number of particles if a step of the board's own readings took too
    /// long. A host waits for its answers, so its inputs are never limited.
    fn limit_load(&mut self, cycles: u32) {
        let node = self.endpoint.node();
        let is_own = node.config().source == Source::Board || node.status().own_ticks;
        let configured = node.config().particles_per_sensor;
        let step_us = u64::from(cycles / self.cycles_per_us.max(1));
        if is_own && let Some(particles_per_sensor) = self.load.on_step(step_us, configured) {
            let limit = Input::Limit {
                particles_per_sensor,
            };
            let outbox = &mut self.outbox;
            self.endpoint.inject(&limit, &mut |frame, priority| {
                outbox.send(frame, priority);
            });
        }
    }

    /// Takes bytes up to the end of a frame, or one queue full of garbage, so that a
    /// heartbeat never waits for more; whether there may be more.
    ///
    /// Does nothing until all events of an input have room in the queue, so that a run
    /// from the host loses nothing. The line releases `run` when there is room.
    fn on_input(&mut self) -> bool {
        if self.outbox.room() < INPUT_ROOM {
            return false;
        }
        for _ in 0..RECEIVE_QUEUE {
            let Some(byte) = self.inbox.next() else {
                return false;
            };
            let handled = self.timed(|endpoint, outbox| {
                endpoint.receive(byte, &mut |frame, priority| outbox.send(frame, priority))
            });
            if self.endpoint.take_calibration() {
                request_calibration();
            }
            if handled {
                break;
            }
        }
        true
    }

    /// Does some work and, if it stepped the filter, records how long that took.
    fn timed<T>(
        &mut self,
        work: impl FnOnce(&mut DeviceEndpoint<'static, CAPACITY>, &mut Outbox) -> T,
    ) -> T {
        let start = self.cycles.now();
        let result = work(&mut self.endpoint, &mut self.outbox);
        let steps = self.endpoint.node().status().steps;
        if steps != self.steps_seen {
            let cycles = (self.cycles.now() - start).min(u64::from(u32::MAX)) as u32;
            // A new configuration starts new step counts and a new maximum of cycles.
            let most = if steps > self.steps_seen {
                self.status.step_cycles_max
            } else {
                self.load.reset();
                0
            };
            self.status.step_cycles = cycles;
            self.status.step_cycles_max = most.max(cycles);
            self.steps_seen = steps;
            self.limit_load(cycles);
        }
        result
    }
}
