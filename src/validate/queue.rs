//! Many jobs in parallel.

use std::ops::ControlFlow;
use std::sync::{
    Condvar, Mutex, MutexGuard,
    atomic::{AtomicBool, Ordering},
    mpsc,
};
use std::thread::Builder;
use std::time::{Duration, Instant};

use super::{Case, Findings, Method, Stopped};
use crate::{filling::Filling, memory, step::memory::need};

/// Time between two progress reports of a job.
const INTERVAL: Duration = Duration::from_millis(100);

/// A case with a method at a resolution.
#[derive(Debug, Clone, Copy)]
pub struct Job {
    /// The case.
    pub case: &'static Case,
    /// The method.
    pub method: &'static Method,
    /// Particles over the characteristic length of the case.
    pub resolution: u32,
}

/// Result of a job.
#[derive(Debug)]
pub struct Outcome {
    /// The job.
    pub job: Job,
    /// Wall time \[s].
    pub seconds: f64,
    /// Its findings, or why it failed.
    pub result: Result<Findings, Stopped>,
}

/// Progress of the jobs.
pub enum Event<'a> {
    /// A job took a step.
    Step {
        /// The job.
        job: &'a Job,
        /// Completed fraction of all jobs, 0 to 1, by an estimate of their work.
        fraction: f64,
    },
    /// A job is finished.
    Done {
        /// Its number.
        number: usize,
        /// Outcomes of the finished jobs, in the order of the jobs.
        outcomes: &'a [Option<Outcome>],
    },
}

impl Job {
    /// Estimated work of the job: particles times steps of a weakly compressible method.
    fn work(&self) -> f64 {
        let Ok(scene) = self.case.scene(self.method, self.resolution) else {
            return 1.0;
        };
        let mut particles = 0.0;
        Filling::new(&scene).for_each(|_| particles += 1.0);
        particles * f64::from(scene.duration * self.case.sound_speed / scene.spacing)
    }

    /// The memory that it takes \[bytes]; none if it will be refused.
    fn memory(&self) -> f64 {
        let scene = self.case.scene(self.method, self.resolution).ok();
        let size = scene.and_then(|scene| Some((scene.checked_size().ok()?, scene)));
        let need = size.and_then(|(size, scene)| need(&scene, &size).ok());
        need.map_or(0.0, |need| need.most)
    }
}

/// Jobs that nobody does yet, and the memory that those which are done leave.
struct Queue {
    state: Mutex<State>,
    /// Told when a job is over.
    over: Condvar,
    /// Memory that each job takes \[bytes].
    needs: Vec<f64>,
}

struct State {
    /// The next one last.
    left: Vec<usize>,
    free: f64,
    running: usize,
}

