//! The flash image: built, and checked from its ELF file.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

use amiro_ipf::checksum::CRC;
use amiro_ipf::filter::ParticleSet;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSection, ObjectSymbol};

use super::ImageError;
use crate::bounded::read_at_most;

/// Where the image lies in flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A bare board: from the start of the flash.
    Bare,
    /// Behind AMiRo's boot loader.
    Amiro,
}

const FLASH_START: u64 = 0x0800_0000;
const FLASH_END: u64 = FLASH_START + 0x10_0000;
const BOOT_LOADER_SIZE: u64 = 0x8000;
const RAM_END: u64 = 0x2002_0000;
/// 16 core vectors and 82 of the STM32F405, four bytes each.
const VECTORS_SIZE: u64 = 0x188;
/// Where AMiRo's boot loader writes its checksum, from the start of the image.
const CHECKSUM_OFFSET: u64 = 0x1ac;
/// Vectors that it is made of.
const CHECKED_VECTORS: usize = 7;
const CHECKSUM_PLACEHOLDER: u32 = 0x55aa_11ee;
/// Where AMiRo's layout lets code begin, from the start of the image.
const AMIRO_TEXT_OFFSET: u64 = 0x200;
/// Longest ELF file that is read: the flash's megabyte and many times that of symbols.
const MOST_BYTES: u64 = 64 << 20;
/// RTIC's name for the particle set of the main task.
const PARTICLES: &str = "__rtic_internal_local_init_particles";
/// An image that lost its linker script is all but empty.
const LEAST_TEXT: u64 = 10_000;

impl Layout {
    /// Address of the vector table.
    #[must_use]
    pub fn start(self) -> u64 {
        match self {
            Self::Bare => FLASH_START,
            Self::Amiro => FLASH_START + BOOT_LOADER_SIZE,
        }
    }

    /// Address of the first instruction behind vectors and, if need be, checksum.
    fn text_start(self) -> u64 {
        match self {
            Self::Bare => self.start() + VECTORS_SIZE,
            Self::Amiro => self.start() + AMIRO_TEXT_OFFSET,
        }
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bare => write!(f, "bare board, {:#010x}", self.start()),
            Self::Amiro => write!(f, "AMiRo boot loader, {:#010x}", self.start()),
        }
    }
}

/// Builds the flash image from the sources that this harness was built from; its path.
///
/// # Errors
/// [`ImageError::Build`] when cargo is missing or fails; its output goes to the terminal.
pub fn build_image(layout: Layout) -> Result<PathBuf, ImageError> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let target = root.join(match layout {
        Layout::Bare => "target",
        Layout::Amiro => "target/amiro-layout",
    });
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .current_dir(&root)
        .args(["build", "--release", "--quiet", "--locked"])
        .args(["--target", "thumbv7em-none-eabihf", "--bin", "firmware"])
        .arg("--target-dir")
        .arg(&target)
        // Flags from outside would replace the linker script and link nothing.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    if layout == Layout::Amiro {
        command.args(["--features", "amiro-layout"]);
    }
    let status = command
        .status()
        .map_err(|error| ImageError::Build(format!("cargo: {error}")))?;
    if !status.success() {
        return Err(ImageError::Build(format!("cargo ended with {status}")));
    }
    Ok(target.join("thumbv7em-none-eabihf/release/firmware"))
}

/// The contents of the ELF file.
#[derive(Clone, Debug)]
pub struct Image {
    sections: Vec<Section>,
    /// First words of the vector table: stack pointer, reset vector.
    stack_pointer: u32,
    reset_vector: u32,
    checksum_word: Option<u32>,
    ram_end_of_statics: u64,
    heap_symbols: Vec<String>,
    flash: Vec<u8>,
    /// Address of the mark by which the image checks itself.
    mark: Option<u64>,
    /// Names and addresses.
    symbols: Vec<(String, u64)>,
    /// Bytes of the particle set; `None` for an image without symbols.
    particle_bytes: Option<u64>,
}

