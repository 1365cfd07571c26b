//! Whether the actuators may move: the loop must say so in each step, and someone must have armed it since the last
//! fall. Neither suffices alone, so a single wrong bit cannot restore a permission that has fallen.

/// The intended state of the PERMIT line.
#[derive(Debug, Default)]
pub struct Permission {
    armed: bool,
    given: bool,
}

impl Permission {
    /// No permission.
    pub const fn none() -> Self {
        Self {
            armed: false,
            given: false,
        }
    }

    /// An order that requests it was carried out.
    pub fn arm(&mut self) {
        self.armed = true;
    }

    /// Whether it is given, from whether the loop's step permits motion. A permission that has fallen, or was not
    /// permitted in the step after the order, must be armed again.
    #[inline]
    pub fn of_step(&mut self, permits: bool) -> bool {
        let given = permits && self.armed;
        (self.armed, self.given) = (given, given);
        given
    }

    /// True if it was given in the last step.
    pub fn is_given(&self) -> bool {
        self.given
    }
}

#[cfg(test)]
mod tests {
    use super::Permission;

    #[test]
    fn a_permission_is_armed_and_permitted_and_what_has_fallen_is_armed_again() {
        let mut permission = Permission::none();
        assert!(!permission.of_step(true), "nobody armed it");
        permission.arm();
        assert!(permission.of_step(true) && permission.of_step(true));
        // A wrong bit in one step.
        assert!(!permission.of_step(false) && !permission.is_given());
        assert!(!permission.of_step(true) && !permission.of_step(true));
        permission.arm();
        assert!(permission.of_step(true) && permission.is_given());
        // Armed, and a fault in the next step: the order is spent.
        let mut permission = Permission::none();
        permission.arm();
        assert!(!permission.of_step(false) && !permission.of_step(true));
    }
}
