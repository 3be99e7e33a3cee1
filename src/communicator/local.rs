//! Ranks in one process, each in a thread of its own.

use std::sync::{
    Mutex, PoisonError,
    mpsc::{Receiver, Sender, channel},
};

use super::{Communicator, Lost};

/// A rank among several in one process, with a channel to and from each.
///
/// Every rank needs a thread of its own, and a thread pool of its own ([`Execution`](crate::Execution)): it waits in
/// one of its threads.
pub struct Local {
    rank: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Mutex<Vec<Receiver<Vec<u8>>>>,
}

impl Local {
    /// So many ranks, in their order.
    pub fn team(ranks: usize) -> Vec<Self> {
        let mut to: Vec<Vec<Sender<Vec<u8>>>> = (0..ranks).map(|_| Vec::new()).collect();
        let receivers = |_| {
            let channels = to.iter_mut().map(|to| {
                let (sender, receiver) = channel();
                to.push(sender);
                receiver
            });
            channels.collect()
        };
        let from: Vec<Vec<Receiver<Vec<u8>>>> = (0..ranks).map(receivers).collect();
        let ends = to.into_iter().zip(from).enumerate();
        ends.map(|(rank, (to, from))| Self {
            rank,
            to,
            from: Mutex::new(from),
        })
        .collect()
    }
}

impl Communicator for Local {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.to.len()
    }

    fn exchange(&self, messages: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Lost> {
        for (rank, (to, message)) in self.to.iter().zip(messages).enumerate() {
            to.send(message).map_err(|_| Lost::Ended { rank })?;
        }
        let from = self.from.lock().unwrap_or_else(PoisonError::into_inner);
        let receive = |(rank, from): (usize, &Receiver<Vec<u8>>)| {
            from.recv().map_err(|_| Lost::Ended { rank })
        };
        from.iter().enumerate().map(receive).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn every_rank_gets_what_every_rank_sent_to_it() {
        let ranks = thread::scope(|scope| {
            let threads: Vec<_> = (Local::team(4).into_iter())
                .map(|rank| {
                    scope.spawn(move || {
                        let me = rank.rank() as u8;
                        let sent = (0..4).map(|to| vec![me; to]).collect();
                        (rank.exchange(sent), rank.gather(vec![me]))
                    })
                })
                .collect();
            threads
                .into_iter()
                .map(|thread| thread.join().expect("no panic"))
                .collect::<Vec<_>>()
        });
        for (me, (exchanged, gathered)) in ranks.into_iter().enumerate() {
            let expected: Vec<Vec<u8>> = (0..4).map(|from| vec![from; me]).collect();
            assert_eq!(exchanged, Ok(expected));
            assert_eq!(gathered, Ok((0..4).map(|from| vec![from]).collect()));
        }
    }

    #[test]
    fn the_end_of_a_rank_is_told_to_the_others() {
        let mut ranks = Local::team(3);
        ranks.truncate(2);
        let lost = ranks[0].gather(Vec::new());
        assert_eq!(lost, Err(Lost::Ended { rank: 2 }));
    }
}
