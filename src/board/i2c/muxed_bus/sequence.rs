//! The sequence of transactions of a round.

use pca9544a::transactions as mux;
use pca9544a::{Channel, Selection};
use vcnl4020::transactions as part;
use vcnl4020::{Command, IDENTITY, Measurement};

use super::channels::Channels;
use super::counters::MuxedBusCounters;
use super::timing::SECOND_READOUTS_UNTIL_US;
use crate::board::i2c::muxed_bus::{MUX_ADDRESS, SENSOR_CONFIGURATION};
use crate::board::i2c::{BusFault, BusTransaction};
use crate::board::proximity_sensor::ProximitySensor;

/// What the next transaction is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReadoutStep {
    Idle,
    Deselect,
    ConfirmNone,
    Select,
    ConfirmSelected,
    ReadCommand,
    ReadResult,
    ReadAgain,
    ReadOnceMore,
    Identify,
    Stop,
    Configure,
    Start,
    ConfirmStill,
}

/// Result of a readout until the multiplexer has confirmed the channel.
#[derive(Clone, Copy, Debug)]
enum ReadoutResult {
    NothingNew,
    Reading {
        measurement: Measurement,
        torn: bool,
    },
    Configured,
    WrongIdentity,
}

/// One bus with its multiplexer and its four sensors; see the [module](super).
#[derive(Clone, Debug)]
pub struct MuxedBus {
    sensors: [ProximitySensor; 4],
    selection: Selection,
    step: ReadoutStep,
    /// The channel that is read.
    channel: Channel,
    result_so_far: ReadoutResult,
    /// Still to be read in this pass.
    todo: Channels,
    /// To be read once more.
    again: Channels,
    /// Due in this round and not read yet.
    pending: Channels,
    /// Channels with a fresh result in this round. Reading a result clears its ready bit,
    /// so the second pass needs this record.
    fresh: Channels,
    is_second_pass: bool,
    moving: bool,
    began_us: u64,
    counters: MuxedBusCounters,
}

impl MuxedBus {
    /// A bus in an unknown state.
    pub(crate) fn new() -> Self {
        Self {
            sensors: [ProximitySensor::new(); 4],
            selection: Selection::Unknown,
            step: ReadoutStep::Idle,
            channel: Channel::Zero,
            result_so_far: ReadoutResult::NothingNew,
            todo: Channels::NONE,
            again: Channels::NONE,
            pending: Channels::NONE,
            fresh: Channels::NONE,
            is_second_pass: false,
            moving: false,
            began_us: 0,
            counters: MuxedBusCounters::default(),
        }
    }

    /// The sensor on a channel.
    #[must_use]
    pub const fn sensor(&self, channel: Channel) -> &ProximitySensor {
        let [zero, one, two, three] = &self.sensors;
        match channel {
            Channel::Zero => zero,
            Channel::One => one,
            Channel::Two => two,
            Channel::Three => three,
        }
    }

    /// The sensor on a channel, to set its offset.
    pub fn sensor_mut(&mut self, channel: Channel) -> &mut ProximitySensor {
        let [zero, one, two, three] = &mut self.sensors;
        match channel {
            Channel::Zero => zero,
            Channel::One => one,
            Channel::Two => two,
            Channel::Three => three,
        }
    }

    /// What happened since the start.
    #[must_use]
    pub const fn counters(&self) -> MuxedBusCounters {
        self.counters
    }

