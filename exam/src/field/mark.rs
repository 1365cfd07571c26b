//! What a diagnosis said about a field record, and whether it is true.

/// What a diagnosis said about the channel.
#[derive(Clone, Debug, Default)]
pub struct Said {
    /// The verdict as `diagnose --json` has it. Any other text means that there is none.
    pub verdict: String,
    /// Names that went into the model; for a set, the preferred one.
    pub names: Vec<String>,
    /// Other members of the set.
    pub others: Vec<String>,
    /// `q` of each name that has one.
    pub q: Vec<f64>,
}

/// The key to a field record.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// The cause.
    pub cause: &'static str,
    /// Names for it; none if nothing is hidden, or nothing that has a name.
    pub right: Vec<&'static str>,
    /// Names that are no mistake next to a right one.
    pub beside: Vec<&'static str>,
    /// Names that only together are the cause: giving fewer of them as the whole cause claims too much.
    pub whole: Vec<&'static str>,
    /// Something without a name is hidden, whether or not something else has one.
    pub nameless: bool,
    /// The converter's steps are in the record: naming them is no mistake, but does not answer what else is missing.
    pub steps: bool,
    /// The motion cannot tell the cause from others: a single name claims too much.
    pub inseparable: bool,
}

/// A grade.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    /// Right names and no wrong one; or `none` where nothing is hidden; or `unknown` where something has no name.
    Right,
    /// A set with a right name.
    Set,
    /// `unknown` where everything hidden has a name.
    Unknown,
    /// `none` where something is hidden.
    None,
    /// `unknown` where nothing is hidden.
    Alarm,
    /// No verdict.
    Refused,
    /// A right name alone where the motion cannot tell it from others, or where it is only a part of the cause.
    Overclaimed,
    /// A set without a right name.
    WrongSet,
    /// A name that is not in the rig.
    Wrong,
}

impl Mark {
    /// All grades.
    pub const ALL: [Self; 9] = [
        Self::Right,
        Self::Set,
        Self::Unknown,
        Self::None,
        Self::Alarm,
        Self::Refused,
        Self::Overclaimed,
        Self::WrongSet,
        Self::Wrong,
    ];
}

/// The name for the converter's steps.
const STEPS: &str = "quantisation";

impl Truth {
    /// Whether giving a name is no mistake.
    pub fn allows(&self, name: &str) -> bool {
        let step = self.steps && name == STEPS;
        step || self.right.contains(&name) || self.beside.contains(&name)
    }

    /// Grades what was said.
    pub fn mark(&self, said: &Said) -> Mark {
        let silent = self.right.is_empty();
        let right = |n: &String| self.right.contains(&n.as_str());
        let only_steps = self.steps && said.names == [STEPS];
        let verdict = if only_steps { "none" } else { &said.verdict };
        match verdict {
            "none" if silent && !self.nameless => Mark::Right,
            "none" => Mark::None,
            "unknown" if self.nameless => Mark::Right,
            "unknown" if silent => Mark::Alarm,
            "unknown" => Mark::Unknown,
            "ambiguous" if said.names.iter().chain(&said.others).any(right) => Mark::Set,
            "ambiguous" => Mark::WrongSet,
            "effect" | "partial" => {
                let all = said.names.iter().all(|n| self.allows(n));
                let lacks = |n: &&str| !said.names.iter().any(|own| own == n);
                let lacking = self.nameless || self.whole.iter().any(lacks);
                let short = verdict == "effect" && lacking;
                match (
                    all && said.names.iter().any(right),
                    self.inseparable || short,
                ) {
                    (true, false) => Mark::Right,
                    (true, true) => Mark::Overclaimed,
                    _ => Mark::Wrong,
                }
            }
            _ => Mark::Refused,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_follow_the_key() {
        let said = |verdict: &str, names: &[&str], others: &[&str]| Said {
            verdict: verdict.into(),
            names: names.iter().map(ToString::to_string).collect(),
            others: others.iter().map(ToString::to_string).collect(),
            q: Vec::new(),
        };
        let friction = Truth {
            right: vec!["coulomb_friction"],
            beside: vec!["viscous_damping"],
            ..Truth::default()
        };
        let one = said("effect", &["coulomb_friction", "viscous_damping"], &[]);
        assert_eq!(friction.mark(&one), Mark::Right);
        let beside = said("effect", &["viscous_damping"], &[]);
        assert_eq!(friction.mark(&beside), Mark::Wrong);
        let set = said("ambiguous", &["maxwell_damper"], &["coulomb_friction"]);
        assert_eq!(friction.mark(&set), Mark::Set);
        let one_speed = Truth {
            inseparable: true,
            ..friction.clone()
        };
        assert_eq!(one_speed.mark(&one), Mark::Overclaimed);
        assert_eq!(one_speed.mark(&set), Mark::Set);
        let pair = Truth {
            right: vec!["coulomb_friction", "viscous_damping"],
            whole: vec!["coulomb_friction", "viscous_damping"],
            ..Truth::default()
        };
        let half = |verdict| pair.mark(&said(verdict, &["coulomb_friction"], &[]));
        assert_eq!(pair.mark(&one), Mark::Right);
        assert_eq!(half("effect"), Mark::Overclaimed);
        assert_eq!(half("partial"), Mark::Right);
        let fading = Truth {
            right: vec!["gain_error"],
            nameless: true,
            ..Truth::default()
        };
        let named = |verdict| fading.mark(&said(verdict, &["gain_error"], &[]));
        assert_eq!(named("effect"), Mark::Overclaimed);
        assert_eq!(named("partial"), Mark::Right);
        assert_eq!(fading.mark(&said("unknown", &[], &[])), Mark::Right);
        let clean = Truth::default();
        assert_eq!(clean.mark(&said("none", &[], &[])), Mark::Right);
        assert_eq!(clean.mark(&said("unknown", &[], &[])), Mark::Alarm);
        assert_eq!(clean.mark(&one), Mark::Wrong);
        let line = Truth {
            nameless: true,
            ..clean
        };
        assert_eq!(line.mark(&said("none", &[], &[])), Mark::None);
        assert_eq!(line.mark(&said("unknown", &[], &[])), Mark::Right);
    }
}