#[derive(Clone, Debug)]
struct Section {
    name: String,
    address: u64,
    size: u64,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ImageError::Read`], [`ImageError::NotAnImage`].
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let bytes =
            read_at_most(path, MOST_BYTES).map_err(|error| ImageError::Read(path.into(), error))?;
        let not_an_image = |reason: String| ImageError::NotAnImage(path.into(), reason);
        let file: ElfFile32<'_> =
            ElfFile32::parse(&*bytes).map_err(|error| not_an_image(error.to_string()))?;
        let sections: Vec<Section> = file
            .sections()
            .filter(|section| section.address() != 0 && section.size() > 0)
            .map(|section| Section {
                name: section.name().unwrap_or("?").to_owned(),
                address: section.address(),
                size: section.size(),
            })
            .collect();
        let word = |section: &str, offset: usize| {
            let data = file.section_by_name(section)?.data().ok()?;
            let bytes = data.get(offset..offset + 4)?;
            Some(u32::from_le_bytes(bytes.try_into().ok()?))
        };
        let (Some(stack_pointer), Some(reset_vector)) =
            (word(".vector_table", 0), word(".vector_table", 4))
        else {
            return Err(not_an_image("it has no vector table".to_owned()));
        };
        let heap_symbols = file
            .symbols()
            .filter_map(|symbol| symbol.name().ok().map(str::to_owned))
            .filter(|name| name.contains("__rust_alloc") || name == "malloc")
            .collect();
        let ram_end_of_statics = sections
            .iter()
            .filter(|section| (0x2000_0000..RAM_END).contains(&section.address))
            .map(|section| section.address + section.size)
            .max()
            .unwrap_or(0x2000_0000);
        Ok(Self {
            stack_pointer,
            reset_vector,
            checksum_word: word(".boot_checksum", 0),
            ram_end_of_statics,
            heap_symbols,
            flash: flash_bytes(&file, &bytes),
            mark: file
                .symbol_by_name("IMAGE_MARK")
                .map(|symbol| symbol.address()),
            particle_bytes: file
                .symbols()
                .find(|symbol| symbol.name().is_ok_and(|name| name.contains(PARTICLES)))
                .map(|symbol| symbol.size()),
            symbols: file
                .symbols()
                .filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.address())))
                .collect(),
            sections,
        })
    }

    /// The bytes that go into the flash, from the vector table on; gaps are erased (0xff).
    #[must_use]
    pub fn flash(&self) -> &[u8] {
        &self.flash
    }

    /// The bytes to flash for a layout, with two values computed from the finished image:
    /// the mark by which the image checks itself, and the checksum of the vectors that
    /// AMiRo's boot loader requires, so that an image flashed by a probe starts too.
    ///
    /// The word is the two's complement of the sum of the first seven vectors: all
    /// eight words then sum to zero. The mark is the image's length and the CRC over all
    /// of it with the mark's own eight bytes erased.
    #[must_use]
    pub fn flashable(&self, layout: Layout) -> Vec<u8> {
        let mut flash = self.flash.clone();
        if layout == Layout::Amiro {
            let sum = words(&flash)
                .take(CHECKED_VECTORS)
                .fold(0_u32, u32::wrapping_add);
            put(
                &mut flash,
                CHECKSUM_OFFSET,
                &sum.wrapping_neg().to_le_bytes(),
            );
        }
        if let Some(mark) = self.mark {
            let offset = mark - layout.start();
            put(&mut flash, offset, &[0xff; 8]);
            let length = (flash.len() as u32).to_le_bytes();
            let checksum = CRC.checksum(&flash).to_le_bytes();
            put(&mut flash, offset, &[length, checksum].concat());
        }
        flash
    }

    /// Address of the first symbol of the image, by its mangled name, that is `wanted`.
    pub fn address_of(&self, wanted: impl Fn(&str) -> bool) -> Option<u64> {
        self.symbols
            .iter()
            .find(|(name, _)| wanted(name))
            .map(|(_, address)| *address)
    }

    /// Number of particles for which the image has room, by its symbols.
    #[must_use]
    pub fn capacity(&self) -> Option<usize> {
        let bytes = usize::try_from(self.particle_bytes?).ok()?;
        // What is in the set beside its particles takes the same room on every machine.
        let empty = size_of::<ParticleSet<0>>();
        let particle = size_of::<ParticleSet<1000>>().checked_sub(empty)? / 1000;
        Some(bytes.checked_sub(empty)? / particle)
    }

    fn section(&self, name: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.name == name)
    }

    fn size(&self, names: &[&str]) -> u64 {
        names
            .iter()
            .filter_map(|name| self.section(name))
            .map(|section| section.size)
            .sum()
    }

    /// Bytes of RAM between the statics and the top of the stack.
    #[must_use]
    pub fn stack_room(&self) -> u64 {
        u64::from(self.stack_pointer).saturating_sub(self.ram_end_of_statics)
    }

    /// Everything that is wrong with the image for a layout; empty when nothing is.
    #[must_use]
    pub fn problems(&self, layout: Layout) -> Vec<String> {
        let mut problems = Vec::new();
        let mut check = |holds: bool, problem: String| {
            if !holds {
                problems.push(problem);
            }
        };
        let address = |name: &str| self.section(name).map(|section| section.address);
        check(
            address(".vector_table") == Some(layout.start()),
            format!("the vector table is not at {:#010x}", layout.start()),
        );
        let vectors = self.size(&[".vector_table"]);
        check(
            vectors == VECTORS_SIZE,
            format!("the vector table has {vectors:#x} bytes, not {VECTORS_SIZE:#x}"),
        );
        check(
            address(".text") == Some(layout.text_start()),
            format!("the code does not begin at {:#010x}", layout.text_start()),
        );
        let text = self.size(&[".text"]);
        check(
            text > LEAST_TEXT,
            format!("only {text} bytes of code: was the linker script lost?"),
        );
        check(
            u64::from(self.stack_pointer) == RAM_END,
            format!("the stack begins at {:#010x}", self.stack_pointer),
        );
        let reset = u64::from(self.reset_vector);
        check(
            reset % 2 == 1 && (layout.text_start()..layout.text_start() + text).contains(&reset),
            format!("the reset vector {reset:#010x} does not point into the code"),
        );
        let flash = layout.start()..layout.start() + self.flash.len() as u64;
        check(
            self.mark.is_some_and(|mark| flash.contains(&mark)),
            "there is no place for the mark of a whole image".to_owned(),
        );
        check(
            self.heap_symbols.is_empty(),
            format!("there is a heap: {:?}", self.heap_symbols),
        );
        if layout == Layout::Amiro {
            problems.extend(self.boot_loader_problems(layout));
        }
        problems
    }

    /// What AMiRo's boot loader requires and the image lacks.
    fn boot_loader_problems(&self, layout: Layout) -> Vec<String> {
        let mut problems = Vec::new();
        let address = self
            .section(".boot_checksum")
            .map(|section| section.address);
        if address != Some(layout.start() + CHECKSUM_OFFSET)
            || self.size(&[".boot_checksum"]) != 4
            || self.checksum_word != Some(CHECKSUM_PLACEHOLDER)
        {
            problems.push("the word for the boot loader's checksum is not in its place".to_owned());
        }
        let gap = layout.start() + VECTORS_SIZE..layout.text_start();
        let sections = self.sections.iter().filter(|section| {
            section.name != ".boot_checksum"
                && section.address < gap.end
                && section.address + section.size > gap.start
        });
        problems.extend(
            sections.map(|section| format!("{} lies where the boot loader writes", section.name)),
        );
        problems
    }
}

/// Overwrites bytes from an offset on; what lies beyond the image is left out.
fn put(flash: &mut [u8], offset: u64, bytes: &[u8]) {
    let places = flash.iter_mut().skip(offset as usize);
    for (place, byte) in places.zip(bytes) {
        *place = *byte;
    }
}

/// The image's little-endian words.
fn words(flash: &[u8]) -> impl Iterator<Item = u32> {
    flash
        .as_chunks()
        .0
        .iter()
        .map(|word| u32::from_le_bytes(*word))
}

/// Every loaded segment at its place in the flash.
fn flash_bytes(file: &ElfFile32<'_>, bytes: &[u8]) -> Vec<u8> {
    let endian = file.endian();
    let mut segments: Vec<(u64, &[u8])> = file
        .elf_program_headers()
        .iter()
        .filter_map(|header| {
            Some((
                u64::from(header.p_paddr(endian)),
                header.data(endian, bytes).ok()?,
            ))
        })
        .filter(|(address, data)| !data.is_empty() && (FLASH_START..FLASH_END).contains(address))
        .collect();
    segments.sort_unstable_by_key(|&(address, _)| address);
    let Some(&(start, _)) = segments.first() else {
        return Vec::new();
    };
    let mut flash = Vec::new();
    for (address, data) in segments {
        flash.resize((address - start) as usize, 0xff);
        flash.extend_from_slice(data);
    }
    flash
}

impl fmt::Display for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.size(&[".vector_table", ".boot_checksum", ".text", ".rodata"]);
        let data = self.size(&[".data"]);
        let bss = self.size(&[".bss", ".uninit"]);
        write!(
            f,
            "text {text}, data {data}, bss {bss}, stack head-room {} bytes",
            self.stack_room()
        )
    }
}
