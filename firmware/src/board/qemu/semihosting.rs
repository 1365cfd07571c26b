//! Host files for an image that runs in QEMU, by ARM's semihosting calls.
//!
//! # Limitations
//! On hardware without a debugger the breakpoint is a fault: no flashed image contains any of this.

use core::arch::asm;
use core::ffi::CStr;

/// The PC has disappeared, or sent something unexpected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostGone;

/// A file of the host.
pub struct File(usize);

/// Access mode of a file: the numbers of C's `fopen` modes.
#[derive(Clone, Copy)]
#[repr(usize)]
pub enum Mode {
    /// `rb`.
    Read = 1,
    /// `wb`.
    Write = 5,
}

const SYS_OPEN: usize = 0x01;
const SYS_WRITE: usize = 0x05;
const SYS_READ: usize = 0x06;
const SYS_EXIT_EXTENDED: usize = 0x20;
const APPLICATION_EXIT: usize = 0x2_0026;

/// One semihosting call; `arguments` as listed in ARM's specification for `operation`.
fn call(operation: usize, arguments: &[usize]) -> usize {
    let result;
    // SAFETY: BKPT 0xAB is the semihosting trap on M-profile cores; the callers below pass blocks that outlive the call
    // and the lengths of their buffers.
    unsafe {
        asm!(
            "bkpt 0xAB",
            inlateout("r0") operation => result,
            in("r1") arguments.as_ptr(),
            options(nostack),
        );
    }
    result
}

impl File {
    /// Opens `path`.
    ///
    /// # Errors
    /// The host cannot open it.
    pub fn open(path: &CStr, mode: Mode) -> Result<Self, HostGone> {
        let handle = call(
            SYS_OPEN,
            &[path.as_ptr().addr(), mode as usize, path.to_bytes().len()],
        );
        if handle == usize::MAX {
            Err(HostGone)
        } else {
            Ok(Self(handle))
        }
    }

    /// Fills `buffer`.
    ///
    /// # Errors
    /// The file ended early.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<(), HostGone> {
        let mut rest = buffer;
        while !rest.is_empty() {
            // The call returns the number of bytes not read.
            let missing = call(SYS_READ, &[self.0, rest.as_mut_ptr().addr(), rest.len()]);
            let filled = rest.len().checked_sub(missing).filter(|&n| n > 0);
            rest = rest.get_mut(filled.ok_or(HostGone)?..).ok_or(HostGone)?;
        }
        Ok(())
    }

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// The host accepted less.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), HostGone> {
        match call(SYS_WRITE, &[self.0, bytes.as_ptr().addr(), bytes.len()]) {
            0 => Ok(()),
            _ => Err(HostGone),
        }
    }
}

/// Ends QEMU with an exit status.
pub fn exit(status: usize) -> ! {
    loop {
        call(SYS_EXIT_EXTENDED, &[APPLICATION_EXIT, status]);
    }
}
