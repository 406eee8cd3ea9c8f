//! A part that notes what it sees and refuses on command.

use std::cell::RefCell;
use std::rc::Rc;

use sim_harness::bus::Device;

/// What a part has seen on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seen {
    Address { read: bool },
    Written(u8),
    Read(u8),
    Stop,
}

/// A part at one address; whoever has a clone looks at the same part.
#[derive(Clone)]
pub(crate) struct Part {
    address: u8,
    inside: Rc<RefCell<Inside>>,
}

#[derive(Default)]
struct Inside {
    seen: Vec<Seen>,
    /// Bytes and addresses until one is refused.
    refuses_in: Option<usize>,
    addressed: bool,
    reads: u8,
}

impl Part {
    pub(crate) fn at(address: u8) -> Self {
        Self {
            address,
            inside: Rc::default(),
        }
    }

    /// Refuses once, after this many acknowledged addresses and bytes.
    pub(crate) fn refuse_after(&self, bytes: usize) {
        self.inside.borrow_mut().refuses_in = Some(bytes);
    }

    /// What was seen since the last call.
    pub(crate) fn take_seen(&self) -> Vec<Seen> {
        std::mem::take(&mut self.inside.borrow_mut().seen)
    }

    /// The byte that is read as the given one after an address: all bits occur.
    pub(crate) fn byte(index: u8) -> u8 {
        index.wrapping_mul(37) ^ 0xa5
    }
}

impl Inside {
    fn acknowledges(&mut self) -> bool {
        match self.refuses_in {
            Some(0) => {
                self.refuses_in = None;
                false
            }
            Some(more) => {
                self.refuses_in = Some(more - 1);
                true
            }
            None => true,
        }
    }
}

impl Device for Part {
    fn start(&mut self, address: u8, read: bool, _: u64) -> bool {
        let mut inside = self.inside.borrow_mut();
        inside.addressed = address == self.address && inside.acknowledges();
        if inside.addressed {
            inside.reads = 0;
            inside.seen.push(Seen::Address { read });
        }
        inside.addressed
    }

    fn write(&mut self, byte: u8, _: u64) -> bool {
        let mut inside = self.inside.borrow_mut();
        let taken = inside.addressed && inside.acknowledges();
        if taken {
            inside.seen.push(Seen::Written(byte));
        }
        taken
    }

    fn read(&mut self, _: u64) -> u8 {
        let mut inside = self.inside.borrow_mut();
        let byte = Self::byte(inside.reads);
        inside.reads = inside.reads.wrapping_add(1);
        inside.seen.push(Seen::Read(byte));
        byte
    }

    fn stop(&mut self, _: u64) {
        let mut inside = self.inside.borrow_mut();
        if std::mem::take(&mut inside.addressed) {
            inside.seen.push(Seen::Stop);
        }
    }
}
