//! The board's end of a link: bytes in, frames out, a node behind it.
//!
//! Portable like the node: the flash image feeds it from a serial port, a test from
//! memory.

use super::{
    BoardStatus, Boot, Decoder, Encoder, LossCounter, Message, MessageRef, Received, Status,
};
use crate::board::offsets::OffsetReport;
use crate::board::supervision::PostMortem;
use crate::node::{Event, Input, InputError, Node, NodeStatus, Source};

/// How a frame is treated when the line cannot keep up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// Dropped first, and counted: particle events.
    BestEffort,
    /// Dropped only when nothing else can be: all other messages.
    Reliable,
}

impl Priority {
    fn of(event: &Event) -> Self {
        match event {
            Event::Particles(_) => Self::BestEffort,
            _ => Self::Reliable,
        }
    }
}

/// A node behind a link.
///
/// The board's own inputs are sent as input frames before they are handled: a
/// recording of a robot contains its readings as one of a host does, and replays
/// alike.
#[derive(Debug)]
pub struct DeviceEndpoint<'a, const N: usize> {
    node: Node<'a, N>,
    boot: Boot,
    decoder: Decoder,
    encoder: Encoder,
    losses: LossCounter,
    broken_frames: u32,
    /// Greetings and calibrations handled since boot.
    requests: u32,
    is_calibration_requested: bool,
    is_safe: bool,
    /// The last offsets that were sent, for a host that connects later.
    offsets: Option<OffsetReport>,
    /// How the boot before this one ended, for a host that connects later.
    post_mortem: Option<PostMortem>,
}

impl<'a, const N: usize> DeviceEndpoint<'a, N> {
    /// An endpoint that introduces itself as `boot`.
    pub fn new(node: Node<'a, N>, boot: Boot, boot_id: u8) -> Self {
        Self {
            node,
            boot,
            decoder: Decoder::new(),
            encoder: Encoder::new(boot_id),
            losses: LossCounter::new(),
            broken_frames: 0,
            requests: 0,
            is_calibration_requested: false,
            is_safe: false,
            offsets: None,
            post_mortem: None,
        }
    }

    /// Enters the safe mode: greetings are answered, everything else is refused.
    pub fn enter_safe_mode(&mut self) {
        self.is_safe = true;
    }

    /// Whether a host has requested new offsets since the last call.
    pub fn take_calibration(&mut self) -> bool {
        core::mem::take(&mut self.is_calibration_requested)
    }

