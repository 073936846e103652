//! Work on the threads of the pool that this is called in. What comes out is the same, to the bit, on any number of them: each item is
//! worked on by one thread, and results are put together in the order of the items.

use rayon::prelude::*;

/// Things, pairs or bodies, of which fewer than this are not worth sharing out.
const FEW: usize = 256;

/// Whether so many things are worth sharing out, and there is anybody to share with: from outside of the pool, the way into it costs more than
/// most of this work.
pub(crate) fn is_shared(things: usize) -> bool {
    things > FEW && rayon::current_thread_index().is_some() && rayon::current_num_threads() > 1
}

/// Does something with each item, that hold so many things between them.
pub(crate) fn for_each<T: Send>(items: &mut [T], things: usize, visit: impl Fn(&mut T) + Send + Sync) {
    if items.len() > 1 && is_shared(things) {
        items.par_iter_mut().for_each(visit);
    } else {
        items.iter_mut().for_each(visit);
    }
}

/// As [`for_each`], with room that is used again from item to item.
pub(crate) fn for_each_with<T: Send, R>(
    items: &mut [T],
    things: usize,
    room: impl Fn() -> R + Send + Sync,
    visit: impl Fn(&mut R, &mut T) + Send + Sync,
) {
    if items.len() > 1 && is_shared(things) {
        items.par_iter_mut().for_each_init(room, visit);
    } else {
        let mut room = room();
        items.iter_mut().for_each(|item| visit(&mut room, item));
    }
}

/// Does two things at a time, if somebody is there for the second one.
pub(crate) fn join(one: impl FnOnce() + Send, other: impl FnOnce() + Send) {
    rayon::join(one, other);
}

/// What each item gives.
pub fn map<T: Send, R: Send>(items: Vec<T>, things: usize, of: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
    if items.len() > 1 && is_shared(things) {
        items.into_par_iter().map(of).collect()
    } else {
        items.into_iter().map(of).collect()
    }
}

/// As [`map`], with room that is used again for the next items of a thread.
pub(crate) fn map_with<T: Send, R: Send, O>(
    items: Vec<T>,
    things: usize,
    room: impl Fn() -> O + Send + Sync,
    of: impl Fn(&mut O, T) -> R + Send + Sync,
) -> Vec<R> {
    if items.len() > 1 && is_shared(things) {
        items.into_par_iter().map_init(room, of).collect()
    } else {
        let mut room = room();
        items.into_iter().map(|item| of(&mut room, item)).collect()
    }
}

/// A list of so many things, each by its number.
pub(crate) fn list<R: Send>(count: usize, of: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    if is_shared(count) {
        (0..count).into_par_iter().with_min_len(FEW).map(of).collect()
    } else {
        (0..count).map(of).collect()
    }
}
