//! Values that several owners share, for `#[serde(with = "frangible_math::shared")]`: each is
//! written once, and shared again by the same owners when it is read, once its
//! [rules](crate::check) are kept.
//!
//! Works within [`scope`] only, on one thread.

use crate::check::Check;
use serde::de::{DeserializeOwned, Error as _, SeqAccess, Visitor};
use serde::ser::{Error as _, SerializeTuple};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// What has been written or read so far, by number.
#[derive(Default)]
struct Known {
    /// Numbers of the values, by type and address.
    written: BTreeMap<(TypeId, usize), u32>,
    /// None while a value is being read.
    read: Vec<Option<Arc<dyn Any + Send + Sync>>>,
}

thread_local! {
    static KNOWN: RefCell<Option<Known>> = const { RefCell::new(None) };
}

/// Runs `work`, in which all values are written, or read, that share others.
pub fn scope<T>(work: impl FnOnce() -> T) -> T {
    struct Outer(Option<Known>);
    impl Drop for Outer {
        fn drop(&mut self) {
            KNOWN.set(self.0.take());
        }
    }
    let _outer = Outer(KNOWN.replace(Some(Known::default())));
    work()
}

/// With the values of the scope; `None` outside of any.
fn with_known<T>(use_it: impl FnOnce(&mut Known) -> T) -> Option<T> {
    KNOWN.with_borrow_mut(|known| known.as_mut().map(use_it))
}

const NO_SCOPE: &str = "shared values outside of a scope";

/// Owners of shared values.
pub trait Sharing: Sized {
    /// Writes their numbers, and the values where they are new.
    ///
    /// # Errors
    /// As the serializer, or outside of a [`scope`].
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error>;

    /// Reads them back.
    ///
    /// # Errors
    /// As the deserializer, for a number that no value has, or outside of a [`scope`].
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
}

/// For serde.
///
/// # Errors
/// See [`Sharing::write`].
pub fn serialize<T: Sharing, S: Serializer>(owner: &T, serializer: S) -> Result<S::Ok, S::Error> {
    owner.write(serializer)
}

/// For serde.
///
/// # Errors
/// See [`Sharing::read`].
pub fn deserialize<'de, T: Sharing, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::read(deserializer)
}

/// Values that can be shared, written and read.
pub trait Value: Serialize + DeserializeOwned + Check + Any + Send + Sync {}

impl<T: Serialize + DeserializeOwned + Check + Any + Send + Sync> Value for T {}

impl<T: Value> Sharing for Arc<T> {
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Written(self).serialize(serializer)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Read::deserialize(deserializer).map(|read| read.0)
    }
}

impl<T: Value> Sharing for Option<Arc<T>> {
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.as_ref().map(Written).serialize(serializer)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Option::<Read<T>>::deserialize(deserializer)?.map(|read| read.0))
    }
}

impl<T: Value> Sharing for Vec<Arc<T>> {
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter().map(Written))
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Vec::<Read<T>>::deserialize(deserializer)?.into_iter().map(|read| read.0).collect())
    }
}

/// A number, and the value at its first owner.
struct Written<'a, T>(&'a Arc<T>);

impl<T: Value> Serialize for Written<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let key = (TypeId::of::<T>(), Arc::as_ptr(self.0) as usize);
        let (number, is_new) = with_known(|known| {
            let next = known.written.len() as u32;
            let number = *known.written.entry(key).or_insert(next);
            (number, number == next)
        })
        .ok_or_else(|| S::Error::custom(NO_SCOPE))?;
        let mut pair = serializer.serialize_tuple(2)?;
        pair.serialize_element(&number)?;
        pair.serialize_element(&is_new.then_some(self.0.as_ref()))?;
        pair.end()
    }
}

/// A shared value that was read.
struct Read<T>(Arc<T>);

impl<'de, T: Value> Deserialize<'de> for Read<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(2, ReadPair(PhantomData)).map(Self)
    }
}

struct ReadPair<T>(PhantomData<T>);

