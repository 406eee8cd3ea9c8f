//! The board's end of a link: bytes in, a node behind, frames out.
//!
//! Portable like the node: the flash image feeds it from a serial port, a test from
//! memory.

use super::{Decoder, Encoder, Losses, Message, Outgoing, Received};
use crate::config::Source;
use crate::event::{Boot, Event, OffsetReport, Status};
use crate::fault::Fault;
use crate::input::Input;
use crate::node::Node;

/// How a frame is treated when the line cannot keep up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Importance {
    /// Particle events: dropped first, and counted.
    Detail,
    /// Everything else.
    Essential,
}

impl Importance {
    fn of(event: &Event) -> Self {
        match event {
            Event::Particles(_) => Self::Detail,
            _ => Self::Essential,
        }
    }
}

/// A node behind a link.
///
/// What the board reads itself goes out as input frames before it is handled: a
/// recording of a robot holds its readings just as that of a host does, and replays
/// alike.
#[derive(Debug)]
pub struct Terminal<'a, const N: usize> {
    node: Node<'a, N>,
    boot: Boot,
    decoder: Decoder,
    encoder: Encoder,
    losses: Losses,
    broken_frames: u32,
    calibration_wanted: bool,
    is_safe: bool,
    /// What was last told of the offsets, for a host that comes later.
    offsets: Option<OffsetReport>,
    /// How the life before this one ended, likewise.
    post_mortem: Option<Event>,
}

impl<'a, const N: usize> Terminal<'a, N> {
    /// A terminal that introduces itself as `boot`.
    pub fn new(node: Node<'a, N>, boot: Boot, boot_id: u8) -> Self {
        Self {
            node,
            boot,
            decoder: Decoder::new(),
            encoder: Encoder::new(boot_id),
            losses: Losses::new(),
            broken_frames: 0,
            calibration_wanted: false,
            is_safe: false,
            offsets: None,
            post_mortem: None,
        }
    }

    /// From now on only greetings are answered, and everything else is refused.
    pub fn enter_safe_mode(&mut self) {
        self.is_safe = true;
    }

    /// Whether a host has asked for new offsets since the last call.
    pub fn take_calibration(&mut self) -> bool {
        core::mem::take(&mut self.calibration_wanted)
    }

