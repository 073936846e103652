//! Work on the threads of the pool that this is called in. What comes out is the same, to the bit, on any number of them: each item is
//! worked on by one thread, and results are put together in the order of the items.

use rayon::prelude::*;

/// Whether there is anybody to share with: from outside of the pool, the way into it costs more than most of this work.
fn has_others() -> bool {
    rayon::current_thread_index().is_some() && rayon::current_num_threads() > 1
}

/// Does something with each item.
pub(crate) fn for_each<T: Send>(items: &mut [T], visit: impl Fn(&mut T) + Send + Sync) {
    if items.len() > 1 && has_others() {
        items.par_iter_mut().for_each(visit);
    } else {
        items.iter_mut().for_each(visit);
    }
}

/// What each item gives.
pub(crate) fn map<T: Send, R: Send>(items: Vec<T>, of: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
    if items.len() > 1 && has_others() {
        items.into_par_iter().map(of).collect()
    } else {
        items.into_iter().map(of).collect()
    }
}

/// A list of so many things, each by its number.
pub(crate) fn list<R: Send>(count: usize, of: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    // Things for which a thread is worth while.
    const FEW: usize = 512;
    if count > FEW && has_others() {
        (0..count).into_par_iter().with_min_len(FEW).map(of).collect()
    } else {
        (0..count).map(of).collect()
    }
}
