//! A bus with a multiplexer and four sensors for the tests of this folder.

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};

pub(super) const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

/// A sensor whose results come every `period_ns`, whatever the bus is doing.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) registers: [u8; 256],
    pub(super) present: bool,
    /// Results in turn.
    pub(super) results: Vec<u16>,
    pub(super) ambient: u16,
    pub(super) period_ns: u64,
    pub(super) next_ns: u64,
    updates: usize,
}

impl Part {
    fn new() -> Self {
        let mut part = Self {
            registers: [0; 256],
            present: true,
            results: vec![2_450],
            ambient: 100,
            period_ns: 8_000_000,
            next_ns: 0,
            updates: 0,
        };
        part.reset();
        part
    }

    pub(super) fn reset(&mut self) {
        self.registers = [0; 256];
        self.registers[0x80] = 0x80;
        self.registers[0x81] = 0x21;
    }

    fn update_until(&mut self, now_ns: u64) {
        while self.next_ns <= now_ns {
            self.next_ns += self.period_ns;
            if self.registers[0x80] & 3 != 3 {
                continue;
            }
            let value = self.results[self.updates % self.results.len()];
            self.updates += 1;
            self.registers[0x85..0x87].copy_from_slice(&self.ambient.to_be_bytes());
            self.registers[0x87..0x89].copy_from_slice(&value.to_be_bytes());
            self.registers[0x80] |= 0x60;
        }
    }

    fn read(&mut self, register: u8) -> u8 {
        // Reading either byte of a result clears its ready bit.
        match register {
            0x85 | 0x86 => self.registers[0x80] &= !0x40,
            0x87 | 0x88 => self.registers[0x80] &= !0x20,
            _ => {}
        }
        self.registers[usize::from(register)]
    }

    fn write(&mut self, register: u8, value: u8) {
        let is_rate = matches!(register, 0x82 | 0x84);
        if is_rate && self.registers[0x80] & 1 != 0 {
            return;
        }
        let value = match register {
            0x80 => value & 0x1f | self.registers[0x80] & 0xe0,
            _ => value,
        };
        self.registers[usize::from(register)] = value;
    }
}

/// The bus. Time passes by its clock.
#[derive(Clone, Debug)]
pub(super) struct Bus {
    pub(super) parts: [Part; 4],
    pub(super) mux: u8,
    pub(super) mux_present: bool,
    pub(super) now_ns: u64,
    pub(super) clock_ns: u64,
    pub(super) transactions: u64,
    /// Transactions that fail, by their number from 0, and how.
    pub(super) failing: Vec<(u64, ErrorKind)>,
    /// What the multiplexer's register becomes at the end of a transaction.
    pub(super) mux_fault: fn(&mut Bus, written: Option<u8>),
    pub(super) random: u64,
    pub(super) events: u64,
    pub(super) jump: Option<(u32, u8)>,
}

impl Bus {
    pub(super) fn new() -> Self {
        Self {
            parts: core::array::from_fn(|_| Part::new()),
            mux: 0,
            mux_present: true,
            now_ns: 0,
            clock_ns: 2_500,
            transactions: 0,
            failing: Vec::new(),
            mux_fault: |bus, written| bus.mux = written.unwrap_or(bus.mux),
            random: 0x9e37_79b9_7f4a_7c15,
            events: 0,
            jump: None,
        }
    }

    pub(super) fn now_us(&self) -> u64 {
        self.now_ns / 1_000
    }

    /// A random number below `bound`.
    pub(super) fn below(&mut self, bound: u64) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 20) % bound
    }

    fn connected(&mut self) -> Option<&mut Part> {
        if self.mux & 4 == 0 {
            return None;
        }
        Some(&mut self.parts[usize::from(self.mux & 3)]).filter(|part| part.present)
    }

    fn pass(&mut self, clocks: u64) {
        self.now_ns += clocks * self.clock_ns;
        for part in &mut self.parts {
            part.update_until(self.now_ns);
        }
    }

    pub(super) fn wait_until(&mut self, now_us: u64) {
        self.now_ns = self.now_ns.max(now_us * 1_000);
        self.pass(0);
    }
}

impl ErrorType for Bus {
    type Error = ErrorKind;
}

impl I2c for Bus {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        let number = self.transactions;
        self.transactions += 1;
        if let Some((_, how)) = self.failing.iter().find(|(at, _)| *at == number) {
            return Err(*how);
        }
        let mut pointer = 0;
        let mut written = None;
        for operation in operations {
            self.pass(10);
            if address == 0x77 && self.mux_present {
                self.pass(9);
                match operation {
                    Operation::Write(bytes) => written = Some(bytes[0] & 7),
                    Operation::Read(bytes) => bytes[0] = self.mux,
                }
                continue;
            }
            if address != 0x13 || self.connected().is_none() {
                return Err(NACK);
            }
            match operation {
                Operation::Write(bytes) => {
                    pointer = bytes[0];
                    self.pass(9);
                    for byte in &bytes[1..] {
                        self.pass(9);
                        self.connected().unwrap().write(pointer, *byte);
                        pointer += 1;
                    }
                }
                Operation::Read(bytes) => {
                    for byte in bytes.iter_mut() {
                        self.pass(9);
                        *byte = self.connected().unwrap().read(pointer);
                        pointer += 1;
                    }
                }
            }
        }
        self.pass(1);
        (self.mux_fault)(self, written);
        Ok(())
    }
}
