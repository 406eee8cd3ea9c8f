//! The cost of the beam filter in instructions of an emulated core.
//!
//! The example `beam_filter_cost` counts them; the emulator executes one per nanosecond.

use std::process::Command;

use crate::common;

/// What the example reports of a form of the filter and a number of particles.
#[derive(Clone, Debug)]
struct Row {
    form: String,
    particles: f64,
    motion: f64,
    weighing: f64,
}

impl Row {
    fn of(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [form, particles, motion, weighing, _, _] = words[..] else {
            return None;
        };
        Some(Self {
            form: form.to_owned(),
            particles: particles.parse().ok()?,
            motion: motion.parse().ok()?,
            weighing: weighing.parse().ok()?,
        })
    }

    /// Instructions of a cycle per beam and particle.
    fn per_pair(&self) -> f64 {
        (self.motion + self.weighing) / (32.0 * self.particles)
    }
}

fn counted() -> Vec<Row> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(common::root())
        .args(["build", "--release", "--quiet", "--locked"])
        .args(["--target", "thumbv7em-none-eabihf"])
        .args(["--example", "beam_filter_cost", "--target-dir", "target"])
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .status()
        .unwrap();
    assert!(status.success(), "the example was not built");
    let example = "target/thumbv7em-none-eabihf/release/examples/beam_filter_cost";
    let output = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0,sleep=off"])
        .args(["-no-reboot", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "stdio", "-kernel"])
        .arg(common::root().join(example))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<Row> = text.lines().filter_map(Row::of).collect();
    assert_eq!(rows.len(), 6, "{text}");
    rows
}

#[test]
fn a_cycle_is_linear_in_particles_with_thirty_instructions_per_beam_and_particle_at_most() {
    if !common::can_emulate() {
        return;
    }
    let rows = counted();
    for form in rows.chunk_by(|one, other| one.form == other.form) {
        let [first, .., last] = form else {
            unreachable!("{rows:?}")
        };
        assert_eq!((first.particles, last.particles), (200.0, 1000.0));
        for row in form {
            // Sets that differ by chance, and what does not grow with the particles.
            let ratio = row.per_pair() / last.per_pair();
            assert!((0.95..1.05).contains(&ratio), "{ratio}: {rows:?}");
            // 21.9 to 22.4 in 100 cycles of both forms.
            assert!(row.per_pair() < 30.0, "{rows:?}");
        }
    }
}
