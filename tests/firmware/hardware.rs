//! docs/hardware.md against the code: whoever changes a pin, a period, a priority or an
//! address changes the page in the same breath.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use amiro_ipf::board::acquisition::{AMIRO_CONNECTIONS, Bus, ODOMETRY_AGE_US, ROUND_US};
use amiro_ipf::board::can::{CYCLE_US, LEAST_GAP_US, READ_IDS, StandardId, proximity_ring};
use amiro_ipf::board::i2c::muxed_bus::{MUX_ADDRESS, USUAL_ROUND_CLOCKS};
use amiro_ipf::board::{budget, can, eeprom, i2c, vcnl4020};
use amiro_ipf::model::{Ring, SENSORS};

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// All code of a folder of the firmware, without its comments.
fn code_of(folder: &str) -> String {
    let mut code = String::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let text = fs::read_to_string(path).unwrap();
            let lines = text.lines().filter(|it| !it.trim_start().starts_with("//"));
            lines.for_each(|line| {
                code.push_str(line);
                code.push('\n');
            });
        }
    }
    code
}

/// The rows of the tables of a section whose first heading is `first`, without heads.
fn rows(section: &str, first: &str) -> Vec<Vec<String>> {
    let page = read("docs/hardware.md");
    let section = page
        .split_once(&format!("\n## {section}\n"))
        .map(|(_, rest)| rest.split("\n## ").next().unwrap_or_default())
        .unwrap_or_default();
    let mut rows = Vec::new();
    let mut is_inside = false;
    for line in section.lines() {
        let cells: Vec<String> = line
            .strip_prefix("| ")
            .and_then(|line| line.strip_suffix(" |"))
            .map(|line| line.split(" | ").map(str::to_owned).collect())
            .unwrap_or_default();
        match cells.first() {
            None => is_inside = false,
            Some(cell) if cell == first => is_inside = true,
            Some(cell) if cell.starts_with("---") => {}
            Some(_) if is_inside => rows.push(cells),
            Some(_) => {}
        }
    }
    assert!(!rows.is_empty(), "no table of {first} in {section}");
    rows
}

/// Names of pins in the code, as `PA2`.
fn pins_of(code: &str) -> BTreeSet<String> {
    code.split(|letter: char| !letter.is_ascii_alphanumeric())
        .filter(|word| {
            let mut letters = word.chars();
            letters.next() == Some('p')
                && letters.next().is_some_and(|it| ('a'..='i').contains(&it))
                && word.len() > 2
                && letters.all(|it| it.is_ascii_digit())
        })
        .map(str::to_uppercase)
        .collect()
}

#[test]
fn every_pin_that_the_board_names_is_in_the_table_and_no_other() {
    let named = pins_of(&code_of("src/bin/firmware/hal"));
    let mut listed = BTreeSet::new();
    let mut alone = BTreeSet::new();
    for row in rows("Pins", "pin") {
        let names = row[0].split(", ").map(str::to_owned);
        if row[2].starts_with("left alone") {
            alone.extend(names);
        } else {
            listed.extend(names);
        }
    }
    assert_eq!(listed, named, "the page, the code");
    let both: Vec<_> = alone.intersection(&named).collect();
    assert!(
        both.is_empty(),
        "left alone, yet named by the code: {both:?}"
    );
}

