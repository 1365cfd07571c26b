//! What every external output converter does.

/// An output converter.
pub trait Output {
    /// LDAC falls: what stood in the input registers by then is shown.
    fn take_over(&mut self, at_ns: u64);

    /// What an output shows, V.
    fn volts(&self, output: usize) -> f64;

    /// Codes of the first output since this was last asked, with their times, ns.
    fn commands(&mut self) -> Vec<(u64, u16)>;

    /// From now on an output stays where it is.
    fn break_output(&mut self, output: usize);
}