    /// The node behind the link.
    #[must_use]
    pub fn node(&self) -> &Node<'a, N> {
        &self.node
    }

    /// Number of the host's frames that arrived broken, out of order or not at all.
    #[must_use]
    pub fn broken_frames(&self) -> u32 {
        self.broken_frames
    }

    /// Sends the boot message.
    pub fn introduce(&mut self, send: &mut impl FnMut(&[u8], Priority)) {
        send(
            self.encoder.encode(MessageRef::Boot(&self.boot)),
            Priority::Reliable,
        );
    }

    /// Sends the state of the node and of the board.
    pub fn report(&mut self, board: BoardStatus, send: &mut impl FnMut(&[u8], Priority)) {
        let node = self.node.status();
        let node = NodeStatus {
            inputs: node.inputs.wrapping_add(self.requests),
            ..*node
        };
        self.transmit(MessageRef::Status(&Status { node, board }), send);
    }

    /// Sends a message of the board. Offsets and post-mortem records are repeated in
    /// the answer to each greeting.
    pub fn publish(&mut self, message: &Message, send: &mut impl FnMut(&[u8], Priority)) {
        match message {
            Message::Offsets(offsets) => self.offsets = Some(*offsets),
            Message::PostMortem(record) => self.post_mortem = Some(record.clone()),
            _ => {}
        }
        self.transmit(message.into(), send);
    }

    /// Takes one received byte; a frame that is complete with it is handled and answered.
    ///
    /// Returns whether a frame was handled: the caller may then check the room for the
    /// events of the next one.
    pub fn receive(&mut self, byte: u8, send: &mut impl FnMut(&[u8], Priority)) -> bool {
        let Some(received) = self.decoder.push(byte) else {
            return false;
        };
        self.count_losses(&received);
        let Received::Frame { frame, .. } = received else {
            return false;
        };
        let refused = self.handle(&frame.message, send).err();
        let input = frame.sequence;
        self.transmit(MessageRef::Answer { input, refused }, send);
        true
    }

    /// Sends an input of the board itself, then hands it to the node.
    ///
    /// Its readings and odometry are ignored unless the configuration names the board
    /// as their source.
    pub fn inject(&mut self, input: &Input, send: &mut impl FnMut(&[u8], Priority)) {
        if self.is_safe || is_measured(input) && self.node.config().source != Source::Board {
            return;
        }
        send(self.encoder.encode(input), Priority::Reliable);
        // A refusal is counted in the node's status.
        let _ = self.handle_input(input, send);
    }

    /// A host begins a session with a greeting and a number of its own, so a gap before
    /// a greeting is no loss.
    fn count_losses(&mut self, received: &Received) {
        match received {
            Received::Frame { frame, .. } if frame.message == Message::Hello => {
                self.losses.restart();
            }
            _ => {
                let more = u32::from(self.losses.take(received));
                self.broken_frames = self.broken_frames.wrapping_add(more);
            }
        }
    }

    fn handle(
        &mut self,
        message: &Message,
        send: &mut impl FnMut(&[u8], Priority),
    ) -> Result<(), InputError> {
        match message {
            Message::Hello => self.answer_greeting(send),
            Message::Calibrate | Message::Input(_) if self.is_safe => {
                return Err(InputError::SafeMode);
            }
            Message::Calibrate => self.is_calibration_requested = true,
            Message::Input(input)
                if is_measured(input) && self.node.config().source != Source::Link =>
            {
                return Err(InputError::NotTheSource);
            }
            Message::Input(input) => return self.handle_input(input, send),
            _ => return Err(InputError::NotAnInput),
        }
        self.requests = self.requests.wrapping_add(1);
        Ok(())
    }

    /// Sends the boot message and, where they are known, the last post-mortem record and
    /// the offsets.
    fn answer_greeting(&mut self, send: &mut impl FnMut(&[u8], Priority)) {
        self.introduce(send);
        let record = self.post_mortem.as_ref().map(MessageRef::PostMortem);
        let offsets = self.offsets.as_ref().map(MessageRef::Offsets);
        for message in record.into_iter().chain(offsets) {
            send(self.encoder.encode(message), Priority::Reliable);
        }
    }

    fn handle_input(
        &mut self,
        input: &Input,
        send: &mut impl FnMut(&[u8], Priority),
    ) -> Result<(), InputError> {
        let Self { node, encoder, .. } = self;
        node.handle(input, &mut |event| {
            send(encoder.encode(event), Priority::of(event));
        })
    }

    fn transmit(&mut self, message: MessageRef<'_>, send: &mut impl FnMut(&[u8], Priority)) {
        send(self.encoder.encode(message), Priority::Reliable);
    }
}

/// Whether an input is a reading or odometry, which have one source.
fn is_measured(input: &Input) -> bool {
    matches!(
        input,
        Input::Proximity { .. } | Input::Odometry { .. } | Input::Wheels { .. }
    )
}

#[cfg(test)]
mod tests {
    use super::super::WIRE_VERSION;
    use super::*;
    use crate::board::clock_choice::ClockSource;
    use crate::filter::{ParticleSet, Profile};
    use crate::geometry::Pose;
    use crate::model::Sample;
    use crate::node::Config;

    const BOOT: Boot = Boot {
        wire_version: WIRE_VERSION,
        build_id: 0,
        capacity: 8,
        window: 8,
        baud: 0,
        clock: ClockSource::Host,
        core_hz: 0,
    };

