//! Recordings: drives read from files, and written to them.
//!
//! Two formats, distinguished by their content:
//!
//! - the text that AMiRo's own recorder wrote, eleven columns per row;
//! - the bytes of the link, as the board and the simulator write them.
//!
//! A bad line or frame is refused with its place and reason, and the rest is used. A source
//! that has nothing usable at all is a [`LogError`]. Memory is bounded for every source: 64
//! KiB per line, 128 bytes per frame, 64 KiB of scenario, 4 KiB of faults.
//!
//! A [`StoredRecording`] stays on the disk: it is read once for its [`Overview`] and once
//! more for each kind of rows that is wanted, and may be of any length. [`read`] collects
//! all rows in memory, [`MOST_BYTES`] at most.

mod amiro_header;
mod amiro_text;
mod entries;
mod error;
mod origin;
mod overview;
mod percentile;
mod plausibility;
mod reader;
mod recording;
mod refusals;
mod rules;
mod sequence;
mod source;
mod stored;
mod stream;
mod writer;

pub use error::{LogError, Problem};
pub(crate) use origin::{head_of, is_of_a_robot, is_of_an_amiro};
pub use overview::Overview;
pub use reader::{MOST_BYTES, read, read_from};
pub use recording::{Format, GroundTruth, Recording};
pub use refusals::{Place, Reason, Refusal, Refusals};
pub use stored::{Rows, StoredRecording};
pub use writer::RecordingWriter;
