//! The 64 KiB of memory at the processor itself, which no DMA reaches: the queues between interrupt and tasks that carry
//! steps, and the rig watch. The start does not fill it, so each part is written before it is given away.

use crate::chip::stm32::tasks::report::Waiting;
use crate::station::{Judged, OrdersQueue, ReportQueue, Watches};
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use heapless::spsc::Queue;
use heapless::{Deque, Vec};

/// What lies there.
pub struct CoreCoupled {
    /// Steps, from the interrupt to the tasks.
    pub reports: ReportQueue,
    /// Steps that wait until they can be sent.
    pub waiting: Waiting,
    /// How far the rig watch is.
    pub judged: Judged,
    /// What it asks for.
    pub orders: OrdersQueue,
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
        addr_of_mut!((*all).waiting).write(Deque::new());
        addr_of_mut!((*all).judged).write(Judged::nothing());
        addr_of_mut!((*all).orders).write(Queue::new());
        addr_of_mut!((*all).watches).write(Vec::new());
        Some(&mut *all)
    }
}