#[test]
fn pins_match_the_table() {
    let code: String = code_of("src/bin/firmware/hal").split_whitespace().collect();
    for row in rows("Pins", "pin") {
        let pin = row[0].to_lowercase();
        let port = pin.get(1..2).unwrap_or_default();
        let call = match row[2].as_str() {
            "alternate" => ".into_alternate()",
            "push-pull, high" => ".into_push_pull_output_in_state(PinState::High)",
            "open drain, high" => ".into_open_drain_output_in_state(PinState::High)",
            "open drain, low" => ".into_open_drain_output_in_state(PinState::Low)",
            "input" => ".into_input()",
            "open drain by the I2C port" => ",",
            other => {
                assert!(other.starts_with("left alone"), "{pin}: {other}");
                continue;
            }
        };
        let wanted = format!("gpio_{port}.{pin}{call}");
        assert!(code.contains(&wanted), "the code has no {wanted}");
    }
    // Which unit's, in which order: clock, then data.
    for ports in [
        "Port::one(device.I2C1,gpio_b.pb8,gpio_b.pb9,core_hz)",
        "Port::two(device.I2C2,gpio_b.pb10,gpio_b.pb11,core_hz)",
        "Alternate<4,OpenDrain>",
    ] {
        assert!(code.contains(ports), "the code has no {ports}");
    }
}

#[test]
fn the_debug_probe_s_section_names_the_runner_its_pins_and_the_log_s_level() {
    let page = read("docs/hardware.md");
    let (_, section) = page.split_once("\n## Debug probe\n").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let settings = read(".cargo/config.toml");
    let value = |key: &str| {
        let line = settings.lines().find(|line| line.starts_with(key)).unwrap();
        line.split('"').nth(1).unwrap()
    };
    let runner = value("runner");
    assert!(section.contains(&format!("`{runner}`")), "{runner}");
    let level = value("DEFMT_LOG");
    assert!(section.contains(&format!("sets `{level}`")), "{level}");
    let chip = runner.split_once("--chip ").unwrap().1;
    for command in section.lines().filter(|line| line.starts_with("probe-rs ")) {
        assert!(command.contains(&format!("--chip {chip}")), "{command}");
    }
    let pins: Vec<String> = rows("Debug probe", "probe")
        .into_iter()
        .map(|row| row[1].clone())
        .filter(|pin| pin.starts_with('P'))
        .collect();
    let pins = pins.join(", ");
    let debugger_s = "left alone: the debugger's";
    let alone = rows("Pins", "pin");
    let row = alone.iter().find(|row| row[2] == debugger_s).unwrap();
    assert_eq!(row[0], pins);
}

#[test]
fn sensors_are_where_the_table_has_them() {
    let rows = rows("Sensors", "sensor");
    assert_eq!(rows.len(), SENSORS);
    for (index, (row, place)) in rows.iter().zip(AMIRO_CONNECTIONS).enumerate() {
        let bus = match place.bus {
            Bus::I2c1 => "I2C1",
            Bus::I2c2 => "I2C2",
        };
        let frame = proximity_ring(index, 0, 0).unwrap();
        let amiro_ipf::board::can::CanIdentifier::Standard(identifier) = frame.identifier() else {
            unreachable!("{frame:?}")
        };
        let axis = Ring::AMIRO.axis_rad[index].to_degrees();
        let expected = [
            index.to_string(),
            format!("{axis:.1}°"),
            bus.to_owned(),
            place.channel.number().to_string(),
            format!("{:#05x}", identifier.bits()),
        ];
        let [sensor, _, axis, bus, channel, identifier] = &row[..] else {
            unreachable!("{row:?}")
        };
        assert_eq!(
            [sensor, axis, bus, channel, identifier].map(Clone::clone),
            expected
        );
    }
}

#[test]
fn addresses_are_the_drivers() {
    let addresses: Vec<(String, String)> = rows("Addresses", "part")
        .into_iter()
        .map(|row| (row[0].clone(), row[3].clone()))
        .collect();
    let expected = [
        ("PCA9544A", MUX_ADDRESS.bits()),
        ("VCNL4020", vcnl4020::ADDRESS),
        ("AT24C01", eeprom::ADDRESS_AMIRO),
    ]
    .map(|(part, address)| (part.to_owned(), format!("{address:#04x}")));
    assert_eq!(addresses, expected);
}

