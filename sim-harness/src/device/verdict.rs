//! The result of a comparison of two runs.

use std::fmt;

/// Whether two runs are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Equality {
    /// Everything was compared and equal.
    Equal,
    /// All digests and all received messages are equal; particle or walls messages were
    /// lost.
    ParticlesLost,
    /// Something differs, is missing or was too many.
    Different,
}

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Whether the runs are equal.
    pub equality: Equality,
    /// Whether everything was compared and equal.
    pub equal: bool,
    /// The first step in which they differ.
    pub first_different_step: Option<u32>,
    /// The last step, where a recording ends within it or in front of it.
    pub ends_within_step: Option<u32>,
    /// Step messages compared equal, the begin of each.
    pub steps: usize,
    /// Digests compared equal.
    pub digests: usize,
    /// Particle messages compared equal.
    pub particle_messages: usize,
    /// Particle outcomes in them.
    pub particles: usize,
    /// Particle messages of the host's run that are missing.
    pub particle_messages_lost: u64,
    /// Walls messages compared equal; none but in the profile `wall`.
    #[serde(skip_serializing_if = "is_zero")]
    pub walls_messages: usize,
    /// Walls messages of the host's run that are missing.
    #[serde(skip_serializing_if = "is_none_lost")]
    pub walls_messages_lost: u64,
    /// Steps that the host computed.
    pub expected_steps: usize,
    /// Why it is not equal.
    pub reasons: Vec<String>,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.equality, self.first_different_step) {
            (Equality::Equal, _) => f.write_str("EQUAL")?,
            (Equality::ParticlesLost, _) => {
                f.write_str("EQUAL")?;
                let lost = [
                    (self.particle_messages_lost, "particle"),
                    (self.walls_messages_lost, "walls"),
                ];
                for (count, kind) in lost {
                    if count > 0 {
                        write!(f, ", {count} {kind} messages lost")?;
                    }
                }
            }
            (Equality::Different, Some(step)) => write!(f, "DIFFERENT at step {step}")?,
            (Equality::Different, None) => f.write_str("DIFFERENT")?,
        }
        write!(
            f,
            ": {} of {} steps, {} digests, {} particle messages with {} outcomes compared equal",
            self.steps, self.expected_steps, self.digests, self.particle_messages, self.particles
        )?;
        if self.walls_messages > 0 {
            write!(f, ", {} walls messages too", self.walls_messages)?;
        }
        if let Some(step) = self.ends_within_step {
            write!(f, "\n  the recording ends within step {step}")?;
        }
        for reason in &self.reasons {
            write!(f, "\n  {reason}")?;
        }
        Ok(())
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that serde calls"
)]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that serde calls"
)]
fn is_none_lost(count: &u64) -> bool {
    *count == 0
}