impl Queue {
    fn new(jobs: &[Job], left: Vec<usize>, free: f64) -> Self {
        let state = State {
            left,
            free,
            running: 0,
        };
        Self {
            state: Mutex::new(state),
            over: Condvar::new(),
            needs: jobs.iter().map(Job::memory).collect(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|lock| lock.into_inner())
    }

    /// The next job that there is memory for; waits for it beside others. One that takes more than there is runs alone,
    /// and is refused in its own words.
    fn take(&self) -> Option<usize> {
        let mut state = self.state();
        loop {
            let fits = |&job: &usize| self.needs[job] <= state.free || state.running == 0;
            match state.left.iter().rposition(fits) {
                Some(at) => {
                    let job = state.left.remove(at);
                    state.free -= self.needs[job];
                    state.running += 1;
                    return Some(job);
                }
                None if state.left.is_empty() => return None,
                None => state = (self.over.wait(state)).unwrap_or_else(|lock| lock.into_inner()),
            }
        }
    }

    fn give_back(&self, job: usize) {
        let mut state = self.state();
        state.free += self.needs[job];
        state.running -= 1;
        self.over.notify_all();
    }
}

enum Word {
    Step(usize, f64),
    Done(usize, Outcome),
}

/// Runs jobs on `threads` threads, one thread per job, the longest first. `tell` may stop the queue: jobs that are not
/// finished by then return `None`.
///
/// ```no_run
/// use std::ops::ControlFlow;
///
/// use overfall::validate::{CASES, Job, METHODS, run_all};
///
/// let job = Job { case: CASES[0], method: &METHODS[2], resolution: CASES[0].resolution };
/// for outcome in run_all(&[job], 1, &mut |_| ControlFlow::Continue(())).into_iter().flatten() {
///     for figure in outcome.result.expect("a run to its end").figures {
///         let _ = (figure.quantity.as_str(), figure.measured, figure.known, figure.error());
///     }
/// }
/// ```
pub fn run_all(
    jobs: &[Job],
    threads: usize,
    tell: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Vec<Option<Outcome>> {
    let works: Vec<f64> = jobs.iter().map(Job::work).collect();
    let all: f64 = works.iter().sum();
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by(|&a, &b| works[a].total_cmp(&works[b]));
    let queue = Queue::new(jobs, order, memory::of_machine() as f64);
    let stop = AtomicBool::new(false);
    let mut outcomes: Vec<Option<Outcome>> = jobs.iter().map(|_| None).collect();
    let mut done = vec![0.0; jobs.len()];
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        let (queue, stop) = (&queue, &stop);
        let mut started = 0;
        for _ in 0..threads.clamp(1, jobs.len().max(1)) {
            let send = send.clone();
            let thread = Builder::new().spawn_scoped(scope, move || work(jobs, queue, stop, &send));
            // Where the system refuses a thread, those that there are do the jobs.
            started += usize::from(thread.is_ok());
        }
        if started == 0 {
            work(jobs, queue, stop, &send);
        }
        drop(send);
        for word in receive {
            let flow = match word {
                Word::Step(number, fraction) => {
                    done[number] = fraction;
                    let sum: f64 = done.iter().zip(&works).map(|(part, of)| part * of).sum();
                    tell(Event::Step {
                        job: &jobs[number],
                        fraction: sum / all,
                    })
                }
                Word::Done(number, outcome) => {
                    done[number] = 1.0;
                    outcomes[number] = Some(outcome);
                    tell(Event::Done {
                        number,
                        outcomes: &outcomes,
                    })
                }
            };
            if flow.is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    outcomes
}

/// Runs jobs until none is left.
fn work(jobs: &[Job], queue: &Queue, stop: &AtomicBool, send: &mpsc::Sender<Word>) {
    while !stop.load(Ordering::Relaxed) {
        let Some(number) = queue.take() else {
            return;
        };
        let job = jobs[number];
        let started = Instant::now();
        let mut said = started;
        let result = job
            .case
            .run(job.method, job.resolution, 1, &mut |fraction| {
                if said.elapsed() >= INTERVAL {
                    said = Instant::now();
                    // The receiver was dropped: the jobs are stopped.
                    if send.send(Word::Step(number, fraction)).is_err() {
                        return ControlFlow::Break(());
                    }
                }
                if stop.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
        queue.give_back(number);
        if matches!(result, Err(Stopped::Asked)) {
            return;
        }
        let outcome = Outcome {
            job,
            seconds: started.elapsed().as_secs_f64(),
            result,
        };
        if send.send(Word::Done(number, outcome)).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Jobs side by side never take more memory than there is, but for one that takes more than that alone.
    #[test]
    fn jobs_wait_for_the_memory_of_others() {
        let queue = Queue {
            state: Mutex::new(State {
                left: vec![3, 2, 1, 0],
                free: 10.0,
                running: 0,
            }),
            over: Condvar::new(),
            needs: vec![6.0, 5.0, 4.0, 30.0],
        };
        assert_eq!(queue.take(), Some(0));
        // The longest that fits: 1 does not.
        assert_eq!(queue.take(), Some(2));
        queue.give_back(0);
        assert_eq!(queue.take(), Some(1));
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| queue.take());
            queue.give_back(1);
            assert_eq!(queue.state().running, 1);
            queue.give_back(2);
            assert_eq!(waiting.join().ok(), Some(Some(3)));
        });
        assert_eq!(queue.take(), None);
        queue.give_back(3);
        let state = queue.state();
        assert_eq!((state.free, state.running), (10.0, 0));
    }
}