impl<'de, T: Value> Visitor<'de> for ReadPair<T> {
    type Value = Arc<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the number of a shared value, and the value at its first owner")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut pair: A) -> Result<Arc<T>, A::Error> {
        let missing = || A::Error::custom("a shared value is missing");
        let number: u32 = pair.next_element()?.ok_or_else(missing)?;
        let place = number as usize;
        // A value that holds others has its number before they have theirs.
        let known = with_known(|known| {
            let count = known.read.len();
            if place == count {
                known.read.push(None);
            }
            (place == count, known.read.get(place).cloned().flatten())
        });
        let (is_new, known) = known.ok_or_else(|| A::Error::custom(NO_SCOPE))?;
        match (pair.next_element::<Option<T>>()?.ok_or_else(missing)?, known) {
            (Some(value), _) if is_new => {
                value.check().map_err(A::Error::custom)?;
                let value = Arc::new(value);
                let kept: Arc<dyn Any + Send + Sync> = value.clone();
                with_known(|known| known.read[place] = Some(kept));
                Ok(value)
            }
            (None, Some(known)) => known.downcast().map_err(|_| missing()),
            _ => Err(missing()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Checked, require};

    #[derive(Serialize, Deserialize)]
    struct Leaf(u32);

    impl Check for Leaf {
        fn check(&self) -> Checked {
            require(self.0 < 10, "a digit")
        }
    }

    #[derive(Serialize, Deserialize)]
    struct Branch {
        #[serde(with = "crate::shared")]
        leaf: Arc<Leaf>,
    }

    impl Check for Branch {
        fn check(&self) -> Checked {
            Ok(())
        }
    }

    #[derive(Serialize, Deserialize)]
    struct Tree {
        #[serde(with = "crate::shared")]
        branches: Vec<Arc<Branch>>,
        #[serde(with = "crate::shared")]
        leaf: Option<Arc<Leaf>>,
    }

    fn tree() -> Tree {
        let leaf = Arc::new(Leaf(7));
        let branch = Arc::new(Branch { leaf: leaf.clone() });
        let other = Arc::new(Branch { leaf: leaf.clone() });
        Tree { branches: vec![branch.clone(), other, branch], leaf: Some(leaf) }
    }

    /// Two owners of one value own one again; equal values that were two stay two.
    #[test]
    fn owners_share_again_what_they_shared() {
        let text = scope(|| serde_json::to_string(&tree())).unwrap();
        assert_eq!(text.matches('7').count(), 1, "{text}");
        let read: Tree = scope(|| serde_json::from_str(&text)).unwrap();
        assert!(Arc::ptr_eq(&read.branches[0], &read.branches[2]));
        assert!(!Arc::ptr_eq(&read.branches[0], &read.branches[1]));
        let leaf = read.leaf.as_ref().unwrap();
        assert!(read.branches.iter().all(|branch| Arc::ptr_eq(&branch.leaf, leaf)));
        assert_eq!(leaf.0, 7);
        assert_eq!(scope(|| serde_json::to_string(&read)).unwrap(), text);
    }

    /// Numbers without a value, of another type or out of order are refused, and values that break
    /// their rules, and so is all outside of a scope.
    #[test]
    fn damaged_numbers_are_refused() {
        let read = |text: &str| scope(|| serde_json::from_str::<Tree>(text)).is_ok();
        assert!(read(r#"{"branches": [[0, {"leaf": [1, 7]}]], "leaf": [1, null]}"#));
        assert!(!read(r#"{"branches": [[0, {"leaf": [1, 11]}]], "leaf": [1, null]}"#));
        assert!(!read(r#"{"branches": [[0, {"leaf": [1, 7]}]], "leaf": [0, null]}"#));
        assert!(!read(r#"{"branches": [[0, {"leaf": [1, 7]}]], "leaf": [2, null]}"#));
        assert!(!read(r#"{"branches": [[0, {"leaf": [1, 7]}]], "leaf": [5, 7]}"#));
        assert!(!read(r#"{"branches": [[0, {"leaf": [0, null]}]], "leaf": null}"#));
        assert!(serde_json::to_string(&tree()).is_err());
    }
}