    /// Sessions of a greeting and so many ticks, each numbered from 0.
    fn broken_frames_after(sessions: &[u32]) -> u32 {
        let mut particles = ParticleSet::<8>::new();
        let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), BOOT, 0);
        for &ticks in sessions {
            let mut host = Encoder::new(0xa5);
            let tick = Message::Input(Input::Tick { stamp_us: 0 });
            let ticks = (0..ticks).map(|_| tick.clone());
            for message in core::iter::once(Message::Hello).chain(ticks) {
                for byte in host.encode(&message) {
                    endpoint.receive(*byte, &mut |_, _| ());
                }
            }
        }
        endpoint.broken_frames()
    }

    #[test]
    fn a_host_that_starts_over_is_no_broken_frame() {
        // Was 65 536 less the frames of the session before.
        assert_eq!(broken_frames_after(&[10, 10]), 0);
        assert_eq!(broken_frames_after(&[40_000, 10]), 0);
    }

    /// The messages that an endpoint sends for those of a host, with their priorities.
    fn sent(
        endpoint: &mut DeviceEndpoint<'_, 8>,
        host: &mut Encoder,
        messages: &[Message],
    ) -> Vec<(Message, Priority)> {
        let (mut decoder, mut sent) = (Decoder::new(), Vec::new());
        let mut take = |frame: &[u8], priority| {
            for received in frame.iter().filter_map(|byte| decoder.push(*byte)) {
                if let Received::Frame { frame, .. } = received {
                    sent.push((frame.message, priority));
                }
            }
        };
        for message in messages {
            for byte in host.encode(message) {
                endpoint.receive(*byte, &mut take);
            }
        }
        sent
    }

    fn refusals(sent: &[(Message, Priority)]) -> Vec<Option<InputError>> {
        let answer = |(message, _): &(Message, Priority)| match message {
            Message::Answer { refused, .. } => Some(*refused),
            _ => None,
        };
        sent.iter().filter_map(answer).collect()
    }

    #[test]
    fn in_safe_mode_greetings_are_answered_and_all_else_is_refused() {
        let mut particles = ParticleSet::<8>::new();
        let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), BOOT, 0);
        let mut host = Encoder::new(0xa5);
        let inputs = [
            Message::Hello,
            Message::Calibrate,
            Message::Input(Input::Configure(small_config())),
        ];
        let well = refusals(&sent(&mut endpoint, &mut host, &inputs));
        assert_eq!(well, [None; 3]);
        assert!(endpoint.take_calibration());
        endpoint.enter_safe_mode();
        let safe = refusals(&sent(&mut endpoint, &mut host, &inputs));
        let refused = Some(InputError::SafeMode);
        assert_eq!(safe, [None, refused, refused]);
        assert!(!endpoint.take_calibration());
    }

    #[test]
    fn a_request_for_new_offsets_is_reported_once() {
        let mut particles = ParticleSet::<8>::new();
        let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), BOOT, 0);
        assert!(!endpoint.take_calibration());
        let requests = [Message::Calibrate, Message::Calibrate];
        sent(&mut endpoint, &mut Encoder::new(0xa5), &requests);
        assert!(endpoint.take_calibration());
        assert!(!endpoint.take_calibration());
    }

    #[test]
    fn particle_events_are_best_effort_and_all_other_messages_reliable() {
        let mut particles = ParticleSet::<8>::new();
        let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), BOOT, 0);
        let samples = [Sample::Counts(60); 8];
        let moved = |stamp_us, x| Input::Odometry {
            stamp_us,
            pose: Pose::new(x, 0.0, 0.0),
        };
        let mut inputs = Vec::from([Message::Hello, Input::Configure(small_config()).into()]);
        for step in 0..3_u8 {
            let stamp_us = 100_000 * u64::from(step);
            inputs.push(moved(stamp_us, 0.02 * f32::from(step)).into());
            inputs.push(Input::Proximity { stamp_us, samples }.into());
        }
        let sent = sent(&mut endpoint, &mut Encoder::new(0xa5), &inputs);
        let best_effort = sent
            .iter()
            .filter(|(_, priority)| *priority == Priority::BestEffort);
        assert!(best_effort.clone().count() > 0, "{sent:?}");
        for (message, priority) in &sent {
            let is_best_effort = matches!(message, Message::Event(Event::Particles(_)));
            assert_eq!(
                *priority == Priority::BestEffort,
                is_best_effort,
                "{message:?}"
            );
        }
    }

    /// One particle per sensor: the capacity here.
    fn small_config() -> Config {
        Config {
            particles_per_sensor: 1,
            ..Config::amiro(Profile::Plus)
        }
    }

    #[test]
    fn an_input_that_went_missing_or_came_again_is_counted_once() {
        let mut particles = ParticleSet::<8>::new();
        let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), BOOT, 0);
        let mut host = Encoder::new(0xa5);
        let tick = Input::Tick { stamp_us: 0 };
        let frames: [Vec<u8>; 5] = core::array::from_fn(|_| host.encode(&tick).to_vec());
        for (place, broken) in [(0, 0), (1, 0), (1, 1), (4, 3)] {
            for byte in &frames[place] {
                endpoint.receive(*byte, &mut |_, _| ());
            }
            assert_eq!(endpoint.broken_frames(), broken, "frame {place}");
        }
    }
}
