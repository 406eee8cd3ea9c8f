//! A decorator of one direction of a byte transport that has the faults of a line.

use std::collections::VecDeque;
use std::time::Duration;

use amiro_ipf::random::{Generator, uniform_below};

use super::geometric::{Geometric, uniform};
use crate::faults::{Faults, Kind, Window};

/// Bytes without a zero byte that count as one piece.
const LONGEST_PIECE: usize = 4096;

/// The true fate of the frames on a line, which a host cannot observe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineTally {
    /// Frames sent, each a piece of bytes up to a zero byte.
    pub sent: u64,
    /// Of these delivered whole, between two zero bytes, at least once.
    pub whole: u64,
    /// Of these delivered, but not whole.
    pub damaged: u64,
    /// Of these of which no byte was delivered.
    pub lost: u64,
    /// Bytes sent.
    pub bytes_sent: u64,
    /// Bytes delivered.
    pub bytes_delivered: u64,
}

/// A fault with its state.
#[derive(Clone, Debug)]
struct Injected {
    kind: Kind,
    window: Window,
    trials: Geometric,
    /// Bytes of a burst that are still to be dropped.
    to_drop: u32,
}

/// One direction of a line: bytes go in at a time and come out, some of them, later.
///
/// Frames are lost, cut, swapped or repeated first; then bytes are dropped and garbage is
/// inserted; then bits are flipped; then the rest is delayed. Equal seeds and equal calls
/// give equal bytes. Without faults every byte passes at once.
#[derive(Clone, Debug)]
pub struct FaultInjector {
    faults: Vec<Injected>,
    random: Generator,
    /// Bytes of a frame whose end was not sent yet.
    piece: Vec<u8>,
    /// A frame that waits for the next one to overtake it.
    overtaken: Option<Vec<u8>>,
    /// Delivered bytes since the last zero byte: they damage the next frame.
    open: Vec<u8>,
    /// The frame that these bytes began, without its zero byte: later bytes may end it.
    unfinished: Option<Vec<u8>>,
    on_the_way: VecDeque<(Duration, Vec<u8>)>,
    free_at: Duration,
    tally: LineTally,
}

impl FaultInjector {
    /// A line with the faults of the link, drawn from this seed.
    #[must_use]
    pub fn new(faults: &Faults, seed: u64) -> Self {
        let mut random = Generator::seeded(seed);
        let faults = faults
            .line()
            .iter()
            .map(|fault| {
                let rate = match fault.kind {
                    Kind::BitErrors(rate)
                    | Kind::Dropped { rate, .. }
                    | Kind::GarbageBytes { rate, .. } => rate,
                    _ => 0.0,
                };
                Injected {
                    kind: fault.kind,
                    window: fault.window,
                    trials: Geometric::new(rate, &mut random),
                    to_drop: 0,
                }
            })
            .collect();
        Self {
            faults,
            random,
            piece: Vec::new(),
            overtaken: None,
            open: Vec::new(),
            unfinished: None,
            on_the_way: VecDeque::new(),
            free_at: Duration::ZERO,
            tally: LineTally::default(),
        }
    }

    /// Sends bytes, at a time since the line's first use that never decreases.
    ///
    /// Bytes without a final zero byte wait for it, or for [`flush`](Self::flush).
    pub fn send(&mut self, bytes: &[u8], now: Duration) {
        for &byte in bytes {
            self.piece.push(byte);
            if byte == 0 || self.piece.len() == LONGEST_PIECE {
                self.send_piece(now);
            }
        }
    }

    /// Sends the bytes that wait for the end of their frame, or to be overtaken.
    pub fn flush(&mut self, now: Duration) {
        if !self.piece.is_empty() {
            self.send_piece(now);
        }
        if let Some(frame) = self.overtaken.take() {
            self.deliver_frame(&frame, 1, now);
        }
    }

    /// The bytes that have arrived by now.
    pub fn receive(&mut self, now: Duration) -> Vec<u8> {
        let mut arrived = Vec::new();
        while self.next_arrival().is_some_and(|due| due <= now) {
            arrived.extend(self.on_the_way.pop_front().into_iter().flat_map(|it| it.1));
        }
        arrived
    }

