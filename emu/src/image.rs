//! The image as it is flashed.

use rigless::image::Image;
use rigless::symbols::Symbols;
use std::path::Path;

/// An ELF file, its symbols and its sizes.
#[derive(Debug)]
pub struct Firmware {
    /// What the emulator places in memory.
    pub images: [Image; 1],
    symbols: Symbols,
}

impl Firmware {
    /// Reads `path`.
    ///
    /// # Errors
    /// A sentence: the file is none that can be run.
    pub fn read(path: &Path) -> Result<Self, String> {
        let image = Image::read(path, None).map_err(|e| e.to_string())?;
        // A function's symbol has the Thumb bit.
        let symbols = Symbols::read(image.bytes(), |address| address & !1)
            .map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self {
            images: [image],
            symbols,
        })
    }

    /// The address of a symbol.
    ///
    /// # Errors
    /// A sentence: there is none of this name.
    pub fn symbol(&self, name: &str) -> Result<u64, String> {
        self.symbols.get(name).map_err(|e| e.to_string())
    }

    /// Bytes that the image takes in flash: everything that is stored.
    pub fn flash_bytes(&self) -> u64 {
        let stored = self.images.iter().flat_map(Image::segments);
        stored.map(|(_, bytes)| bytes.len() as u64).sum()
    }
}
