//! The image as it is flashed.

use object::read::elf::{ElfFile32, ElfSymbol32};
use object::{Object, ObjectSymbol, SymbolKind};
use rigless::image::Image;
use rigless::symbols::Symbols;
use std::ops::Range;
use std::path::Path;

/// An ELF file, its symbols and its sizes.
#[derive(Debug)]
pub struct Firmware {
    /// What the emulator places in memory, the image first.
    pub images: Vec<Image>,
    symbols: Symbols,
}

impl Firmware {
    /// Reads `path`.
    ///
    /// # Errors
    /// A sentence: the file cannot be run.
    pub fn read(path: &Path) -> Result<Self, String> {
        let image = Image::read(path, None).map_err(|e| e.to_string())?;
        // A function's symbol has the Thumb bit.
        let symbols = Symbols::read(image.bytes(), |address| address & !1)
            .map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self {
            images: vec![image],
            symbols,
        })
    }

    /// With `bytes` in the flash at `address`, left there before the last power-down.
    ///
    /// # Errors
    /// A sentence: they cannot be placed.
    pub fn with_flash(mut self, address: u64, bytes: Vec<u8>) -> Result<Self, String> {
        let left = Image::new(Path::new("flash"), bytes, Some(address));
        self.images.push(left.map_err(|e| e.to_string())?);
        Ok(self)
    }

    /// The address of a symbol.
    ///
    /// # Errors
    /// A sentence: there is none of this name.
    pub fn symbol(&self, name: &str) -> Result<u64, String> {
        self.symbols.get(name).map_err(|e| e.to_string())
    }

    /// Address range of the one variable whose mangled name contains `part`; mangling puts each word's length before it.
    ///
    /// # Errors
    /// A sentence: there is none, or more than one.
    pub fn variable(&self, part: &str) -> Result<Range<u64>, String> {
        let bytes = self.images.first().map_or(&[][..], Image::bytes);
        let file: ElfFile32<'_> = ElfFile32::parse(bytes).map_err(|e| e.to_string())?;
        let named = |symbol: &ElfSymbol32<'_, '_>| {
            let name = symbol.name().unwrap_or_default();
            symbol.kind() == SymbolKind::Data && symbol.size() > 0 && name.contains(part)
        };
        let mut found = file.symbols().filter(named);
        match (found.next(), found.next()) {
            (Some(one), None) => Ok(one.address()..one.address() + one.size()),
            (None, _) => Err(format!("the image has no variable with {part} in its name")),
            (Some(_), Some(_)) => Err(format!(
                "the image has several variables with {part} in their names"
            )),
        }
    }

    /// Where in the flash it is stored.
    pub fn stored(&self) -> Vec<Range<u64>> {
        let stored = self.images.iter().take(1).flat_map(Image::segments);
        stored
            .map(|(at, bytes)| at..at + bytes.len() as u64)
            .collect()
    }

    /// Size of its variables, without the stack, bytes.
    ///
    /// # Errors
    /// A sentence: the image lacks the symbols of its start-up code.
    pub fn ram_bytes(&self) -> Result<u64, String> {
        Ok(self.symbol("__ebss")? - self.symbol("__sdata")?)
    }

    /// Size of the image in flash, bytes: everything that is stored.
    pub fn flash_bytes(&self) -> u64 {
        self.stored()
            .iter()
            .map(|range| range.end - range.start)
            .sum()
    }
}
