//! AT24C01: an EEPROM of 128 bytes.

use super::Device;

/// Size of the memory, bytes.
pub const MEMORY_BYTES: usize = 128;
/// Bytes of a page; a longer write wraps to the page's beginning.
pub const PAGE_BYTES: usize = 8;
/// Duration of a write after a stop, without an acknowledgement: 5 ms (data sheet, t_WR).
pub const WRITE_CYCLE_NS: u64 = 5_000_000;

/// State of the transfer with the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum MemoryTransfer {
    /// Nothing.
    #[default]
    Idle,
    /// The next byte is a word address.
    Address,
    /// The next byte is for the page.
    Load,
    /// The master reads the next byte.
    Read,
}

/// The memory, with its address pins at one level or another.
#[derive(Clone, Debug)]
pub struct At24c01Model {
    address: u8,
    bytes: [u8; MEMORY_BYTES],
    /// The page being loaded: what is written at the stop.
    loaded: [Option<u8>; PAGE_BYTES],
    pointer: usize,
    transfer: MemoryTransfer,
    busy_until_ns: u64,
}

impl At24c01Model {
    /// A new memory, all ones, at the given address of seven bits.
    #[must_use]
    pub fn new(address: u8) -> Self {
        Self {
            address,
            bytes: [0xff; MEMORY_BYTES],
            loaded: [None; PAGE_BYTES],
            pointer: 0,
            transfer: MemoryTransfer::Idle,
            busy_until_ns: 0,
        }
    }

    /// The contents.
    #[must_use]
    pub fn bytes(&self) -> &[u8; MEMORY_BYTES] {
        &self.bytes
    }

    /// The contents, for the preparation of a test.
    pub fn bytes_mut(&mut self) -> &mut [u8; MEMORY_BYTES] {
        &mut self.bytes
    }

    /// The first byte of the page that the pointer is in.
    fn page(&self) -> usize {
        self.pointer - self.pointer % PAGE_BYTES
    }
}

impl Device for At24c01Model {
    fn start(&mut self, address: u8, read: bool, now_ns: u64) -> bool {
        // A repeated start ends a write without a stop: nothing is kept.
        self.loaded = [None; PAGE_BYTES];
        let answers = address == self.address && now_ns >= self.busy_until_ns;
        self.transfer = match (answers, read) {
            (false, _) => MemoryTransfer::Idle,
            (true, false) => MemoryTransfer::Address,
            (true, true) => MemoryTransfer::Read,
        };
        answers
    }

    fn write(&mut self, byte: u8, _now_ns: u64) -> bool {
        match self.transfer {
            MemoryTransfer::Idle | MemoryTransfer::Read => return false,
            MemoryTransfer::Address => {
                self.pointer = usize::from(byte) % MEMORY_BYTES;
                self.transfer = MemoryTransfer::Load;
            }
            MemoryTransfer::Load => {
                let within = self.pointer % PAGE_BYTES;
                self.loaded[within] = Some(byte);
                self.pointer = self.page() + (within + 1) % PAGE_BYTES;
            }
        }
        true
    }

    fn read(&mut self, _now_ns: u64) -> u8 {
        if self.transfer != MemoryTransfer::Read {
            return 0xff;
        }
        let byte = self.bytes[self.pointer];
        self.pointer = (self.pointer + 1) % MEMORY_BYTES;
        byte
    }

    fn stop(&mut self, now_ns: u64) {
        self.transfer = MemoryTransfer::Idle;
        let page = self.page();
        for (offset, loaded) in self.loaded.iter_mut().enumerate() {
            if let Some(byte) = loaded.take() {
                self.bytes[page + offset] = byte;
                self.busy_until_ns = now_ns + WRITE_CYCLE_NS;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(memory: &mut At24c01Model, bytes: &[u8], now_ns: u64) -> bool {
        let taken = memory.start(0x50, false, now_ns)
            && bytes.iter().all(|byte| memory.write(*byte, now_ns));
        memory.stop(now_ns);
        taken
    }

    #[test]
    fn a_write_beyond_the_page_comes_round_to_its_beginning() {
        let mut memory = At24c01Model::new(0x50);
        assert!(write(&mut memory, &[0x16, 1, 2, 3], 0));
        assert_eq!(
            memory.bytes()[0x10..0x19],
            [3, 255, 255, 255, 255, 255, 1, 2, 255]
        );
        // Ten bytes: the first two are written over.
        assert!(write(
            &mut memory,
            &[0x18, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
            WRITE_CYCLE_NS
        ));
        assert_eq!(memory.bytes()[0x18..0x20], [8, 9, 2, 3, 4, 5, 6, 7]);
        assert_eq!(memory.bytes()[0x20], 255);
    }

    #[test]
    fn nothing_is_acknowledged_for_five_milliseconds_after_a_write() {
        let mut memory = At24c01Model::new(0x50);
        assert!(write(&mut memory, &[0, 7], 1_000));
        assert!(!memory.start(0x50, false, 1_000 + WRITE_CYCLE_NS - 1));
        assert!(!memory.write(0, 1_000 + WRITE_CYCLE_NS - 1));
        assert!(memory.start(0x50, false, 1_000 + WRITE_CYCLE_NS));
        memory.stop(1_000 + WRITE_CYCLE_NS);
        // A word address alone starts no cycle.
        assert!(write(&mut memory, &[0x40], 6_000_000));
        assert!(memory.start(0x50, true, 6_000_000));
    }

    #[test]
    fn a_sequential_read_rolls_over_at_the_end() {
        let mut memory = At24c01Model::new(0x50);
        *memory.bytes_mut() = core::array::from_fn(|index| index as u8);
        assert!(memory.start(0x50, false, 0) && memory.write(0xfe, 0));
        assert!(memory.start(0x50, true, 0));
        let read: Vec<u8> = (0..4).map(|_| memory.read(0)).collect();
        // The word address has seven bits.
        assert_eq!(read, [126, 127, 0, 1]);
    }

    #[test]
    fn a_write_without_a_stop_is_dropped() {
        let mut memory = At24c01Model::new(0x50);
        assert!(memory.start(0x50, false, 0) && memory.write(0, 0) && memory.write(9, 0));
        assert!(memory.start(0x50, true, 0));
        memory.stop(0);
        assert_eq!(memory.bytes()[0], 255);
        assert!(!memory.start(0x51, true, 0), "another address");
        assert_eq!(memory.read(0), 0xff);
    }
}