    /// When the next bytes arrive, if any are on the way.
    #[must_use]
    pub fn next_arrival(&self) -> Option<Duration> {
        self.on_the_way.front().map(|(due, _)| *due)
    }

    /// The statistics so far.
    #[must_use]
    pub fn tally(&self) -> LineTally {
        self.tally
    }

    /// Whether a fault of frames applies to the frame that is sent.
    fn strikes(&mut self, now: Duration, of_rate: fn(f64) -> Kind) -> bool {
        let byte = self.tally.bytes_sent;
        let Self { faults, random, .. } = self;
        faults
            .iter()
            .filter(|fault| fault.window.contains(now, byte))
            .filter_map(|fault| fault.kind.rate_if(of_rate))
            .fold(false, |struck, rate| struck | (uniform(random) <= rate))
    }

    fn send_piece(&mut self, now: Duration) {
        let frame = std::mem::take(&mut self.piece);
        if frame == [0] {
            self.tally.bytes_sent += 1;
            let passed = self.disturb(&[0], self.tally.bytes_sent - 1, now);
            self.dispatch(passed, now);
            return;
        }
        self.tally.sent += 1;
        if self.strikes(now, Kind::Lost) {
            self.tally.bytes_sent += frame.len() as u64;
            self.tally.lost += 1;
            return;
        }
        if self.strikes(now, Kind::Cut) {
            self.cut(&frame, now);
            return;
        }
        if self.overtaken.is_none() && self.strikes(now, Kind::Swapped) {
            self.overtaken = Some(frame);
            return;
        }
        let is_repeated = self.strikes(now, Kind::Twice);
        self.deliver_frame(&frame, if is_repeated { 2 } else { 1 }, now);
        if let Some(overtaken) = self.overtaken.take() {
            self.deliver_frame(&overtaken, 1, now);
        }
    }

    /// Sends the first bytes of a frame without its end.
    fn cut(&mut self, frame: &[u8], now: Duration) {
        self.tally.bytes_sent += frame.len() as u64;
        let end = uniform_below(&mut self.random, frame.len() as u32) as usize;
        let rest = frame.get(..end).unwrap_or_default();
        let passed = self.disturb(rest, self.tally.bytes_sent, now);
        let came = passed.len();
        self.dispatch(passed, now);
        self.note(&[], came);
        self.leave_unfinished(frame, came);
    }

    fn deliver_frame(&mut self, frame: &[u8], copies: usize, now: Duration) {
        let first_byte = self.tally.bytes_sent;
        self.tally.bytes_sent += frame.len() as u64;
        let mut came = 0;
        let mut is_whole = false;
        for _ in 0..copies {
            let passed = self.disturb(frame, first_byte, now);
            came += passed.len();
            is_whole |= self.arrives_whole(frame, &passed);
            self.dispatch(passed, now);
        }
        self.note(if is_whole { frame } else { &[] }, came);
        if !is_whole {
            self.leave_unfinished(frame, came);
        }
    }

    /// Keeps a frame of which the last delivered bytes are the first ones.
    fn leave_unfinished(&mut self, frame: &[u8], came: usize) {
        if came > 0 && !self.open.is_empty() && frame.starts_with(&self.open) {
            self.unfinished = frame.strip_suffix(&[0]).map(<[u8]>::to_vec);
        }
    }

    /// Counts a frame by its delivered bytes; a whole one is given as its bytes.
    fn note(&mut self, whole: &[u8], came: usize) {
        let place = match (whole.is_empty(), came) {
            (false, _) => &mut self.tally.whole,
            (true, 0) => &mut self.tally.lost,
            (true, _) => &mut self.tally.damaged,
        };
        *place += 1;
    }

    /// Whether the frame lies between two zero bytes of the delivered bytes.
    fn arrives_whole(&self, frame: &[u8], passed: &[u8]) -> bool {
        if self.open.is_empty() && passed == frame {
            return frame.ends_with(&[0]);
        }
        let seen = [&self.open[..], passed].concat();
        let content = frame.strip_suffix(&[0]).unwrap_or(frame);
        let mut pieces = seen.split(|byte| *byte == 0);
        // Bytes after the last zero byte are not ended.
        let _ = pieces.next_back();
        pieces.any(|piece| piece == content)
    }

