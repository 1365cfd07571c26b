//! The 64 KiB of core-coupled memory, out of reach of any DMA: the step queues between interrupt and tasks, and the rig
//! watch. The start does not initialise it, so each part is written before it is handed out.

use crate::chip::stm32::tasks::report::Waiting;
use crate::station::{Judged, OrdersQueue, ReportQueue, Watches};
use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use heapless::spsc::Queue;
use heapless::{Deque, Vec};

/// The contents.
pub struct CoreCoupled {
    /// Steps, from the interrupt to the tasks.
    pub reports: ReportQueue,
    /// Steps waiting to be sent.
    pub waiting: Waiting,
    /// Progress of the rig watch.
    pub judged: Judged,
    /// Requests of the rig watch.
    pub orders: OrdersQueue,
    /// The rig watch of each actuator.
    pub watches: Watches,
}

#[unsafe(link_section = ".ccm")]
static mut MEMORY: MaybeUninit<CoreCoupled> = MaybeUninit::uninit();

static CLAIMED: AtomicBool = AtomicBool::new(false);

/// Hands out the memory, with empty contents; once.
pub fn claim() -> Option<&'static mut CoreCoupled> {
    if CLAIMED.swap(true, Relaxed) {
        return None;
    }
    let all = addr_of_mut!(MEMORY).cast::<CoreCoupled>();
    // SAFETY: this code runs only once; every part is written, in its place, before it is read.
    unsafe {
        addr_of_mut!((*all).reports).write(Queue::new());
        addr_of_mut!((*all).waiting).write(Deque::new());
        addr_of_mut!((*all).judged).write(Judged::nothing());
        addr_of_mut!((*all).orders).write(Queue::new());
        addr_of_mut!((*all).watches).write(Vec::new());
        Some(&mut *all)
    }
}
