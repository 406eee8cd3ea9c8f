//! Recordings: drives read from files, and written to them.
//!
//! Two formats, told apart by their content:
//!
//! - the text that AMiRo's own recorder wrote, eleven columns a row;
//! - the bytes of the link, as the board and the simulator speak them.
//!
//! One bad line or frame costs that line or frame: it is refused with its place and
//! reason, and what is left is used. A source that has nothing usable at all is a
//! [`LogError`]. Memory is bounded whatever a source holds: 64 KiB a line, 128 bytes
//! a frame, 64 KiB of scenario, 4 KiB of faults, [`MOST_ENTRIES`] entries in all.

mod amiro_header;
mod amiro_text;
mod draft;
mod error;
mod origin;
mod plausibility;
mod reader;
mod recording;
mod refusals;
mod sequence;
mod source;
mod stream;
mod writer;

pub use draft::MOST_ENTRIES;
pub use error::{LogError, Problem};
pub(crate) use origin::{DECIDING_BYTES, is_of_a_robot};
pub use reader::{read, read_from};
pub use recording::{Format, GroundTruth, Recording};
pub use refusals::{Place, Reason, Refusal, Refusals};
pub use writer::RecordingWriter;