    /// Applies the faults of bytes: drops, inserted garbage, flipped bits.
    fn disturb(&mut self, bytes: &[u8], first: u64, now: Duration) -> Vec<u8> {
        let Self { faults, random, .. } = self;
        faults.iter_mut().fold(bytes.to_vec(), |left, fault| {
            fault.disturb(left, first, now, random)
        })
    }

    /// Schedules the delivery of bytes.
    fn dispatch(&mut self, bytes: Vec<u8>, now: Duration) {
        if bytes.is_empty() {
            return;
        }
        self.tally.bytes_delivered += bytes.len() as u64;
        if let Some(zero) = bytes.iter().position(|byte| *byte == 0)
            && let Some(content) = self.unfinished.take()
        {
            // The end of another frame happens to complete this one.
            let end = content.strip_prefix(self.open.as_slice());
            if end == bytes.get(..zero) {
                self.tally.damaged -= 1;
                self.tally.whole += 1;
            }
        }
        match bytes.iter().rposition(|byte| *byte == 0) {
            Some(zero) => self.open = bytes.iter().skip(zero + 1).copied().collect(),
            None => self.open.extend_from_slice(&bytes),
        }
        // A piece that is longer than any frame cannot become a frame.
        self.open.truncate(LONGEST_PIECE);
        let byte = self.tally.bytes_sent;
        let mut due = now;
        for fault in &self.faults {
            if !fault.window.contains(now, byte) {
                continue;
            }
            match fault.kind {
                Kind::BytesPerSecond(speed) => {
                    let time = Duration::from_secs_f64(bytes.len() as f64 / f64::from(speed));
                    due = due.max(self.free_at) + time;
                    self.free_at = due;
                }
                Kind::Delayed(time) => due += time,
                _ => {}
            }
        }
        // Bytes never overtake each other.
        let due = self
            .on_the_way
            .back()
            .map_or(due, |(last, _)| due.max(*last));
        self.on_the_way.push_back((due, bytes));
    }
}

