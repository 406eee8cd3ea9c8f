//! The serial line and its two queues.
//!
//! Single producer, single consumer, no lock: the interrupt fills one queue and
//! empties the other, `run` does the opposite.

use core::sync::atomic::{AtomicU32, Ordering};

use amiro_ipf::board::supervision::Task;
use amiro_ipf::link::{MAX_FRAME, Priority};
use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4xx_hal::pac::{Interrupt, USART1, USART2};

use crate::requests::TASKS;
use amiro_ipf::board::budget::{INPUT_ROOM, RECEIVE_QUEUE, RESERVE, SEND_QUEUE};

/// Received bytes lost because of a full queue or a line error.
static LOST: AtomicU32 = AtomicU32::new(0);

/// A frame that waits to be sent; on a word's boundary, like the encoder's.
#[repr(C, align(4))]
struct Waiting {
    bytes: [u8; MAX_FRAME],
    length: u32,
}

impl Waiting {
    /// A copy of a frame; `None` if it is longer than a frame may be.
    fn of(frame: &[u8]) -> Option<Self> {
        let mut bytes = [0; MAX_FRAME];
        bytes.get_mut(..frame.len())?.copy_from_slice(frame);
        Some(Self {
            bytes,
            length: frame.len() as u32,
        })
    }

    /// The bytes that are not sent yet.
    fn rest(&self, sent: u32) -> &[u8] {
        let range = sent as usize..self.length as usize;
        self.bytes.get(range).unwrap_or_default()
    }
}

/// Both queues; a static of the image.
pub(crate) struct Queues {
    received: Queue<u8, RECEIVE_QUEUE>,
    to_send: Queue<Waiting, SEND_QUEUE>,
}

impl Queues {
    /// Empty queues; all zeros, so that they cost no flash.
    pub(crate) const fn new() -> Self {
        Self {
            received: Queue::new(),
            to_send: Queue::new(),
        }
    }

    /// The three ends: one for the interrupt, two for `run`.
    pub(crate) fn split(&'static mut self, usart: USART2) -> (SerialLine, Inbox, Outbox) {
        let (received, receiving) = self.received.split();
        let (to_send, sending) = self.to_send.split();
        let line = SerialLine {
            usart,
            received,
            sending,
            sent: 0,
        };
        let inbox = Inbox { receiving };
        let outbox = Outbox {
            to_send,
            sent: 0,
            dropped: 0,
        };
        (line, inbox, outbox)
    }
}

/// The interrupt's side.
pub(crate) struct SerialLine {
    usart: USART2,
    received: Producer<'static, u8>,
    sending: Consumer<'static, Waiting>,
    /// Bytes of the first waiting frame that are sent.
    sent: u32,
}

impl SerialLine {
    /// Takes what has arrived and sends what waits; whether `run` has work.
    pub(crate) fn move_bytes(&mut self) -> bool {
        let has_received = self.receive();
        let has_room = self.send();
        self.enable_interrupts();
        has_received || has_room
    }

    /// Takes a byte if one has arrived.
    fn receive(&mut self) -> bool {
        let status = self.usart.sr().read();
        let overrun = status.ore().bit_is_set();
        if status.rxne().bit_is_clear() && !overrun {
            return false;
        }
        // Reading the data register after the status clears the error flags.
        let byte = self.usart.dr().read().dr().bits() as u8;
        let damaged = overrun || status.nf().bit_is_set() || status.fe().bit_is_set();
        let kept = status.rxne().bit_is_clear() || self.received.enqueue(byte).is_ok();
        if damaged || !kept {
            LOST.fetch_add(1, Ordering::Relaxed);
        }
        true
    }

    /// Sends while the line is ready, at most one frame, so that a line that is always
    /// ready does not starve other tasks; whether `run` has enough room again.
    fn send(&mut self) -> bool {
        let Some(frame) = self.sending.peek() else {
            return false;
        };
        for byte in frame.rest(self.sent) {
            if self.usart.sr().read().txe().bit_is_clear() {
                return false;
            }
            self.usart.dr().write(|w| w.dr().set(u16::from(*byte)));
            self.sent += 1;
        }
        self.sent = 0;
        self.sending.dequeue();
        self.sending.len() == SEND_QUEUE - 1 - INPUT_ROOM
    }

    fn enable_interrupts(&mut self) {
        let waiting = self.sending.ready();
        self.usart
            .cr1()
            .modify(|_, w| w.rxneie().set_bit().txeie().bit(waiting));
    }
}

/// Takes the byte that the programming port has received.
pub(crate) fn take_byte(port: &USART1) -> u8 {
    // Reading the data register after the status clears the error flags.
    port.sr().read();
    port.dr().read().dr().bits() as u8
}

/// Received bytes, for `run`.
pub(crate) struct Inbox {
    receiving: Consumer<'static, u8>,
}

impl Inbox {
    /// Bytes lost since boot.
    pub(crate) fn lost(&self) -> u32 {
        LOST.load(Ordering::Relaxed)
    }

    /// The next received byte, if any.
    pub(crate) fn next(&mut self) -> Option<u8> {
        self.receiving.dequeue()
    }
}

/// Frames to send, for `run`.
pub(crate) struct Outbox {
    to_send: Producer<'static, Waiting>,
    sent: u32,
    dropped: u32,
}

impl Outbox {
    /// Queues a frame, or drops it and counts it.
    ///
    /// Particle frames leave a reserve for all other frames; nothing waits.
    pub(crate) fn send(&mut self, frame: &[u8], priority: Priority) {
        let reserve = match priority {
            Priority::BestEffort => RESERVE,
            Priority::Reliable => 0,
        };
        let queued = self.room() > reserve
            && Waiting::of(frame).is_some_and(|frame| self.to_send.enqueue(frame).is_ok());
        let counter = if queued {
            &mut self.sent
        } else {
            &mut self.dropped
        };
        *counter = counter.wrapping_add(1);
        // A long step has checked in as long as it sends frames.
        TASKS.check_in(Task::Run);
        rtic::pend(Interrupt::USART2);
    }

    /// Free places.
    pub(crate) fn room(&self) -> usize {
        SEND_QUEUE - 1 - self.to_send.len()
    }

    /// Frames queued since boot.
    pub(crate) fn sent(&self) -> u32 {
        self.sent
    }

    /// Frames dropped since boot.
    pub(crate) fn dropped(&self) -> u32 {
        self.dropped
    }
}
