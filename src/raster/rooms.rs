//! Working memory for each thread, used again from task to task.

use std::sync::{Mutex, PoisonError};

/// As many rooms as there are threads.
pub(super) struct Rooms<T>(Vec<Mutex<T>>);

impl<T> Rooms<T> {
    /// A room for each thread that tasks may run on.
    pub(super) fn new(room: impl Fn() -> T) -> Self {
        Self((0..rayon::current_num_threads()).map(|_| Mutex::new(room())).collect())
    }

    /// Runs a task, which starts no others, in its thread's room. Nothing that a task leaves in the room may matter to the next.
    pub(super) fn with<R>(&self, task: impl FnOnce(&mut T) -> R) -> R {
        let number = rayon::current_thread_index().unwrap_or(0) % self.0.len();
        task(&mut self.0[number].lock().unwrap_or_else(PoisonError::into_inner))
    }
}
