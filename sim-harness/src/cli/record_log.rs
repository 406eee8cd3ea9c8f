//! What `record` prints while it records.

use amiro_ipf::board::health::Health;
use amiro_ipf::board::supervision::PostMortem;
use amiro_ipf::link::{Message, Status};
use amiro_ipf::model::SensorMask;
use amiro_ipf::node::Event;
use sim_harness::console;
use sim_harness::device::{
    LinkError, RecordingEvent, counters, counters_in_words, health_text, post_mortem_in_words,
    status_counters,
};

use super::connect;

/// Prints news of a recording, each state once.
#[derive(Debug)]
pub(super) struct RecordLog {
    steps: u32,
    status: Status,
    health: Health,
    /// The state that was printed last.
    shown_health: Option<String>,
    shown_mode: Option<String>,
    shown_end: Option<PostMortem>,
}

impl RecordLog {
    /// A log that begins behind a greeting, at which `post_mortem` was printed.
    pub(super) fn new(post_mortem: Option<&PostMortem>) -> Self {
        Self {
            steps: 0,
            status: Status::default(),
            health: Health::default(),
            shown_health: None,
            shown_mode: None,
            shown_end: post_mortem.cloned(),
        }
    }

    /// Steps of the filter so far.
    pub(super) const fn steps(&self) -> u32 {
        self.steps
    }

    /// Prints what is new.
    pub(super) fn take(&mut self, news: &RecordingEvent<'_>) {
        match news {
            RecordingEvent::Message(message) => self.take_message(message),
            RecordingEvent::Limited {
                particles_per_sensor,
            } => console::warn(format_args!(
                "Limit: steps take too long, {particles_per_sensor} particles a sensor from now on"
            )),
            RecordingEvent::Input(_) | RecordingEvent::Waiting | RecordingEvent::Away => {}
            RecordingEvent::Vanished(error) => console::warn(format_args!("{error}; trying again")),
            RecordingEvent::Back => console::warn("the link is back"),
            RecordingEvent::Restarted { .. } => {
                self.shown_end = None;
                console::warn("the board started anew");
            }
            RecordingEvent::MostlyNoise => console::warn(LinkError::MostlyNoise),
            RecordingEvent::Silent => {
                console::warn(
                    "the board sent nothing for 2 s: the recording ends here and is whole",
                );
            }
        }
    }

    fn take_message(&mut self, message: &Message) {
        match message {
            Message::Event(Event::StepDone(_)) => self.steps += 1,
            Message::Status(status) => {
                show(status);
                self.status = *status;
            }
            Message::Health(health) => self.take_health(health),
            Message::Supervision(supervision) => {
                let mode = connect::unwell(supervision);
                if mode != self.shown_mode {
                    console::warn(mode.as_deref().unwrap_or("the board's mode: Normal"));
                    self.shown_mode = mode;
                }
            }
            Message::PostMortem(record) if self.shown_end.as_ref() != Some(record) => {
                console::warn(post_mortem_in_words(record));
                self.shown_end = Some(record.clone());
            }
            Message::Event(Event::OdometryReset { .. }) => console::warn(
                "BrokeOff: the odometry broke off, what was found before shares no origin with what follows",
            ),
            _ => {}
        }
    }

    fn take_health(&mut self, health: &Health) {
        self.health = *health;
        let text = health_text(health);
        if self.shown_health.is_none() {
            console::warn(format_args!(
                "seed {:?}, offsets {:?}",
                health.seed, health.offsets
            ));
        }
        if self.shown_health.as_ref() != Some(&text) {
            console::warn(if text.is_empty() {
                "all is well"
            } else {
                &text
            });
            self.shown_health = Some(text);
        }
    }

    /// Prints the counters that are not zero, and the longest step.
    pub(super) fn report(&self) {
        let counters = [status_counters(&self.status), counters(&self.health)].concat();
        counters_in_words(&counters).iter().for_each(console::print);
        let cycles = self.status.board.step_cycles_max;
        if cycles > 0 {
            console::print(format_args!("longest step: step_cycles_max {cycles}"));
        }
    }
}

/// Shows a status in one line that overwrites itself.
fn show(status: &Status) {
    let (node, board) = (&status.node, &status.board);
    let obstacle = node.obstacle.map_or("nothing near".to_owned(), |obstacle| {
        format!(
            "nearest {:.0} mm at {:.0} deg",
            1e3 * obstacle.range_m,
            obstacle.bearing_rad.to_degrees()
        )
    });
    let fault = node
        .last_fault
        .map_or(String::new(), |fault| format!(", last fault: {fault:?}"));
    let without: String = SensorMask(node.without)
        .iter()
        .map(|sensor| format!(", without sensor {sensor}"))
        .collect();
    console::show_progress(format_args!(
        "{:.1} s, {} steps, {obstacle}{without}{fault}",
        board.uptime_ms as f64 * 1e-3,
        node.steps
    ));
}