#[test]
fn messages_that_are_read_are_those_of_the_filters() {
    let listed: Vec<u16> = rows("Messages of the robot's bus", "message")
        .iter()
        .map(|row| u16::from_str_radix(row[1].trim_start_matches("0x"), 16).unwrap())
        .collect();
    assert_eq!(listed, READ_IDS.map(StandardId::bits));
}

#[test]
fn bit_timings_are_the_units() {
    let rows = rows("Messages of the robot's bus", "bus clock");
    assert_eq!(rows.len(), 2);
    for (row, hz) in rows.iter().zip([42_000_000_u32, 16_000_000]) {
        let bits = can::BitTiming::at(hz).unwrap().bits();
        let (prescaler, first, second) = (
            (bits & 0x3ff) + 1,
            (bits >> 16 & 0xf) + 1,
            (bits >> 20 & 7) + 1,
        );
        let quanta = 1 + first + second;
        assert_eq!(hz / prescaler / quanta, 1_000_000);
        let sampled = f64::from(1 + first) / f64::from(quanta) * 100.0;
        let expected = [
            format!("{} MHz", hz / 1_000_000),
            prescaler.to_string(),
            format!("1 + {first} + {second} = {quanta}"),
            format!("{} / {quanta} = {sampled:.0} %", 1 + first),
            format!("{bits:#010x}"),
        ];
        assert_eq!(row[..], expected);
    }
    // CCR 35 in fast mode, TRISE 13.
    let timing = format!("{:?}", i2c::I2cTiming::fast(42_000_000));
    let expected = format!(
        "I2cTiming {{ megahertz: 42, clock: {}, rise: 13 }}",
        0x8000 | 35
    );
    assert_eq!(timing, expected);
    let page = read("docs/hardware.md");
    assert!(page.contains("3 × CCR = 3 × 35 bus cycles") && page.contains("MHz + 1 = 13"));
}

/// Name, priority and interrupt of each task, from the attributes in `main.rs`.
fn tasks() -> BTreeMap<String, (String, Option<String>)> {
    let code = read("src/bin/firmware/main.rs");
    let mut tasks = BTreeMap::new();
    for part in code.split("#[task(").skip(1) {
        let (attribute, rest) = part.split_once(")]\n").unwrap();
        let value = |name: &str| {
            let (_, value) = attribute.split_once(&format!("{name} = "))?;
            Some(value.split(',').next()?.trim().to_owned())
        };
        let (_, rest) = rest.split_once("fn ").unwrap();
        let name = rest.split('(').next().unwrap().to_owned();
        tasks.insert(name, (value("priority").unwrap(), value("binds")));
    }
    tasks
}

#[test]
fn tasks_have_the_priorities_and_interrupts_of_the_table() {
    let tasks = tasks();
    let rows = rows("Tasks", "task");
    assert_eq!(rows.len(), tasks.len(), "{tasks:?}");
    for row in rows {
        let (priority, binds) = &tasks[&row[0]];
        assert_eq!(&row[1], priority, "{row:?}");
        match binds {
            Some(interrupt) => assert_eq!(&row[2], interrupt, "{row:?}"),
            None => assert!(row[2].starts_with("the timer, "), "{row:?}"),
        }
    }
    let code = read("src/bin/firmware/main.rs");
    // The timer's two, 2 kHz and 8 Hz.
    for period in ["next += 500.micros();", "next += 125.millis();"] {
        assert!(code.contains(period), "{period}");
    }
}

#[test]
fn tasks_have_the_priorities_of_the_program_s_own_table() {
    let code = read("src/bin/firmware/main.rs");
    let mut listed = BTreeMap::new();
    for line in code.lines().filter_map(|line| line.strip_prefix("//! | `")) {
        let cells: Vec<&str> = line.split(" | ").collect();
        // "`bus_one`, `bus_two` and their `_error`"
        for (place, name) in cells[0].split('`').step_by(2).enumerate() {
            if name == "_error" {
                let both: Vec<String> = listed.keys().cloned().collect();
                for bus in both.iter().filter(|name| name.starts_with("bus_")) {
                    listed.insert(format!("{bus}_error"), cells[1].to_owned());
                }
            } else if place == 0 || !name.is_empty() {
                listed.insert(name.to_owned(), cells[1].to_owned());
            }
        }
    }
    let written: BTreeMap<String, String> = tasks()
        .into_iter()
        .map(|(name, (priority, _))| (name, priority))
        .collect();
    assert_eq!(listed, written);
}

