//! Groups of bodies that pass through each other.

use frangible_math::check::{Check, Checked, require};
use serde::{Deserialize, Serialize};

/// Bodies that collide with the same others: a number that [`CollisionClasses`] knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CollisionClass(u32);

/// Which bodies pass through which, by the groups that they are in. Bodies of the first class are
/// in no group and collide with all.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct CollisionClasses {
    /// Names of groups, in the order in which they were first heard of.
    groups: Vec<String>,
    /// Of each class but the first.
    classes: Vec<Membership>,
    /// For each two classes, the later one's row after another, whether their bodies collide.
    collide: Vec<bool>,
}

/// The groups of a body, and those that it passes through; ascending numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Membership {
    groups: Vec<u32>,
    passes_through: Vec<u32>,
}

impl Check for CollisionClasses {
    fn check(&self) -> Checked {
        let count = self.classes.len();
        require(self.collide.len() == count * (count + 1) / 2, "a rule for each two classes")?;
        let mut of_classes =
            self.classes.iter().flat_map(|class| class.groups.iter().chain(&class.passes_through));
        let is_known = |&group: &u32| (group as usize) < self.groups.len();
        require(of_classes.all(is_known), "groups that have names")
    }
}

impl CollisionClasses {
    /// True if bodies may be of a class.
    pub(crate) fn holds(&self, class: CollisionClass) -> bool {
        class.0 as usize <= self.classes.len()
    }

    /// The class of bodies in some groups that pass through those in others.
    pub fn class_of(&mut self, groups: &[String], passes_through: &[String]) -> CollisionClass {
        let own = Membership {
            groups: self.numbers_of(groups),
            passes_through: self.numbers_of(passes_through),
        };
        if own == Membership::default() {
            return CollisionClass::default();
        }
        if let Some(known) = self.classes.iter().position(|class| *class == own) {
            return CollisionClass(known as u32 + 1);
        }
        self.classes.push(own.clone());
        let collides = |other: &Membership| !own.passes(other) && !other.passes(&own);
        self.collide.extend(self.classes.iter().map(collides));
        CollisionClass(self.classes.len() as u32)
    }

    /// True if a class was made with a group of that name.
    pub fn knows(&self, group: &str) -> bool {
        self.groups.iter().any(|name| name == group)
    }

    /// True if bodies of two classes collide.
    #[inline]
    pub fn collide(&self, a: CollisionClass, b: CollisionClass) -> bool {
        let (low, high) = (a.0.min(b.0) as usize, a.0.max(b.0) as usize);
        low == 0 || self.collide[high * (high - 1) / 2 + low - 1]
    }

    /// True if all bodies collide.
    #[inline]
    pub fn is_trivial(&self) -> bool {
        self.classes.is_empty()
    }

    /// Numbers of groups, ascending; new ones for names that are new.
    fn numbers_of(&mut self, names: &[String]) -> Vec<u32> {
        let mut numbers: Vec<u32> = Vec::new();
        for name in names {
            let known = self.groups.iter().position(|group| group == name);
            let number = known.unwrap_or_else(|| {
                self.groups.push(name.clone());
                self.groups.len() - 1
            });
            numbers.push(number as u32);
        }
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }
}

impl Membership {
    /// True if this passes through the other.
    fn passes(&self, other: &Self) -> bool {
        self.passes_through.iter().any(|group| other.groups.binary_search(group).is_ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| name.to_string()).collect()
    }

    #[test]
    fn groups_pass_both_ways() {
        let mut classes = CollisionClasses::default();
        let plain = classes.class_of(&[], &[]);
        assert!(classes.is_trivial() && classes.collide(plain, plain));
        let ghost = classes.class_of(&names(&["ghosts"]), &names(&["ghosts", "walls"]));
        let wall = classes.class_of(&names(&["walls"]), &[]);
        let ball = classes.class_of(&names(&["balls", "toys"]), &[]);
        assert_eq!(ball, classes.class_of(&names(&["toys", "balls", "toys"]), &[]));
        // Named for the first time after the group's members.
        let shy = classes.class_of(&[], &names(&["toys"]));
        let passing = [(ghost, ghost), (ghost, wall), (shy, ball)];
        let all = [plain, ghost, wall, ball, shy];
        for a in all {
            for b in all {
                let passes = passing.contains(&(a, b)) || passing.contains(&(b, a));
                assert_eq!(classes.collide(a, b), !passes, "{a:?} and {b:?}");
            }
        }
    }
}
