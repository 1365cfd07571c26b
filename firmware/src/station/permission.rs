//! Whether the actuators may move: the loop says so in each step, and somebody armed it since it last fell. Neither is enough alone, so
//! that one wrong bit cannot have a permission that has fallen rise by itself.

/// The PERMIT line, as it is to be.
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

    /// An order that asks for it was carried out.
    pub fn arm(&mut self) {
        self.armed = true;
    }

    /// Whether it is given, where the loop's step says that motion is permitted or not. What has fallen, or was not permitted in the
    /// step behind the order, has to be armed again.
    #[inline]
    pub fn of_step(&mut self, permits: bool) -> bool {
        let given = permits && self.armed;
        (self.armed, self.given) = (given, given);
        given
    }

    /// Whether it was given in the last step.
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
