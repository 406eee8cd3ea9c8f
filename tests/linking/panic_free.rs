//! The core's steady state, linked alone: if any panic could be reached, this would
//! not link.
//!
//! The panic handler below calls a function that nobody defines. The optimiser must
//! prove every bounds check and overflow away before the linker sees it; one that is
//! left names `a_panic_is_reachable_from_the_step` as undefined. Built for the target
//! only; on a host it is an empty program.
//!
//! What is linked: a node's `handle` for every kind of input, steps of both survival
//! rules included, a terminal's `receive`, which decodes and encodes frames, and the
//! ring of sensors: rounds on both buses, states and values, the measurement of the
//! offsets and their way to the memory and back; the senses as a whole with the frames of
//! the robot's bus; what is kept of a life that ended; cycles, queries and sharing of the
//! beam filter; steps of dead reckoning.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod alone {
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use amiro_ipf::beam_filter::{
        BeamFilterParameters, BeamModel, BeamParticle, BeamParticleFilter, BeamRange, RangeBeam,
    };
    use amiro_ipf::board::acquisition::{Acquisition, Bus, ProximityRing};
    use amiro_ipf::board::calibration::OffsetMeasurement;
    use amiro_ipf::board::can::{CanFrame, CanIdentifier};
    use amiro_ipf::board::clock_choice::ClockSource;
    use amiro_ipf::board::eeprom;
    use amiro_ipf::board::offsets::{Offsets, STORE_BYTES};
    use amiro_ipf::board::supervision::{
        BootHistory, HISTORY_WORDS, LoadGuard, PostMortem, RECORD_WORDS,
    };
    use amiro_ipf::dead_reckoning::{
        DeadReckoning, DeadReckoningModel, DeadReckoningParameters, WheelCorrection,
    };
    use amiro_ipf::filter::ParticleSet;
    use amiro_ipf::geometry::{Angle, Motion, Point, Pose};
    use amiro_ipf::link::{Boot, DeviceEndpoint};
    use amiro_ipf::model::{DifferentialDrive, WheelSpeeds};
    use amiro_ipf::node::{Node, seed};
    use amiro_ipf::random::Generator;
    // Brings the interrupt vectors that the linker script asks for.
    use stm32f4xx_hal as _;

    const PARTICLES: usize = 8000;
    const BEAM_PARTICLES: usize = 1000;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        static mut SET: ParticleSet<PARTICLES> = ParticleSet::new();
        static mut BEAMS: BeamParticleFilter<BEAM_PARTICLES> = BeamParticleFilter::new();
        let boot = Boot {
            wire_version: 0,
            build_id: 0,
            capacity: 0,
            window: 0,
            baud: 0,
            clock: ClockSource::Host,
            core_hz: 0,
        };
        let mut endpoint = DeviceEndpoint::new(Node::new(SET), boot, 0);
        let mut ring = ProximityRing::new();
        let mut acquisition = Acquisition::new();
        loop {
            map_beams(BEAMS);
            reckon();
            sense(&mut ring);
            sense_whole(&mut acquisition);
            supervise();
            // Any byte may come: the compiler can assume nothing about the inputs.
            let byte = black_box(0);
            endpoint.receive(byte, &mut |frame, priority| {
                black_box((frame, priority));
            });
            endpoint.report(black_box(Default::default()), &mut |frame, _| {
                black_box(frame);
            });
        }
    }

    /// Whatever the buses answer, and whatever is in the memory.
    fn sense(ring: &mut ProximityRing) {
        let now_us = black_box(0);
        for bus in [Bus::I2c1, Bus::I2c2] {
            let branch = ring.bus_mut(bus);
            branch.begin_round(now_us, black_box(true));
            while let Some(transaction) = branch.next(black_box(now_us)) {
                black_box((&transaction, transaction.clocks()));
                let bytes = [0; 16];
                let answer = black_box(Ok(&bytes[..]));
                branch.answer(black_box(now_us), answer);
            }
        }
        black_box((ring.samples(now_us), ring.states(now_us), ring.counters()));
        black_box(ring.raw(black_box(0)));

        let known = Offsets::decode(&black_box([0; STORE_BYTES])).unwrap_or_default();
        let mut measurement = OffsetMeasurement::new(&known);
        while !measurement.take(&ring.trusted_raw(black_box(now_us))) {}
        let _ = black_box(measurement.results());
        let Some(offsets) = measurement.offsets() else {
            return;
        };
        ring.set_offsets(offsets.counts);
        let mut bytes = black_box([0; STORE_BYTES]);
        offsets.encode(&mut bytes);
        for part in eeprom::writes(eeprom::ADDRESS_AMIRO, black_box(0), &bytes) {
            black_box(part);
        }
        for part in eeprom::reads(eeprom::ADDRESS_AMIRO, black_box(0), black_box(36)) {
            black_box(part);
        }
    }

    /// Whatever the range sensors measure, however the robot moves, whatever others send.
    fn map_beams(filter: &mut BeamParticleFilter<BEAM_PARTICLES>) {
        let parameters = black_box(BeamFilterParameters::MOVING);
        let Ok(model) = BeamModel::new(parameters) else {
            return;
        };
        let mut rng = Generator::seeded(black_box(0));
        let heading = Angle::from_radians(black_box(0.0));
        filter.reset(&model, black_box(0), heading, &mut rng);
        let pose = black_box(Pose::default());
        let range = black_box(BeamRange::Echo(0.0));
        let Ok(beam) = RangeBeam::new(&pose, range) else {
            return;
        };
        let beams = [beam; 32];
        let seen = beams.get(..black_box(0)).unwrap_or_default();
        let motion = Motion {
            displacement: black_box(Point::default()),
            turn: heading,
        };
        black_box(filter.cycle(&model, &motion, seen, &mut rng));
        black_box(filter.advance(&model, &motion, &mut rng));
        black_box(filter.set_heading(heading));
        black_box((filter.nearest_obstacle(black_box(0.0)), filter.digest()));
        for particle in filter.particles() {
            black_box(particle);
        }
        let mut batch = black_box([BeamParticle::default(); 64]);
        let room = batch.get_mut(..black_box(0)).unwrap_or_default();
        black_box(filter.export(room));
        let frame = filter.particle_frame(&pose);
        black_box(filter.import(&model, &frame, &black_box(pose), &batch));
    }

    /// Whatever wheels and compass measure.
    fn reckon() {
        let mut parameters = DeadReckoningParameters::of(DifferentialDrive::AMIRO);
        parameters.drive.correction = black_box(WheelCorrection::NONE);
        let Ok(model) = DeadReckoningModel::new(black_box(parameters)) else {
            return;
        };
        let mut filter = black_box(DeadReckoning::starting_at(&model, &Pose::default()));
        let speeds: Option<WheelSpeeds> = black_box(None);
        let compass = black_box(0.0).into();
        black_box(filter.step(&model, speeds, black_box(Some(compass))));
        black_box((filter.pose(), filter.covariance()));
        black_box(model.parameters().drive.motion(filter.speeds(), 0.1));
    }

    /// Whatever comes over the robot's bus, at any time.
    fn sense_whole(acquisition: &mut Acquisition) {
        let now_us = black_box(0);
        for bus in [Bus::I2c1, Bus::I2c2] {
            black_box(acquisition.next(bus, now_us));
            acquisition.answer(bus, now_us, black_box(Ok(&[0; 16][..])));
        }
        black_box(acquisition.poll(now_us));
        let identifier = black_box(CanIdentifier::Extended(0));
        let frame = CanFrame::received(
            identifier,
            black_box(false),
            black_box(8),
            black_box([0; 8]),
        );
        black_box(acquisition.take_frame(now_us, &frame));
        black_box(acquisition.frame_due(now_us));
        if black_box(true) {
            acquisition.calibrate();
        }
        black_box((
            acquisition.take_offsets(),
            acquisition.sensors(now_us),
            acquisition.buses(),
        ));
    }

    /// Whatever the last life left behind.
    fn supervise() {
        let record = PostMortem::from_words(&black_box([0; RECORD_WORDS]));
        black_box(record.map(|record| record.at(black_box(""), 0).to_words()));
        let mut history = BootHistory::begin(black_box([0; HISTORY_WORDS]), black_box(true));
        history.record_uptime(black_box(0));
        black_box((history.is_loop(), history.to_words()));
        let mut load = LoadGuard::new(black_box(0));
        black_box(load.on_step(black_box(0), black_box(0)));
        black_box(seed::from_words(&black_box([0; seed::WORDS])));
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
