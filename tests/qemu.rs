//! The flash image in QEMU against the host: the same bytes.

use amiro_ipf::config::Config;
use amiro_ipf::event::Event;
use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::input::Input;
use amiro_ipf::sensor::Sample;
use sim_harness::link::{Board, Comparison, Layout, QemuOptions, build_image, drive};

#[test]
fn probe() {
    let image = sim_harness::link::Image::read(&build_image(Layout::Bare).unwrap()).unwrap();
    for profile in [Profile::Paper, Profile::Plus] {
        let mut inputs = vec![Input::Configure(Config::amiro(profile))];
        for row in 0..=200_u64 {
            let stamp_us = row * 8_000;
            let pose = Pose::new(row as f32 * 0.64e-3, 0.0, 0.0);
            let mut samples = [Sample::Counts(3); 8];
            samples[1] = Sample::Counts(110);
            samples[2] = Sample::Counts(100);
            inputs.push(Input::Odometry { stamp_us, pose });
            inputs.push(Input::Proximity { stamp_us, samples });
        }
        let mut comparison = Comparison::default();
        let mut host = Board::in_memory(|_| true);
        host.greet().unwrap();
        let t = std::time::Instant::now();
        drive(&mut host, &inputs, |event| comparison.expect(event), || ()).unwrap();
        eprintln!("host {:?}", t.elapsed());
        for icount in [true] {
            let options = QemuOptions {
                count_instructions: icount,
                ram_fill: Some(0xa5),
            };
            let mut board = Board::in_qemu(&image, &options).unwrap();
            eprintln!("{:?}", board.greet().unwrap());
            let mut meeting = Comparison::default();
            let mut c = std::mem::take(&mut comparison);
            let t = std::time::Instant::now();
            let mut last = None;
            drive(
                &mut board,
                &inputs,
                |event| {
                    c.meet(event);
                    if let Event::Status(s) = event {
                        last = Some(*s);
                    }
                },
                || (),
            )
            .unwrap();
            eprintln!(
                "qemu {:?} {}",
                t.elapsed(),
                c.verdict(board.boot(), board.lost_frames())
            );
            eprintln!("{last:?}");
            let _ = &mut meeting;
            // rebuild
            let mut host = Board::in_memory(|_| true);
            host.greet().unwrap();
            drive(&mut host, &inputs, |event| comparison.expect(event), || ()).unwrap();
        }
    }
}