impl Injected {
    /// The bytes after this fault; `first` is the number of the first among all.
    fn disturb(
        &mut self,
        mut bytes: Vec<u8>,
        first: u64,
        now: Duration,
        random: &mut Generator,
    ) -> Vec<u8> {
        let window = self.window;
        let mut byte = first;
        let mut is_inside = || {
            byte += 1;
            window.contains(now, byte - 1)
        };
        match self.kind {
            Kind::Off => bytes.retain(|_| !is_inside()),
            Kind::Dropped { most, .. } => bytes.retain(|_| {
                if is_inside() && self.trials.next_within(1, random).is_some() {
                    self.to_drop = 1 + uniform_below(random, most);
                }
                let is_dropped = self.to_drop > 0;
                self.to_drop = self.to_drop.saturating_sub(1);
                !is_dropped
            }),
            Kind::GarbageBytes { most, .. } => {
                let mut mixed = Vec::with_capacity(bytes.len());
                for byte in bytes {
                    if is_inside() && self.trials.next_within(1, random).is_some() {
                        let count = 1 + uniform_below(random, most);
                        mixed.extend((0..count).map(|_| random.bits() as u8));
                    }
                    mixed.push(byte);
                }
                return mixed;
            }
            Kind::BitErrors(_) => {
                for byte in bytes.iter_mut().filter(|_| is_inside()) {
                    let mut bit = 0;
                    while let Some(more) = self.trials.next_within(8 - bit, random) {
                        *byte ^= 1 << (bit + more);
                        bit += more + 1;
                    }
                }
            }
            _ => {}
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(faults: &str) -> FaultInjector {
        FaultInjector::new(&format!("link={faults}").parse().unwrap(), 1)
    }

    /// A thousand frames of 2 to 21 bytes, none like another.
    fn frames() -> Vec<Vec<u8>> {
        (0..1000_u16)
            .map(|number| {
                let [low, high] = number.to_le_bytes().map(|byte| byte | 1);
                let mut frame = vec![low, high];
                frame.resize(1 + usize::from(number % 20), 7);
                frame.push(0);
                frame
            })
            .collect()
    }

    fn through(line: &mut FaultInjector) -> Vec<u8> {
        let mut came = Vec::new();
        for frame in frames() {
            line.send(&frame, Duration::ZERO);
            came.extend(line.receive(Duration::MAX));
        }
        line.flush(Duration::ZERO);
        came.extend(line.receive(Duration::MAX));
        came
    }

    #[test]
    fn a_line_without_faults_hands_on_every_byte_at_once() {
        let mut line = line("ok");
        assert_eq!(through(&mut line), frames().concat());
        let tally = line.tally();
        assert_eq!(
            (tally.sent, tally.whole, tally.damaged, tally.lost),
            (1000, 1000, 0, 0)
        );
        assert_eq!(tally.bytes_sent, tally.bytes_delivered);
    }

    #[test]
    fn each_fault_has_the_effect_of_its_word() {
        let all = frames().concat();
        let came = |faults| {
            let mut line = line(faults);
            let came = through(&mut line);
            let tally = line.tally();
            assert_eq!(
                tally.whole + tally.damaged + tally.lost,
                tally.sent,
                "{faults}"
            );
            assert_eq!(tally.bytes_delivered, came.len() as u64, "{faults}");
            assert_eq!(tally.bytes_sent, all.len() as u64, "{faults}");
            (came, tally)
        };
        let (bytes, tally) = came("off");
        assert!(bytes.is_empty() && tally.lost == 1000);
        assert_eq!(
            came("off@100B..200B").0,
            [&all[..100], &all[200..]].concat()
        );
        assert_eq!(
            came("ber:1").0,
            all.iter().map(|byte| !byte).collect::<Vec<_>>()
        );
        let (bytes, tally) = came("twice:1");
        assert_eq!((bytes.len(), tally.whole), (2 * all.len(), 1000));
        let (bytes, tally) = came("swap:1");
        assert_eq!((bytes.len(), tally.whole), (all.len(), 1000));
        assert_ne!(bytes, all);
        let (_, tally) = came("lose:0.5");
        // Four standard deviations of 1000 tosses.
        assert!(
            tally.lost.abs_diff(500) < 64 && tally.damaged == 0,
            "{tally:?}"
        );
        let (bytes, tally) = came("cut:0.5");
        assert!(bytes.len() < all.len() && tally.damaged > 400, "{tally:?}");
        assert!(came("drop:0.01x9").0.len() < all.len());
        assert!(came("garbage:0.01x9").0.len() > all.len());
    }

    #[test]
    fn a_frame_that_another_one_s_end_completes_has_arrived() {
        let frames = [[1, 2, 3, 7, 0], [4, 5, 6, 7, 0]];
        for (faults, whole) in [
            // 1 2 3 | 7 0, 1 2 3 7 | 0, 1 2 3 | 6 7 0, 1 2 | 7 0.
            ("off@3B..8B", 1),
            ("off@4B..9B", 1),
            ("off@3B..7B", 0),
            ("off@2B..8B", 0),
        ] {
            let mut line = line(faults);
            for frame in &frames {
                line.send(frame, Duration::ZERO);
            }
            let tally = line.tally();
            assert_eq!((tally.whole, tally.damaged), (whole, 2 - whole), "{faults}");
        }
    }

    #[test]
    fn a_slow_line_takes_its_time_and_a_late_one_waits() {
        let ms = Duration::from_millis;
        let mut line = line("slow:1000+delay:5ms");
        line.send(&[1, 1, 1, 0], ms(10));
        line.send(&[2, 2, 2, 0], ms(10));
        assert_eq!(line.next_arrival(), Some(ms(19)));
        assert!(line.receive(ms(18)).is_empty());
        assert_eq!(line.receive(ms(22)), [1, 1, 1, 0]);
        assert_eq!(line.receive(ms(23)), [2, 2, 2, 0]);
    }

    #[test]
    fn equal_seeds_give_equal_bytes_and_others_do_not() {
        let faults = "link=ber:1e-3+drop:1e-3x5+garbage:1e-3+lose:0.01"
            .parse()
            .unwrap();
        let came = |seed| through(&mut FaultInjector::new(&faults, seed));
        assert_eq!(came(7), came(7));
        assert_ne!(came(7), came(8));
    }
}