    /// Whether no round is in progress.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.step == ReadoutStep::Idle
    }

    /// Begins a round, every [`ROUND_PERIOD_US`](super::ROUND_PERIOD_US). `moving` says
    /// whether the robot drives; only then can equal samples mean a stuck sensor.
    ///
    /// Whether it has begun: a round that is still busy goes on, and the new one is
    /// counted as late.
    pub fn begin_round(&mut self, now_us: u64, moving: bool) -> bool {
        if !self.is_idle() {
            self.counters.late = self.counters.late.saturating_add(1);
            return false;
        }
        self.counters.rounds = self.counters.rounds.saturating_add(1);
        self.moving = moving;
        self.began_us = now_us;
        self.is_second_pass = false;
        self.again = Channels::NONE;
        self.todo = Channels::NONE;
        self.fresh = Channels::NONE;
        for channel in Channel::ALL {
            if self.sensor(channel).is_due(now_us) {
                self.todo.insert(channel);
            }
        }
        self.pending = self.todo;
        self.next_readout(now_us);
        true
    }

    /// The transaction to execute now, until [`MuxedBus::answer`] takes its result;
    /// `None` when the round is over. About a hundred instructions.
    pub fn next(&mut self, now_us: u64) -> Option<BusTransaction> {
        let begins = matches!(self.step, ReadoutStep::Deselect | ReadoutStep::Select);
        let elapsed_us = now_us.saturating_sub(self.began_us);
        if self.is_second_pass && begins && elapsed_us >= SECOND_READOUTS_UNTIL_US {
            self.end_round(now_us);
        }
        Some(match self.step {
            ReadoutStep::Idle => return None,
            ReadoutStep::Deselect => const { BusTransaction::of_mux(&mux::deselect(MUX_ADDRESS)) },
            ReadoutStep::Select => BusTransaction::of_mux(&mux::select(MUX_ADDRESS, self.channel)),
            ReadoutStep::ConfirmNone | ReadoutStep::ConfirmSelected | ReadoutStep::ConfirmStill => {
                const { BusTransaction::of_mux(&mux::read_control(MUX_ADDRESS)) }
            }
            ReadoutStep::ReadCommand => const { BusTransaction::of_sensor(&part::read_command()) },
            ReadoutStep::ReadResult => {
                const { BusTransaction::of_sensor(&part::read_measurement()) }
            }
            ReadoutStep::ReadAgain | ReadoutStep::ReadOnceMore => {
                const { BusTransaction::of_sensor(&part::read_proximity()) }
            }
            ReadoutStep::Identify => const { BusTransaction::of_sensor(&part::read_identity()) },
            ReadoutStep::Stop => {
                const { BusTransaction::of_sensor(&part::write_command(Command::STOP)) }
            }
            ReadoutStep::Configure => {
                const { BusTransaction::of_sensor(&part::write_configuration(&SENSOR_CONFIGURATION)) }
            }
            ReadoutStep::Start => {
                const {
                    let start = SENSOR_CONFIGURATION.command();
                    BusTransaction::of_sensor(&part::write_command(start))
                }
            }
        })
    }

    /// Takes the result of the transaction before: the bytes that were read, or how it
    /// failed. Without such a transaction nothing happens. About a hundred instructions.
    pub fn answer(&mut self, now_us: u64, result: Result<&[u8], BusFault>) {
        let answer = match (self.step, result) {
            (ReadoutStep::Idle, _) => return,
            (_, Err(BusFault::HeldLow | BusFault::Overdue)) => {
                self.counters.line_failures = self.counters.line_failures.saturating_add(1);
                self.selection = Selection::Unknown;
                return self.end_round(now_us);
            }
            (ReadoutStep::Deselect | ReadoutStep::ConfirmNone, Err(_)) => {
                return self.mux_failed(now_us);
            }
            (_, Err(_)) => return self.readout_failed(now_us),
            (_, Ok(answer)) => answer,
        };
        match self.step {
            ReadoutStep::Idle => {}
            ReadoutStep::Deselect => self.step = ReadoutStep::ConfirmNone,
            ReadoutStep::ConfirmNone => self.confirm_none(now_us, answer),
            ReadoutStep::Select => self.step = ReadoutStep::ConfirmSelected,
            ReadoutStep::ConfirmSelected => self.confirm_selected(now_us, answer),
            ReadoutStep::ReadCommand => self.command_read(now_us, answer),
            ReadoutStep::ReadResult => self.result_read(now_us, answer),
            ReadoutStep::ReadAgain => {
                self.proximity_read(now_us, answer, ReadoutStep::ReadOnceMore)
            }
            ReadoutStep::ReadOnceMore => {
                self.proximity_read(now_us, answer, ReadoutStep::ConfirmStill)
            }
            ReadoutStep::Identify => self.identified(now_us, answer),
            ReadoutStep::Stop => self.step = ReadoutStep::Configure,
            ReadoutStep::Configure => self.step = ReadoutStep::Start,
            ReadoutStep::Start => self.finish_with(ReadoutResult::Configured),
            ReadoutStep::ConfirmStill => self.confirm_still(now_us, answer),
        }
    }

    fn next_readout(&mut self, now_us: u64) {
        if self.todo == Channels::NONE && !self.is_second_pass {
            self.todo = core::mem::replace(&mut self.again, Channels::NONE);
            self.is_second_pass = true;
        }
        let Some(channel) = self.todo.pop() else {
            return self.end_round(now_us);
        };
        self.channel = channel;
        self.step = match self.selection {
            Selection::Unknown => ReadoutStep::Deselect,
            Selection::None | Selection::Channel(_) => ReadoutStep::Select,
        };
    }

    fn end_round(&mut self, now_us: u64) {
        while let Some(channel) = self.pending.pop() {
            self.sensor_mut(channel).on_failure(now_us);
        }
        self.step = ReadoutStep::Idle;
    }

    fn mux_failed(&mut self, now_us: u64) {
        self.counters.mux_failures = self.counters.mux_failures.saturating_add(1);
        self.selection = Selection::Unknown;
        self.end_round(now_us);
    }

    fn readout_failed(&mut self, now_us: u64) {
        self.selection = Selection::Unknown;
        let channel = self.channel;
        if self.sensor(channel).may_retry() && !self.is_second_pass {
            self.again.insert(channel);
        }
        self.next_readout(now_us);
    }

    fn wrong_channel(&mut self) {
        self.counters.wrong_channel = self.counters.wrong_channel.saturating_add(1);
    }

    fn confirm_none(&mut self, now_us: u64, answer: &[u8]) {
        if mux::selection(answer) != Selection::None {
            self.wrong_channel();
            return self.mux_failed(now_us);
        }
        self.selection = Selection::None;
        self.step = ReadoutStep::Select;
    }

    fn confirm_selected(&mut self, now_us: u64, answer: &[u8]) {
        let wanted = Selection::Channel(self.channel);
        if mux::selection(answer) != wanted {
            self.wrong_channel();
            return self.readout_failed(now_us);
        }
        self.selection = wanted;
        self.step = if self.sensor(self.channel).is_running() {
            ReadoutStep::ReadCommand
        } else {
            ReadoutStep::Identify
        };
    }

    fn command_read(&mut self, now_us: u64, answer: &[u8]) {
        let [command] = *answer else {
            return self.readout_failed(now_us);
        };
        let command = Command(command);
        if !command.is_self_timed() {
            self.step = ReadoutStep::Identify;
        } else if command.proximity_ready() || self.fresh.contains(self.channel) {
            self.fresh.insert(self.channel);
            self.step = ReadoutStep::ReadResult;
        } else {
            self.finish_with(ReadoutResult::NothingNew);
        }
    }

    fn result_read(&mut self, now_us: u64, answer: &[u8]) {
        let Some(measurement) = part::measurement(answer) else {
            return self.readout_failed(now_us);
        };
        self.result_so_far = ReadoutResult::Reading {
            measurement,
            torn: false,
        };
        self.step = ReadoutStep::ReadAgain;
    }

    /// Compares with the value before; another one is taken and `otherwise` follows.
    fn proximity_read(&mut self, now_us: u64, answer: &[u8], otherwise: ReadoutStep) {
        let (Some(proximity), ReadoutResult::Reading { measurement, torn }) =
            (part::result(answer), &mut self.result_so_far)
        else {
            return self.readout_failed(now_us);
        };
        if measurement.proximity == proximity {
            self.step = ReadoutStep::ConfirmStill;
            return;
        }
        measurement.proximity = proximity;
        *torn = true;
        self.step = otherwise;
    }

    fn identified(&mut self, now_us: u64, answer: &[u8]) {
        match *answer {
            [IDENTITY] => self.step = ReadoutStep::Stop,
            [_] => self.finish_with(ReadoutResult::WrongIdentity),
            _ => self.readout_failed(now_us),
        }
    }

    fn finish_with(&mut self, result_so_far: ReadoutResult) {
        self.result_so_far = result_so_far;
        self.step = ReadoutStep::ConfirmStill;
    }

    fn confirm_still(&mut self, now_us: u64, answer: &[u8]) {
        let channel = self.channel;
        if mux::selection(answer) != Selection::Channel(channel) {
            self.wrong_channel();
            self.sensor_mut(channel).count_discarded();
            return self.readout_failed(now_us);
        }
        self.pending.remove(channel);
        let moving = self.moving;
        let result_so_far = self.result_so_far;
        let is_first_pass = !self.is_second_pass;
        let sensor = self.sensor_mut(channel);
        match result_so_far {
            ReadoutResult::Configured => sensor.on_configured(),
            ReadoutResult::WrongIdentity => sensor.on_wrong_identity(now_us),
            ReadoutResult::Reading { measurement, torn } => {
                if torn {
                    sensor.count_torn();
                }
                sensor.on_reading(now_us, measurement, moving);
            }
            ReadoutResult::NothingNew => {
                sensor.on_no_result();
                if is_first_pass {
                    self.again.insert(channel);
                }
            }
        }
        self.next_readout(now_us);
    }
}
