//! The core's steady state, linked alone: if any panic could be reached, this would
//! not link.
//!
//! The panic handler below calls a function that nobody defines. The optimiser must
//! prove every bounds check and overflow away before the linker sees it; one that is
//! left names `a_panic_is_reachable_from_the_step` as undefined. Built for the target
//! only; on a host it is an empty program.
//!
//! What is linked: a node's `handle` for every kind of input, steps of both survival
//! rules included, and a terminal's `receive`, which decodes and encodes frames.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod alone {
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use amiro_ipf::event::{Boot, ClockSource};
    use amiro_ipf::filter::ParticleSet;
    use amiro_ipf::node::Node;
    use amiro_ipf::wire::Terminal;
    // Brings the interrupt vectors that the linker script asks for.
    use stm32f4xx_hal as _;

    const PARTICLES: usize = 8000;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        static mut SET: ParticleSet<PARTICLES> = ParticleSet::new();
        let boot = Boot {
            wire_version: 0,
            build_id: 0,
            capacity: 0,
            window: 0,
            baud: 0,
            clock: ClockSource::Host,
            core_hz: 0,
        };
        let mut terminal = Terminal::new(Node::new(SET), boot, 0);
        loop {
            // Any byte may come: the compiler can assume nothing about the inputs.
            let byte = black_box(0);
            terminal.receive(byte, &mut |frame, importance| {
                black_box((frame, importance));
            });
            terminal.report(black_box(Default::default()), &mut |frame, _| {
                black_box(frame);
            });
        }
    }

    #[expect(unsafe_code, reason = "the function is declared so that it is missing")]
    mod missing {
        unsafe extern "C" {
            pub(super) safe fn a_panic_is_reachable_from_the_step() -> !;
        }
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        missing::a_panic_is_reachable_from_the_step()
    }
}
