//! What of a displacement is no linear answer to its command.

use schemars::JsonSchema;
use serde::Serialize;

/// How the command allows distortion to be told from noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Excitation {
    /// A sine whose frequency moves.
    Sweep,
    /// Periods that repeat, of odd lines alone.
    OddMultisine,
}

/// Distortion and noise, rms, each at a frequency of the command.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Distortion {
    /// What the command is.
    pub excitation: Excitation,
    /// One after the other over frequency, ascending.
    pub lines: Vec<DistortionLine>,
}

/// Distortion at one frequency of the command; all rms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DistortionLine {
    /// Frequency of the command, Hz; of a multisine that of the line.
    pub hz: f64,
    /// The linear answer, mm.
    pub linear_mm: f64,
    /// Orders 2 and 4, mm; null: a line of odd order.
    pub even_mm: Option<f64>,
    /// Orders 3 and 5, mm; null: a line of even order.
    pub odd_mm: Option<f64>,
    /// What noise alone would show as distortion, mm.
    pub noise_mm: f64,
}

impl Distortion {
    /// Root of the mean square of the even orders, of the odd ones, of noise and of the linear answer, mm.
    pub fn overall_mm(&self) -> [f64; 4] {
        let rms = |of: &dyn Fn(&DistortionLine) -> Option<f64>| {
            let squares: Vec<f64> = self.lines.iter().filter_map(of).map(|x| x * x).collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        [
            rms(&|l| l.even_mm),
            rms(&|l| l.odd_mm),
            rms(&|l| Some(l.noise_mm)),
            rms(&|l| Some(l.linear_mm).filter(|x| *x > 0.0)),
        ]
    }

    /// How many times the noise even and odd orders are, in the median line.
    pub fn over_noise(&self) -> [f64; 2] {
        let median = |of: &dyn Fn(&DistortionLine) -> Option<f64>| {
            let ratio = |l: &DistortionLine| Some(of(l)? / l.noise_mm.max(f64::MIN_POSITIVE));
            let mut ratios: Vec<f64> = self.lines.iter().filter_map(ratio).collect();
            ratios.sort_by(f64::total_cmp);
            ratios.get(ratios.len() / 2).copied().unwrap_or(0.0)
        };
        [median(&|l| l.even_mm), median(&|l| l.odd_mm)]
    }
}
