//! The bus for drivers: embedded-hal's `I2c`.

use std::fmt;

use amiro_ipf::board::i2c::{BusFault, BusTransaction};
use embedded_hal::i2c::{Error, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};

use super::{Device, FakeBus, LineFault};

/// Longest wait for a byte while SCL is held low.
const PATIENCE_NS: u64 = 1_000_000;
/// Clocks after which a part in the middle of a byte has released SDA.
const FREEING_CLOCKS: u32 = 9;

/// How a transaction failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FakeBusError {
    /// The address or a byte was not acknowledged.
    NoAcknowledge(NoAcknowledgeSource),
    /// The wires.
    Line(LineFault),
}

impl From<LineFault> for FakeBusError {
    fn from(fault: LineFault) -> Self {
        Self::Line(fault)
    }
}

impl Error for FakeBusError {
    fn kind(&self) -> ErrorKind {
        match *self {
            Self::NoAcknowledge(source) => ErrorKind::NoAcknowledge(source),
            Self::Line(LineFault::ArbitrationLost) => ErrorKind::ArbitrationLoss,
            Self::Line(LineFault::SdaLow) => ErrorKind::Bus,
            // embedded-hal has no kind for a wait that timed out.
            Self::Line(LineFault::SclLow) => ErrorKind::Other,
        }
    }
}

impl fmt::Display for FakeBusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAcknowledge(_) => f.write_str("no acknowledgement"),
            Self::Line(fault) => fault.fmt(f),
        }
    }
}

impl std::error::Error for FakeBusError {}

/// The fault that the flash image's master reports in the same case.
impl From<FakeBusError> for BusFault {
    fn from(error: FakeBusError) -> Self {
        match error {
            FakeBusError::NoAcknowledge(NoAcknowledgeSource::Data) => Self::RefusedByte,
            FakeBusError::NoAcknowledge(_) => Self::NoSuchPart,
            FakeBusError::Line(LineFault::ArbitrationLost) => Self::ArbitrationLost,
            FakeBusError::Line(LineFault::SclLow | LineFault::SdaLow) => Self::HeldLow,
        }
    }
}

impl<P: Device> ErrorType for FakeBus<P> {
    type Error = FakeBusError;
}

/// A master that waits, but at most 1 ms for a byte.
///
/// After an error it frees the bus with up to nine clocks and a stop.
impl<P: Device> I2c for FakeBus<P> {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), FakeBusError> {
        if operations.is_empty() {
            return Ok(());
        }
        let done = self.execute(address, operations);
        if done.is_err() {
            self.free();
        }
        done
    }
}

impl<P: Device> FakeBus<P> {
    /// Executes a transaction of the robot's drivers and gives the bytes that were read.
    ///
    /// # Errors
    /// As the bus's `I2c`.
    pub fn run(&mut self, transaction: &BusTransaction) -> Result<Vec<u8>, FakeBusError> {
        let (address, write) = (transaction.address(), transaction.to_write());
        let mut read = vec![0; transaction.to_read()];
        match (write.is_empty(), read.is_empty()) {
            (_, true) => I2c::write(self, address, write),
            (true, false) => I2c::read(self, address, &mut read),
            (false, false) => self.write_read(address, write, &mut read),
        }?;
        Ok(read)
    }

    fn execute(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), FakeBusError> {
        let mut before = None;
        let mut rest = operations;
        while let Some((operation, later)) = rest.split_first_mut() {
            let reads = matches!(operation, Operation::Read(_));
            if before != Some(reads) {
                self.patiently(Self::start)?;
                let byte = address << 1 | u8::from(reads);
                if !self.patiently(|bus| bus.send(byte))? {
                    return Err(FakeBusError::NoAcknowledge(NoAcknowledgeSource::Address));
                }
            }
            before = Some(reads);
            match operation {
                Operation::Write(bytes) => self.send_all(bytes)?,
                Operation::Read(bytes) => {
                    let goes_on = later
                        .iter()
                        .map_while(|operation| match operation {
                            Operation::Read(bytes) => Some(bytes),
                            Operation::Write(_) => None,
                        })
                        .any(|bytes| !bytes.is_empty());
                    self.receive_all(bytes, goes_on)?;
                }
            }
            rest = later;
        }
        Ok(self.patiently(Self::stop)?)
    }

    fn send_all(&mut self, bytes: &[u8]) -> Result<(), FakeBusError> {
        for byte in bytes {
            if !self.patiently(|bus| bus.send(*byte))? {
                return Err(FakeBusError::NoAcknowledge(NoAcknowledgeSource::Data));
            }
        }
        Ok(())
    }

    fn receive_all(&mut self, bytes: &mut [u8], goes_on: bool) -> Result<(), FakeBusError> {
        let last = bytes.len().saturating_sub(1);
        for (index, byte) in bytes.iter_mut().enumerate() {
            *byte = self.patiently(|bus| bus.receive(goes_on || index < last))?;
        }
        Ok(())
    }

    /// Performs an action, after a wait for SCL where necessary.
    fn patiently<T>(
        &mut self,
        mut action: impl FnMut(&mut Self) -> Result<T, LineFault>,
    ) -> Result<T, LineFault> {
        match action(self) {
            Err(LineFault::SclLow) => {
                let waited_ns = self.scl_until_ns() - self.now_ns();
                self.advance(waited_ns.min(PATIENCE_NS));
                action(self)
            }
            done => done,
        }
    }

