//! The 64 KiB of memory at the processor itself, which no DMA reaches: the queues between interrupt and tasks that carry
//! steps, and the rig watch. The start does not fill it, so each part is written before it is given away.

use crate::station::{AnswerQueue, Report, ShownQueue, Watches};
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use heapless::Vec;
use heapless::spsc::Queue;

/// What lies there.
pub struct CoreCoupled {
    /// Steps, from the interrupt to the task that sends them.
    pub reports: Queue<Report, 256>,
    /// Steps, from the interrupt to the rig watch.
    pub shown: ShownQueue,
    /// Its answers.
    pub answers: AnswerQueue,
    /// The rig watch of each actuator.
    pub watches: Watches,
}

#[unsafe(link_section = ".ccm")]
static mut MEMORY: MaybeUninit<CoreCoupled> = MaybeUninit::uninit();

static CLAIMED: AtomicBool = AtomicBool::new(false);

/// Gives the memory away, filled with nothing; once.
pub fn claim() -> Option<&'static mut CoreCoupled> {
    if CLAIMED.swap(true, Relaxed) {
        return None;
    }
    let all = addr_of_mut!(MEMORY).cast::<CoreCoupled>();
    // SAFETY: nobody has come here before, and nobody will; every part is written, in its place, before it is read.
    unsafe {
        addr_of_mut!((*all).reports).write(Queue::new());
        addr_of_mut!((*all).shown).write(Queue::new());
        addr_of_mut!((*all).answers).write(Queue::new());
        addr_of_mut!((*all).watches).write(Vec::new());
        Some(&mut *all)
    }
}
