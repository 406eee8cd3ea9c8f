//! PCA9544A: a multiplexer that connects one of four buses, or none.

use super::{Device, InjectedBusFault, MuxFault};

/// Bit of the control byte without which no channel is connected.
const ENABLE: u8 = 0x04;
/// Bits of the control byte that can be written.
const WRITABLE: u8 = 0x07;

/// The multiplexer, with a part behind each of its channels.
///
/// The control byte names a channel, not a mask of them. A channel is connected or
/// disconnected at the stop after its control byte (data sheet, control register). The byte
/// reads back with the channels' interrupt lines in bits 4 to 7.
#[derive(Clone, Debug)]
pub struct Pca9544aModel<D> {
    address: u8,
    behind: [D; 4],
    control: u8,
    connected: Option<usize>,
    /// Addressed, and whether for reading.
    addressed: Option<bool>,
    /// The next control byte is lost.
    deaf: bool,
    /// It misses a start at this time.
    deaf_at_ns: Option<u64>,
}

impl<D: Device> Pca9544aModel<D> {
    /// After power-up, at the given address of seven bits: no channel.
    #[must_use]
    pub fn new(address: u8, behind: [D; 4]) -> Self {
        Self {
            address,
            behind,
            control: 0,
            connected: None,
            addressed: None,
            deaf: false,
            deaf_at_ns: None,
        }
    }

    /// The channel that is connected now.
    #[must_use]
    pub const fn connected(&self) -> Option<usize> {
        self.connected
    }

    /// The part behind a channel.
    ///
    /// # Panics
    /// For a channel beyond 3.
    #[must_use]
    pub fn behind(&self, channel: usize) -> &D {
        &self.behind[channel]
    }

    /// The part behind a channel.
    ///
    /// # Panics
    /// For a channel beyond 3.
    pub fn behind_mut(&mut self, channel: usize) -> &mut D {
        &mut self.behind[channel]
    }

    fn partner(&mut self) -> Option<&mut D> {
        self.behind.get_mut(self.connected?)
    }

    /// Applies a control byte at once; returns whether it changed anything.
    fn switch(&mut self, control: u8) -> bool {
        let before = (self.control, self.connected);
        self.control = control & WRITABLE;
        self.connected = channel_of(self.control);
        before != (self.control, self.connected)
    }
}

fn channel_of(control: u8) -> Option<usize> {
    (control & ENABLE != 0).then_some(usize::from(control & 0x03))
}

impl<D: Device> Device for Pca9544aModel<D> {
    fn start(&mut self, address: u8, read: bool, now_ns: u64) -> bool {
        self.deaf = false;
        let is_addressed = self.deaf_at_ns != Some(now_ns);
        self.addressed = (is_addressed && address == self.address).then_some(read);
        let behind = self
            .partner()
            .is_some_and(|part| part.start(address, read, now_ns));
        behind || self.addressed.is_some()
    }

    fn write(&mut self, byte: u8, now_ns: u64) -> bool {
        if self.addressed == Some(false) {
            if !core::mem::take(&mut self.deaf) {
                self.control = byte & WRITABLE;
            }
            return true;
        }
        self.partner().is_some_and(|part| part.write(byte, now_ns))
    }

    fn read(&mut self, now_ns: u64) -> u8 {
        if self.addressed != Some(true) {
            return self.partner().map_or(0xff, |part| part.read(now_ns));
        }
        (0..4_u8)
            .zip(&self.behind)
            .filter(|(_, part)| part.interrupts())
            .fold(self.control, |byte, (channel, _)| byte | 0x10 << channel)
    }

    fn stop(&mut self, now_ns: u64) {
        if let Some(part) = self.partner() {
            part.stop(now_ns);
        }
        self.addressed = None;
        self.deaf = false;
        self.connected = channel_of(self.control);
    }

    fn pass(&mut self, now_ns: u64) {
        for part in &mut self.behind {
            part.pass(now_ns);
        }
    }

    fn interrupts(&self) -> bool {
        self.behind.iter().any(Device::interrupts)
    }