    fn free(&mut self) {
        for _ in 0..FREEING_CLOCKS {
            if !self.sda_is_low() {
                break;
            }
            self.pulse();
        }
        if self.stop().is_err() {
            self.abandon();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::{At24c01Model, InjectedBusFault};

    const BYTES: [u8; 4] = [1, 2, 3, 4];

    fn bus() -> FakeBus<At24c01Model> {
        let mut bus = FakeBus::new(At24c01Model::new(0x50));
        bus.parts_mut().bytes_mut()[..4].copy_from_slice(&BYTES);
        bus
    }

    fn transcript(bus: &FakeBus<At24c01Model>) -> String {
        bus.transcript().to_string()
    }

    #[test]
    fn a_write_and_a_read_are_joined_by_a_repeated_start() {
        let mut bus = bus();
        let mut read = [0; 3];
        bus.write_read(0x50, &[1], &mut read).unwrap();
        assert_eq!(read, [2, 3, 4]);
        assert_eq!(
            transcript(&bus),
            "from byte 0: [50w+ 01+ [50r+ <02+ <03+ <04- ]"
        );
        assert!(bus.is_idle());
    }

    #[test]
    fn operations_of_one_kind_are_one_transfer() {
        let mut bus = bus();
        let (mut first, mut second) = ([0; 1], [0; 2]);
        let mut operations = [
            Operation::Write(&[]),
            Operation::Write(&[0]),
            Operation::Read(&mut first),
            Operation::Read(&mut second),
            Operation::Read(&mut []),
        ];
        bus.transaction(0x50, &mut operations).unwrap();
        assert_eq!((first, second), ([1], [2, 3]));
        assert_eq!(
            transcript(&bus),
            "from byte 0: [50w+ 00+ [50r+ <01+ <02+ <03- ]"
        );
        bus.transaction(0x50, &mut []).unwrap();
        assert_eq!(bus.bytes(), 6, "no operation, no start");
    }

    #[test]
    fn an_empty_write_probes_for_a_part() {
        let mut bus = bus();
        assert_eq!(bus.write(0x50, &[]), Ok(()));
        let no_part = FakeBusError::NoAcknowledge(NoAcknowledgeSource::Address);
        assert_eq!(bus.write(0x51, &[]), Err(no_part));
        assert_eq!(transcript(&bus), "from byte 0: [50w+ ] [51w- ]");
    }

    /// The error of a read of two bytes from 0 with a fault at a byte, the bus after it,
    /// and whether the next read succeeds.
    fn with(at: u64, fault: InjectedBusFault) -> (Option<ErrorKind>, FakeBus<At24c01Model>) {
        let mut bus = bus();
        bus.script.at_byte(at, fault);
        let mut read = [0; 2];
        let done = bus.write_read(0x50, &[0], &mut read);
        (done.err().map(|error| error.kind()), bus)
    }

    #[test]
    fn a_refusal_identifies_what_was_refused() {
        use NoAcknowledgeSource::{Address, Data};
        for (at, expected) in [
            (0, Some(ErrorKind::NoAcknowledge(Address))),
            (1, Some(ErrorKind::NoAcknowledge(Data))),
            (2, Some(ErrorKind::NoAcknowledge(Address))),
            (3, None),
        ] {
            let (kind, bus) = with(at, InjectedBusFault::NoAcknowledge);
            assert_eq!(kind, expected, "at {at}: {}", transcript(&bus));
            assert!(bus.is_idle());
        }
    }

    #[test]
    fn arbitration_can_be_lost_at_every_byte() {
        for at in 0..5 {
            let (kind, bus) = with(at, InjectedBusFault::ArbitrationLost);
            assert_eq!(kind, Some(ErrorKind::ArbitrationLoss), "at {at}");
            assert_eq!(bus.bytes(), at + 1);
            assert!(bus.is_idle(), "at {at}: {}", transcript(&bus));
        }
    }

    #[test]
    fn a_held_data_line_is_freed_by_nine_clocks_if_at_all() {
        // From the last byte on, which takes nine of them.
        for (clocks, frees) in [(10, true), (18, true), (19, false)] {
            let (kind, mut bus) = with(4, InjectedBusFault::SdaLow { clocks });
            assert_eq!(kind, Some(ErrorKind::Bus), "{clocks}: {}", transcript(&bus));
            assert_eq!(bus.is_idle(), frees, "{clocks}: {}", transcript(&bus));
            let next = bus.write(0x50, &[]);
            assert_eq!(next.is_ok(), frees, "{clocks}: {}", transcript(&bus));
            assert!(bus.is_idle(), "nine more");
        }
    }

    #[test]
    fn a_held_clock_line_is_waited_for_a_millisecond() {
        let (kind, bus) = with(
            3,
            InjectedBusFault::SclLow {
                for_ns: PATIENCE_NS,
            },
        );
        assert_eq!(kind, None);
        assert_eq!(bus.now_ns(), 5 * 22_500 + PATIENCE_NS);
        let (kind, mut bus) = with(
            3,
            InjectedBusFault::SclLow {
                for_ns: PATIENCE_NS + 1,
            },
        );
        assert_eq!(kind, Some(ErrorKind::Other));
        assert_eq!(bus.now_ns(), 3 * 22_500 + PATIENCE_NS);
        assert!(!bus.is_idle());
        assert_eq!(bus.write(0x50, &[]), Ok(()));
        assert!(bus.is_idle());
    }
}
