//! A time that may differ between actuators.

use super::rig::PerActuator;
use crate::refusal::{Refusal, accept};
use core::fmt;

/// A time of the actuators, ms of laboratory time: one for all, or one for each from the ground up.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ActuatorTimes(
    #[cfg_attr(feature = "schema", schemars(with = "super::OneOrEach"))] PerActuator,
);

impl ActuatorTimes {
    /// One for each actuator. `None` if the list is empty or too long.
    pub fn each(ms: &[f64]) -> Option<Self> {
        let list = PerActuator::from_slice(ms).ok()?;
        (!list.is_empty()).then_some(Self(list))
    }

    /// The time of an actuator, counted from 0, ms.
    pub fn at(&self, actuator: usize) -> f64 {
        let one = match *self.0 {
            [one] => Some(one),
            ref each => each.get(actuator).copied(),
        };
        one.unwrap_or(f64::NAN)
    }

    /// The longest, ms.
    pub fn longest(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }

    /// Checks how many there are, and each.
    pub(crate) fn check(
        &self,
        name: &'static str,
        actuators: usize,
        good: impl Fn(f64) -> bool,
        accepted: &'static str,
    ) -> Result<(), Refusal> {
        let count = self.0.len();
        accept(
            name,
            count as f64,
            count == 1 || count == actuators,
            "one value, or as many as storeys in the laboratory",
        )?;
        self.0
            .iter()
            .try_for_each(|&ms| accept(name, ms, good(ms), accepted))
    }
}

impl fmt::Display for ActuatorTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (j, ms) in self.0.iter().enumerate() {
            let apart = if j == 0 { "" } else { ", " };
            write!(f, "{apart}{ms}")?;
        }
        Ok(())
    }
}

impl From<f64> for ActuatorTimes {
    fn from(ms: f64) -> Self {
        Self(core::iter::once(ms).collect())
    }
}

#[cfg(feature = "serde")]
mod as_written {
    use super::{ActuatorTimes, PerActuator};
    use core::fmt;
    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::{Serialize, Serializer};

    /// People write one time as a number; the link always sends a list.
    impl Serialize for ActuatorTimes {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match *self.0 {
                [one] if serializer.is_human_readable() => serializer.serialize_f64(one),
                _ => self.0.serialize(serializer),
            }
        }
    }

    impl<'de> Deserialize<'de> for ActuatorTimes {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            if deserializer.is_human_readable() {
                deserializer.deserialize_any(Written)
            } else {
                PerActuator::deserialize(deserializer).map(Self)
            }
        }
    }

    struct Written;

    impl<'de> Visitor<'de> for Written {
        type Value = ActuatorTimes;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number, or a list with one number for each actuator")
        }

        fn visit_f64<E: Error>(self, ms: f64) -> Result<ActuatorTimes, E> {
            Ok(ms.into())
        }

        fn visit_i64<E: Error>(self, ms: i64) -> Result<ActuatorTimes, E> {
            Ok((ms as f64).into())
        }

        fn visit_u64<E: Error>(self, ms: u64) -> Result<ActuatorTimes, E> {
            Ok((ms as f64).into())
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<ActuatorTimes, A::Error> {
            let mut list = PerActuator::new();
            while let Some(ms) = seq.next_element()? {
                list.push(ms)
                    .map_err(|_| Error::custom("a longer list than a rig has actuators"))?;
            }
            Ok(ActuatorTimes(list))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Config;

    fn refused(change: impl Fn(&mut Config)) -> Option<(&'static str, f64)> {
        let mut config = Config::shear_frame([1e3; 4], [8e5; 4], [0.02; 4]);
        config.structure.physical_storeys = Some(3);
        change(&mut config);
        config.check().err().map(|e| (e.name, e.value))
    }

    #[test]
    fn one_stands_for_all_and_a_list_has_one_for_each_actuator() {
        let each = ActuatorTimes::each(&[4.0, 6.0, 9.0]).unwrap();
        assert_eq!([0, 1, 2].map(|j| each.at(j)), [4.0, 6.0, 9.0]);
        assert_eq!(ActuatorTimes::from(4.0).at(2), 4.0);
        assert_eq!(each.longest(), 9.0);
        assert_eq!(ActuatorTimes::each(&[]), None);
        assert_eq!(refused(|c| c.compensation.delay_ms = each.clone()), None);
    }

    #[test]
    fn a_list_of_another_length_and_any_value_of_it_that_cannot_be_is_refused() {
        let list = |ms: &[f64]| ActuatorTimes::each(ms).unwrap();
        let two = list(&[4.0, 6.0]);
        for (key, refusal) in [
            (
                "compensation.delay_ms",
                refused(|c| c.compensation.delay_ms = two.clone()),
            ),
            (
                "estimation.delay_ms",
                refused(|c| c.estimation.delay_ms = two.clone()),
            ),
            (
                "estimation.lag_ms",
                refused(|c| c.estimation.lag_ms = two.clone()),
            ),
        ] {
            assert_eq!(refusal, Some((key, 2.0)));
        }
        let last = |ms| refused(|c| c.compensation.delay_ms = list(&[4.0, 6.0, ms]));
        assert_eq!(last(-1.0), Some(("compensation.delay_ms", -1.0)));
        assert!(last(f64::NAN).is_some());
    }
}
