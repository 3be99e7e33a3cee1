//! Many pieces of work on several threads, one thread each, so that their results depend on no other thread.

use std::ops::ControlFlow;
use std::sync::{
    atomic::{AtomicBool, AtomicUsize, Ordering},
    mpsc::{self, RecvTimeoutError},
};
use std::thread::Builder;
use std::time::Duration;

/// Time between two words while nothing is finished.
const INTERVAL: Duration = Duration::from_millis(100);

/// Something to tell.
pub(crate) enum Word<T> {
    /// Time goes by.
    Waiting,
    /// A part of a piece of work is finished.
    Part(T),
}

/// What a piece of work is given: where its parts go, and whether it should stop.
pub(crate) struct Desk<'a, T> {
    send: mpsc::Sender<T>,
    stop: &'a AtomicBool,
}

impl<T> Desk<'_, T> {
    /// Hands a part over; `false` if nobody wants it any more.
    pub(crate) fn put(&self, part: T) -> bool {
        self.send.send(part).is_ok() && !self.stops()
    }

    /// Whether the work should stop where it is.
    pub(crate) fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Does `count` pieces of work on `threads` threads, in their order. `tell` gets every part, and may stop all.
pub(crate) fn each<T: Send>(
    count: usize,
    threads: usize,
    work: impl Fn(usize, &Desk<T>) + Sync,
    tell: &mut dyn FnMut(Word<T>) -> ControlFlow<()>,
) {
    let (stop, next) = (AtomicBool::new(false), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        let (stop, next, work) = (&stop, &next, &work);
        let all = move |desk: &Desk<T>| {
            while !desk.stops() {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= count {
                    return;
                }
                work(number, desk);
            }
        };
        let desk = || Desk {
            send: send.clone(),
            stop,
        };
        let mut started = 0;
        for _ in 0..threads.clamp(1, count.max(1)) {
            let desk = desk();
            let thread = Builder::new().spawn_scoped(scope, move || all(&desk));
            // Where the system refuses a thread, those that there are do the work.
            started += usize::from(thread.is_ok());
        }
        if started == 0 {
            all(&desk());
        }
        drop(send);
        loop {
            let word = match receive.recv_timeout(INTERVAL) {
                Ok(part) => Word::Part(part),
                Err(RecvTimeoutError::Timeout) => Word::Waiting,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if tell(word).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_is_done_once_whatever_the_number_of_threads() {
        for threads in [0, 1, 3, 100] {
            let mut found = Vec::new();
            each(
                7,
                threads,
                |number, desk| {
                    desk.put(number);
                    desk.put(10 + number);
                },
                &mut |word| {
                    if let Word::Part(part) = word {
                        found.push(part);
                    }
                    ControlFlow::Continue(())
                },
            );
            found.sort_unstable();
            assert_eq!(found, [0, 1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 14, 15, 16]);
        }
    }

    #[test]
    fn what_is_not_begun_when_it_stops_is_left() {
        let mut found = 0;
        let work = |_, desk: &Desk<()>| {
            desk.put(());
            while !desk.stops() {
                std::thread::yield_now();
            }
        };
        each(50, 2, work, &mut |word| {
            if !matches!(word, Word::Part(())) {
                return ControlFlow::Continue(());
            }
            found += 1;
            ControlFlow::Break(())
        });
        assert!((1..=2).contains(&found), "{found}");
    }
}
