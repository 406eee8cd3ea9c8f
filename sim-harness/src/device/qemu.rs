//! The flash image in QEMU: a board without sensors, with a serial line.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

#[cfg(unix)]
use super::{Board, Image, Layout, LinkError, unix_socket};

/// QEMU's name for a board with an STM32F405.
const MACHINE: &str = "netduinoplus2";

/// The emulator's program.
const PROGRAM: &str = "qemu-system-arm";

/// Start of the RAM and its size, for filling it beforehand.
const RAM_START: u32 = 0x2000_0000;
const RAM_SIZE: usize = 128 * 1024;

/// How the emulator is run.
#[derive(Clone, Debug, Default)]
pub struct QemuOptions {
    /// Count one instruction per nanosecond, so that cycle counts are instructions.
    pub count_instructions: bool,
    /// With counted instructions: do not wait while the core waits for an interrupt. The
    /// board's time then runs ahead of the host's.
    pub skip_idle: bool,
    /// Fill the RAM with this byte before every reset, as silicon's is never zero.
    pub ram_fill: Option<u8>,
    /// Flash the image with the lowest bit of this byte flipped.
    pub flipped: Option<usize>,
    /// Flash this boot loader in front of the image, which must be linked for
    /// [`Layout::Amiro`]. At most 32 KiB; the core starts in it.
    pub boot_loader: Option<Vec<u8>>,
    /// Connect the serial line to a socket and not to pipes: a host can then close and
    /// reopen the link, and frames of the time between are lost, as on a real line. A pipe
    /// without a reader would stop the emulator.
    pub can_disconnect: bool,
    /// Listen on this Unix socket for a debugger.
    pub debugger: Option<PathBuf>,
}

impl Board {
    /// Starts the image in QEMU. The emulator ends with the board.
    ///
    /// # Errors
    /// [`LinkError::Start`] when QEMU is not installed or does not start.
    pub fn in_qemu(image: &Image, options: &QemuOptions) -> Result<Self, LinkError> {
        let flash = ScratchFile::write("flash", &flash_content(image, options))?;
        let ram = match options.ram_fill {
            Some(byte) => Some(ScratchFile::write("ram", &vec![byte; RAM_SIZE])?),
            None => None,
        };
        let line = options.can_disconnect.then(|| scratch_path("line"));
        let mut command = command(options, &flash.path, ram.as_ref(), line.as_deref());
        let mut child = command.spawn().map_err(|error| start_error(&error))?;
        let pipes = child.stdout.take().zip(child.stdin.take());
        let emulator = Emulator {
            child,
            _files: (flash, ram, line.clone().map(|path| ScratchFile { path })),
        };
        match (line, pipes) {
            (None, Some((output, input))) => Ok(Self::over(output, input, emulator)),
            (None, None) => Err(LinkError::Start(format!("{PROGRAM} has no pipes"))),
            #[cfg(unix)]
            (Some(line), _) => Self::reopened_by(move || unix_socket::connect(&line), emulator),
            #[cfg(not(unix))]
            (Some(_), _) => Err(LinkError::Start(
                "there are no Unix sockets here".to_owned(),
            )),
        }
    }

    /// Whether QEMU can be started here.
    #[must_use]
    pub fn is_qemu_installed() -> bool {
        Command::new(PROGRAM)
            .arg("--version")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success())
    }
}

/// What is flashed, as bytes and not as an ELF file: QEMU would clear the statics, which
/// silicon leaves to the start code.
fn flash_content(image: &Image, options: &QemuOptions) -> Vec<u8> {
    let layout = match options.boot_loader {
        None => Layout::Bare,
        Some(_) => Layout::Amiro,
    };
    let mut flash = image.flashable(layout);
    if let Some(byte) = options.flipped.and_then(|byte| flash.get_mut(byte)) {
        *byte ^= 1;
    }
    if let Some(boot_loader) = &options.boot_loader {
        let mut whole = boot_loader.clone();
        whole.resize((layout.start() - Layout::Bare.start()) as usize, 0xff);
        whole.append(&mut flash);
        flash = whole;
    }
    flash
}

/// The emulator's command line.
fn command(
    options: &QemuOptions,
    flash: &Path,
    ram: Option<&ScratchFile>,
    line: Option<&Path>,
) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .args(["-M", MACHINE, "-display", "none", "-monitor", "none"])
        // The first line is USART1, whose start crashes the emulator; ours is the second.
        .args(["-serial", "null", "-serial"])
        .stderr(Stdio::null());
    match line {
        None => command
            .arg("stdio")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped()),
        Some(line) => command
            .arg(format!("unix:{},server=on,wait=off", line.display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null()),
    };
    command.arg("-kernel").arg(flash);
    match (options.count_instructions, options.skip_idle) {
        (true, true) => _ = command.args(["-icount", "shift=0,sleep=off"]),
        (true, false) => _ = command.args(["-icount", "shift=0"]),
        (false, _) => {}
    }
    if let Some(socket) = &options.debugger {
        let socket = socket.display();
        command
            .arg("-chardev")
            .arg(format!(
                "socket,id=debugger,path={socket},server=on,wait=off"
            ))
            .args(["-gdb", "chardev:debugger"]);
    }
    if let Some(ram) = ram {
        command.arg("-device").arg(format!(
            "loader,file={},addr={RAM_START:#x},force-raw=on",
            ram.path.display()
        ));
    }
    command
}

fn start_error(error: &io::Error) -> LinkError {
    match error.kind() {
        io::ErrorKind::NotFound => LinkError::Start(format!(
            "{PROGRAM} is not installed (Debian, Ubuntu: apt-get install qemu-system-arm)"
        )),
        _ => LinkError::Start(format!("{PROGRAM}: {error}")),
    }
}

/// The emulator's process; ends when dropped.
struct Emulator {
    child: Child,
    _files: (ScratchFile, Option<ScratchFile>, Option<ScratchFile>),
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended by itself; the wait collects its exit status.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A path for a file that no other emulator uses.
fn scratch_path(kind: &str) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = format!("amiro-ipf-{kind}-{}-{number}.bin", std::process::id());
    std::env::temp_dir().join(name)
}

/// A file for the emulator to read; removed when dropped.
struct ScratchFile {
    path: PathBuf,
}

impl ScratchFile {
    fn write(kind: &str, content: &[u8]) -> Result<Self, LinkError> {
        let path = scratch_path(kind);
        std::fs::File::create(&path)
            .and_then(|mut file| file.write_all(content))
            .map_err(|error| LinkError::Start(format!("{}: {error}", path.display())))?;
        Ok(Self { path })
    }
}

impl Drop for ScratchFile {
    fn drop(&mut self) {
        // A file that stays does no harm.
        let _ = std::fs::remove_file(&self.path);
    }
}