    /// The node behind the link.
    #[must_use]
    pub fn node(&self) -> &Node<'a, N> {
        &self.node
    }

    /// Input frames that arrived broken, out of order or not at all.
    #[must_use]
    pub fn broken_frames(&self) -> u32 {
        self.broken_frames
    }

    /// Says who speaks.
    pub fn introduce(&mut self, send: &mut impl FnMut(&[u8], Importance)) {
        self.say(&Event::Boot(self.boot), send);
    }

    /// Says who speaks, how the life before ended if it ended by itself, and the offsets
    /// if they are known by now.
    fn greet_back(&mut self, send: &mut impl FnMut(&[u8], Importance)) {
        self.introduce(send);
        if let Some(post_mortem) = &self.post_mortem {
            transmit(&mut self.encoder, post_mortem, send);
        }
        if let Some(offsets) = self.offsets {
            self.say(&Event::Offsets(offsets), send);
        }
    }

    /// Says how things are.
    pub fn report(&mut self, status: Status, send: &mut impl FnMut(&[u8], Importance)) {
        self.say(&Event::Status(status), send);
    }

    /// Takes one received byte; the end of a good frame is handled and answered.
    ///
    /// Whether a frame was handled: the caller may then want to look at the room it
    /// has for the next one's events.
    pub fn receive(&mut self, byte: u8, send: &mut impl FnMut(&[u8], Importance)) -> bool {
        let Some(received) = self.decoder.push(byte) else {
            return false;
        };
        self.count(&received);
        match received {
            Received::Broken(_) => false,
            Received::Frame { frame, .. } => {
                let refused = self.take(&frame.message, send).err();
                let answer = Event::Answer {
                    input: frame.sequence,
                    refused,
                };
                self.say(&answer, send);
                true
            }
        }
    }

    /// Says something of the board's own. Offsets are said again to whoever greets.
    pub fn tell(&mut self, event: &Event, send: &mut impl FnMut(&[u8], Importance)) {
        match event {
            Event::Offsets(offsets) => self.offsets = Some(*offsets),
            Event::PostMortem(_) => self.post_mortem = Some(event.clone()),
            _ => {}
        }
        self.say(event, send);
    }

    /// Hands an input of the board's own to the node, and says so.
    ///
    /// Its readings and odometry are left out unless the configuration names the board
    /// as their source.
    pub fn inject(&mut self, input: &Input, send: &mut impl FnMut(&[u8], Importance)) {
        if self.is_safe || is_measured(input) && self.node.config().source != Source::Board {
            return;
        }
        send(
            self.encoder.encode(Outgoing::Input(input)),
            Importance::Essential,
        );
        // A refusal is counted in the node's status; a board has nobody else to tell.
        let _ = self.handle(input, send);
    }

    /// Every host begins a session with a greeting and a number of its own: a gap before
    /// a greeting is the end of another session.
    fn count(&mut self, received: &Received) {
        match received {
            Received::Frame { frame, .. } if frame.message == Message::Input(Input::Hello) => {
                self.losses.start_over();
            }
            _ => {
                let more = u32::from(self.losses.take(received));
                self.broken_frames = self.broken_frames.wrapping_add(more);
            }
        }
    }

    fn take(
        &mut self,
        message: &Message,
        send: &mut impl FnMut(&[u8], Importance),
    ) -> Result<(), Fault> {
        let Message::Input(input) = message else {
            return Err(Fault::NotAnInput);
        };
        match input {
            Input::Hello => self.greet_back(send),
            _ if self.is_safe => return Err(Fault::SafeMode),
            Input::Calibrate => self.calibration_wanted = true,
            _ if is_measured(input) && self.node.config().source != Source::Link => {
                return Err(Fault::NotTheSource);
            }
            _ => {}
        }
        self.handle(input, send)
    }

    fn handle(
        &mut self,
        input: &Input,
        send: &mut impl FnMut(&[u8], Importance),
    ) -> Result<(), Fault> {
        let Self { node, encoder, .. } = self;
        node.handle(input, &mut |event| transmit(encoder, event, send))
    }

    fn say(&mut self, event: &Event, send: &mut impl FnMut(&[u8], Importance)) {
        transmit(&mut self.encoder, event, send);
    }
}

/// Whether an input is a reading or odometry, which have one source.
fn is_measured(input: &Input) -> bool {
    matches!(
        input,
        Input::Proximity { .. } | Input::Odometry { .. } | Input::Wheels { .. }
    )
}

fn transmit(encoder: &mut Encoder, event: &Event, send: &mut impl FnMut(&[u8], Importance)) {
    send(
        encoder.encode(Outgoing::Event(event)),
        Importance::of(event),
    );
}