/// A constant in the text of a file, as a number.
fn constant(path: &str, name: &str) -> u64 {
    let text = read(path);
    let (_, rest) = text.split_once(&format!("const {name}: ")).unwrap();
    let (_, value) = rest.split_once(" = ").unwrap();
    let value = value.split(';').next().unwrap().replace('_', "");
    value.parse().unwrap()
}

#[test]
fn numbers_are_the_code_s() {
    let image = |file: &str, name: &str| constant(&format!("src/bin/firmware/{file}"), name);
    let expected = [
        ("CORE_HZ", image("hal/clocks.rs", "CORE_HZ")),
        ("CRYSTAL_HZ", image("hal/clocks.rs", "CRYSTAL_HZ")),
        ("TICK_HZ", image("clock.rs", "TICK_HZ")),
        ("ROUND_US", ROUND_US),
        ("USUAL_ROUND_CLOCKS", u64::from(USUAL_ROUND_CLOCKS)),
        ("CYCLE_US", CYCLE_US),
        ("LEAST_GAP_US", LEAST_GAP_US),
        ("ODOMETRY_AGE_US", ODOMETRY_AGE_US),
        ("WATCHDOG_MS", image("hal/mod.rs", "WATCHDOG_MS")),
        ("RESTART", image("hal/mod.rs", "RESTART")),
        ("HEALTH_EVERY", image("sampler.rs", "HEALTH_EVERY")),
        ("CAN_EVERY", image("sampler.rs", "CAN_EVERY")),
        ("STALL_US", constant("src/board/i2c/limits.rs", "STALL_US")),
        ("CAPACITY", budget::CAPACITY as u64),
        ("SEND_QUEUE", budget::SEND_QUEUE as u64),
        ("RECEIVE_QUEUE", budget::RECEIVE_QUEUE as u64),
        ("REPORT_QUEUE", budget::REPORT_QUEUE as u64),
        ("GUARD", image("hal/stack.rs", "GUARD")),
    ]
    .map(|(name, value)| (name.to_owned(), value.to_string()));
    let listed: Vec<(String, String)> = rows("Numbers", "name")
        .into_iter()
        .map(|row| (row[0].clone(), row[1].clone()))
        .collect();
    assert_eq!(listed, expected);
}

#[test]
fn layouts_are_the_linker_s() {
    let linker = read("build.rs");
    let listed: Vec<[String; 2]> = rows("Memory", "layout")
        .into_iter()
        .map(|row| [row[1].clone(), row[3].clone()])
        .collect();
    for ([start, room], wanted) in listed.iter().zip([
        ("LENGTH = 1024K\n", "1024 KiB"),
        ("LENGTH = 1024K - 32K\n", "992 KiB"),
    ]) {
        let region = format!("ORIGIN = {start}, {}", wanted.0);
        assert!(linker.contains(&region), "build.rs has no {region}");
        assert_eq!(room, wanted.1);
    }
    assert!(linker.contains("_stext = ORIGIN(FLASH) + 0x200;"));
    assert!(linker.contains("ORIGIN(FLASH) + 0x1ac"));
    assert!(read("memory.x").contains("ORIGIN = 0x20000000, LENGTH = 128K"));
    let loader = read("src/bin/firmware/hal/loader.rs");
    assert!(loader.contains("0x0800_01c0") && loader.contains("0x412d_424c"));
    assert!(loader.contains("SHUT_DOWN: usize = 32;"));
}
