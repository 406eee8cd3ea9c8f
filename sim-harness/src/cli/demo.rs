//! `cargo ipf demo`: the drive past a block, mapped by both profiles.

use std::path::PathBuf;

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;
use clap::Args;
use sim_harness::evaluation::{SCORES_IN_WORDS, Scores, Truth};
use sim_harness::mapping::{AllFreeMapper, Mapper};
use sim_harness::report::{CellWindow, Picture, beside, run_picture, save_run_map};
use sim_harness::world::{Scenario, simulate};
use sim_harness::{RunRecord, console, output, run};

use super::footprint::FootprintSwitch;
use super::{CommandResult, ExitStatus, arguments};

/// The drive-by, in the program itself: the demo needs no file.
const MSOD: &str = include_str!("../../../scenarios/msod.toml");

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub(super) struct Demo {
    /// Seed of the sensors' noise and of the filter.
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = arguments::seed)]
    seed: u64,
    /// Whether cells of the map whose centre has been under the robot's hull are free.
    #[arg(long, value_enum, default_value_t = FootprintSwitch::On, value_name = "on|off")]
    footprint: FootprintSwitch,
    /// Where the pictures go.
    #[arg(long, default_value = "out/demo", value_name = "DIR", value_parser = arguments::path())]
    out: PathBuf,
}

impl Demo {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        let scenario = Scenario::parse(MSOD)?;
        let profiles = [("paper", Profile::Paper), ("plus", Profile::Plus)];
        let mut run_records = Vec::new();
        let mut report = Vec::new();
        for (name, profile) in profiles {
            let (run_record, scores) = self.map(&scenario, profile)?;
            report.push(format!("{name:>8}  {scores}"));
            run_records.push((name, run_record));
        }
        if let Some((_, run_record)) = run_records.first() {
            let map = AllFreeMapper::new(scenario.cell_m, Some(&scenario.extent)).map();
            let scores = Scores::of(&map, &Truth::of(&scenario, run_record.poses()));
            report.push(format!("{:>8}  {scores}", "all-free"));
        }
        // One window for both, so that the pictures lie side by side at one scale.
        let window = run_records
            .iter()
            .filter_map(|(_, run_record)| CellWindow::known(&run_record.map()))
            .reduce(CellWindow::joined);
        let mut pictures: Vec<Picture> = Vec::new();
        for (name, run_record) in &run_records {
            let picture = run_picture(run_record, name, Some(&scenario), window);
            let folder = self.out.join(name);
            output::create_folder(&folder)?;
            save_run_map(run_record, &picture, &folder)?;
            pictures.push(picture);
        }
        let both = self.out.join("both.png");
        beside(&pictures).save_png(&both)?;
        console::print(&scenario.about);
        console::print(format_args!(
            "Simulated, seed {}, 1000 particles for each of eight sensors.",
            self.seed
        ));
        console::print("");
        console::print_text(SCORES_IN_WORDS);
        console::print("");
        report.iter().for_each(console::print);
        console::print("");
        console::print(format_args!(
            "Truth in red, path in blue: {}",
            both.display()
        ));
        Ok(ExitStatus::Good)
    }

    fn map(
        &self,
        scenario: &Scenario,
        profile: Profile,
    ) -> Result<(RunRecord, Scores), Box<dyn std::error::Error>> {
        let config = Config {
            seed: self.seed,
            ..scenario.config(profile)
        };
        let mut run_record =
            RunRecord::new(&config, scenario.cell_m, self.footprint.radius_m(&config));
        run(&config, &simulate(scenario, self.seed).inputs, |event| {
            run_record.take(event)
        })?;
        let scores = Scores::of(&run_record.map(), &Truth::of(scenario, run_record.poses()));
        Ok((run_record, scores))
    }
}