#[cfg(test)]
mod tests {
    use super::super::{Decoder, WIRE_VERSION};
    use super::*;
    use crate::config::Config;
    use crate::event::ClockSource;
    use crate::filter::{ParticleSet, Profile};
    use crate::geometry::Pose;
    use crate::sensor::Sample;

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
        let mut terminal = Terminal::new(Node::new(&mut particles), BOOT, 0);
        for &ticks in sessions {
            let mut host = Encoder::new(0xa5);
            let tick = Input::Tick { stamp_us: 0 };
            for input in core::iter::once(Input::Hello).chain((0..ticks).map(|_| tick)) {
                for byte in host.encode(Outgoing::Input(&input)) {
                    terminal.receive(*byte, &mut |_, _| ());
                }
            }
        }
        terminal.broken_frames()
    }

    #[test]
    fn a_host_that_starts_over_is_no_broken_frame() {
        // Was 65 536 less the frames of the session before.
        assert_eq!(broken_frames_after(&[10, 10]), 0);
        assert_eq!(broken_frames_after(&[40_000, 10]), 0);
    }

    /// What a terminal says to inputs: events, and how each may be treated.
    fn said(
        terminal: &mut Terminal<'_, 8>,
        host: &mut Encoder,
        inputs: &[Input],
    ) -> Vec<(Event, Importance)> {
        let (mut decoder, mut said) = (Decoder::new(), Vec::new());
        let mut take = |frame: &[u8], importance| {
            for received in frame.iter().filter_map(|byte| decoder.push(*byte)) {
                if let Received::Frame { frame, .. } = received
                    && let Message::Event(event) = frame.message
                {
                    said.push((event, importance));
                }
            }
        };
        for input in inputs {
            for byte in host.encode(Outgoing::Input(input)) {
                terminal.receive(*byte, &mut take);
            }
        }
        said
    }

    fn refusals(said: &[(Event, Importance)]) -> Vec<Option<Fault>> {
        let answer = |(event, _): &(Event, Importance)| match event {
            Event::Answer { refused, .. } => Some(*refused),
            _ => None,
        };
        said.iter().filter_map(answer).collect()
    }

    #[test]
    fn in_safe_mode_greetings_are_answered_and_all_else_is_refused() {
        let mut particles = ParticleSet::<8>::new();
        let mut terminal = Terminal::new(Node::new(&mut particles), BOOT, 0);
        let mut host = Encoder::new(0xa5);
        let inputs = [
            Input::Hello,
            Input::Calibrate,
            Input::Configure(small_config()),
        ];
        let well = refusals(&said(&mut terminal, &mut host, &inputs));
        assert_eq!(well, [None; 3]);
        assert!(terminal.take_calibration());
        terminal.enter_safe_mode();
        let safe = refusals(&said(&mut terminal, &mut host, &inputs));
        let refused = Some(Fault::SafeMode);
        assert_eq!(safe, [None, refused, refused]);
        assert!(!terminal.take_calibration());
    }

    #[test]
    fn a_wish_for_new_offsets_is_handed_on_once() {
        let mut particles = ParticleSet::<8>::new();
        let mut terminal = Terminal::new(Node::new(&mut particles), BOOT, 0);
        assert!(!terminal.take_calibration());
        let wishes = [Input::Calibrate, Input::Calibrate];
        said(&mut terminal, &mut Encoder::new(0xa5), &wishes);
        assert!(terminal.take_calibration());
        assert!(!terminal.take_calibration());
    }

    #[test]
    fn particles_are_details_and_everything_else_is_not() {
        let mut particles = ParticleSet::<8>::new();
        let mut terminal = Terminal::new(Node::new(&mut particles), BOOT, 0);
        let samples = [Sample::Counts(60); 8];
        let moved = |stamp_us, x| Input::Odometry {
            stamp_us,
            pose: Pose::new(x, 0.0, 0.0),
        };
        let mut inputs = Vec::from([Input::Hello, Input::Configure(small_config())]);
        for step in 0..3_u8 {
            let stamp_us = 100_000 * u64::from(step);
            inputs.push(moved(stamp_us, 0.02 * f32::from(step)));
            inputs.push(Input::Proximity { stamp_us, samples });
        }
        let said = said(&mut terminal, &mut Encoder::new(0xa5), &inputs);
        let details = said
            .iter()
            .filter(|(_, importance)| *importance == Importance::Detail);
        assert!(details.clone().count() > 0, "{said:?}");
        for (event, importance) in &said {
            let is_detail = matches!(event, Event::Particles(_));
            assert_eq!(*importance == Importance::Detail, is_detail, "{event:?}");
        }
    }

    /// One particle a sensor, as many as fit here.
    fn small_config() -> Config {
        Config {
            particles_per_sensor: 1,
            ..Config::amiro(Profile::Plus)
        }
    }

    #[test]
    fn an_input_that_went_missing_or_came_again_is_counted_once() {
        let mut particles = ParticleSet::<8>::new();
        let mut terminal = Terminal::new(Node::new(&mut particles), BOOT, 0);
        let mut host = Encoder::new(0xa5);
        let tick = Input::Tick { stamp_us: 0 };
        let frames: [Vec<u8>; 5] =
            core::array::from_fn(|_| host.encode(Outgoing::Input(&tick)).to_vec());
        for (place, broken) in [(0, 0), (1, 0), (1, 1), (4, 3)] {
            for byte in &frames[place] {
                terminal.receive(*byte, &mut |_, _| ());
            }
            assert_eq!(terminal.broken_frames(), broken, "frame {place}");
        }
    }
}
