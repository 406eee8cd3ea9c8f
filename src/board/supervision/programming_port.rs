//! Recognises the call for the boot loader on the programming port.

/// What AMiRo's flashing tool sends first: the CONNECT packet of its protocol.
const CALL: [u8; 3] = [0x02, 0xff, 0x00];

/// Finds the call in a stream of bytes, wherever it begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProgrammingPort {
    matched: usize,
}

impl ProgrammingPort {
    /// A port that has received nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { matched: 0 }
    }

    /// Takes a byte; whether it completes the call.
    pub fn completes_call(&mut self, byte: u8) -> bool {
        if CALL.get(self.matched) == Some(&byte) {
            self.matched += 1;
        } else {
            // The call's first byte occurs once in it: no other match can have begun.
            self.matched = usize::from(CALL.first() == Some(&byte));
        }
        let is_complete = self.matched == CALL.len();
        if is_complete {
            self.matched = 0;
        }
        is_complete
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_call_is_found_wherever_it_begins_and_nothing_else_is() {
        let cases: [(&[u8], usize); 6] = [
            (&[0x02, 0xff, 0x00], 1),
            (&[0x02, 0x02, 0xff, 0x00], 1),
            (&[0x02, 0xff, 0x02, 0xff, 0x00, 0x00], 1),
            (&[0xff, 0x00, 0x02, 0xff], 0),
            (&[0x02, 0xff, 0xff, 0x00], 0),
            (&[0x02, 0xff, 0x00, 0x02, 0xff, 0x00], 2),
        ];
        for (bytes, calls) in cases {
            let mut port = ProgrammingPort::new();
            let found = bytes
                .iter()
                .filter(|byte| port.completes_call(**byte))
                .count();
            assert_eq!(found, calls, "{bytes:02x?}");
        }
    }
}