    fn inject(&mut self, fault: InjectedBusFault, now_ns: u64) -> bool {
        match fault {
            InjectedBusFault::Mux(MuxFault::WriteLost) => {
                self.deaf = self.addressed == Some(false);
                self.deaf
            }
            InjectedBusFault::Mux(MuxFault::Deaf) => {
                self.deaf_at_ns = Some(now_ns);
                true
            }
            InjectedBusFault::Mux(MuxFault::Reset) => {
                self.addressed = None;
                self.switch(0)
            }
            InjectedBusFault::Mux(MuxFault::Jump(channel)) => self.switch(ENABLE | channel & 0x03),
            InjectedBusFault::Sensor { channel, .. } => self
                .behind
                .get_mut(usize::from(channel))
                .is_some_and(|part| part.inject(fault, now_ns)),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers to 0x13 with its number.
    #[derive(Clone, Copy, Debug, Default)]
    struct Tag {
        number: u8,
        addressed: bool,
        raises: bool,
    }

    impl Device for Tag {
        fn start(&mut self, address: u8, _: bool, _: u64) -> bool {
            self.addressed = address == 0x13;
            self.addressed
        }
        fn write(&mut self, _: u8, _: u64) -> bool {
            self.addressed
        }
        fn read(&mut self, _: u64) -> u8 {
            if self.addressed { self.number } else { 0xff }
        }
        fn stop(&mut self, _: u64) {
            self.addressed = false;
        }
        fn interrupts(&self) -> bool {
            self.raises
        }
    }

    fn mux() -> Pca9544aModel<Tag> {
        let tag = |number| Tag {
            number,
            ..Tag::default()
        };
        Pca9544aModel::new(0x77, [0xa0, 0xa1, 0xa2, 0xa3].map(tag))
    }

    fn select(mux: &mut Pca9544aModel<Tag>, control: u8) {
        assert!(mux.start(0x77, false, 0) && mux.write(control, 0));
        mux.stop(0);
    }

    fn read(mux: &mut Pca9544aModel<Tag>, address: u8) -> Option<u8> {
        let byte = mux.start(address, true, 0).then(|| mux.read(0));
        mux.stop(0);
        byte
    }

    #[test]
    fn bytes_reach_the_selected_channel_and_no_other() {
        let mut mux = mux();
        assert_eq!(read(&mut mux, 0x13), None, "none after power-up");
        assert_eq!(read(&mut mux, 0x77), Some(0x00));
        for channel in [2, 0, 3, 1] {
            select(&mut mux, 0x04 | channel);
            assert_eq!(read(&mut mux, 0x13), Some(0xa0 + channel));
            assert_eq!(read(&mut mux, 0x77), Some(0x04 | channel));
        }
        // A mask, as another family of muxes would have it, connects nothing.
        select(&mut mux, 0x02);
        assert_eq!(read(&mut mux, 0x13), None);
        assert_eq!(mux.connected(), None);
        assert_eq!(read(&mut mux, 0x12), None, "nobody's address");
    }

    #[test]
    fn a_channel_is_connected_at_the_stop() {
        let mut mux = mux();
        assert!(mux.start(0x77, false, 0) && mux.write(0x05, 0));
        // A repeated start instead of a stop.
        assert!(mux.start(0x77, true, 0));
        assert_eq!(mux.read(0), 0x05);
        assert!(!mux.start(0x13, true, 0));
        mux.stop(0);
        assert_eq!(read(&mut mux, 0x13), Some(0xa1));
    }

    #[test]
    fn interrupt_lines_are_read_back_above_the_channel() {
        let mut mux = mux();
        select(&mut mux, 0xf6);
        assert_eq!(read(&mut mux, 0x77), Some(0x06), "they cannot be written");
        mux.behind_mut(0).raises = true;
        mux.behind_mut(3).raises = true;
        assert_eq!(read(&mut mux, 0x77), Some(0x96));
    }

    #[test]
    fn faults_count_only_where_they_change_something() {
        let mut mux = mux();
        let strike =
            |mux: &mut Pca9544aModel<Tag>, fault| mux.inject(InjectedBusFault::Mux(fault), 0);
        assert!(!strike(&mut mux, MuxFault::Reset), "nothing to forget");
        assert!(!strike(&mut mux, MuxFault::WriteLost), "not spoken to");
        select(&mut mux, 0x04);
        assert!(!strike(&mut mux, MuxFault::Jump(0)), "already there");
        assert!(strike(&mut mux, MuxFault::Jump(3)));
        assert_eq!(read(&mut mux, 0x13), Some(0xa3));
        assert!(mux.start(0x77, false, 0));
        assert!(strike(&mut mux, MuxFault::WriteLost));
        assert!(mux.write(0x05, 0), "acknowledged all the same");
        mux.stop(0);
        assert_eq!(read(&mut mux, 0x13), Some(0xa3), "and lost");
        select(&mut mux, 0x05);
        assert_eq!(read(&mut mux, 0x13), Some(0xa1), "only that one");
        assert!(strike(&mut mux, MuxFault::Reset));
        assert_eq!(
            (read(&mut mux, 0x13), read(&mut mux, 0x77)),
            (None, Some(0))
        );
    }
}
