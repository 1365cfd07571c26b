//! In place of [`post`](super) where the loop is built without the feature `watch`: nothing is seen, nothing is asked for, and the
//! compiler leaves both out.

use super::orders::{Alarm, AxisOrders, Orders};
use super::tap::Block;

/// Watches nothing.
#[derive(Clone, Debug)]
pub(crate) struct Post<const N: usize>;

impl<const N: usize> Post<N> {
    pub(crate) const fn new(_: u16) -> Self {
        Self
    }

    pub(crate) fn rest(&mut self) {}

    pub(crate) fn watch(&mut self) {}

    #[inline]
    pub(crate) fn is_on(&self) -> bool {
        false
    }

    #[inline]
    pub(crate) fn add(&mut self, _: &[f32; N], _: &[f32; N], _: &[f32; N]) -> bool {
        false
    }

    pub(crate) fn next(&mut self) -> Option<[Block; N]> {
        None
    }

    pub(crate) fn answer(&mut self, _: Orders<N>) {}

    #[inline]
    pub(crate) fn axis(&self, _: usize) -> AxisOrders {
        AxisOrders::NONE
    }

    pub(crate) fn alarm(&self) -> Option<Alarm> {
        None
    }

    #[inline]
    pub(crate) fn flags(&self) -> u32 {
        0
    }
}
