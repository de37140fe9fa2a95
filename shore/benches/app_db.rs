//! How long a query to app.db waits while the audit log is written and synced without a pause: in parallel with the writing
//! thread, as pages do, and in its queue, as all queries once did. `cargo bench -p shore --bench app_db`.

#![expect(clippy::unwrap_used, reason = "a benchmark ends where it unwraps nothing")]

use shore::clock::Clock;
use shore::identity::audit::Entries;
use shore::identity::{Line, People, Settings};
use shore::owners::Owners;
use std::time::{Duration, Instant};
use tokio_util::sync::CancellationToken;

/// How long each variant is measured.
const MEASURED: Duration = Duration::from_secs(5);
/// Pause between two queries.
const PAUSE: Duration = Duration::from_millis(2);
const PATIENCE: Duration = Duration::from_secs(10);

#[tokio::main]
async fn main() {
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock::real();
    let owners = Owners::new(clock.clone());
    let people = People::start(folder.path(), &Settings::default(), &owners, clock).await.unwrap().0;
    for (way, beside) in [("beside the writer", true), ("in the writer's queue", false)] {
        let stop = CancellationToken::new();
        let writing = tokio::spawn(write_until(people.clone(), stop.clone()));
        let (mut waits, begun) = (Vec::new(), Instant::now());
        while begun.elapsed() < MEASURED {
            let (asked, question) = (Instant::now(), Entries { count: 1, ..Default::default() });
            let answer = if beside { people.ask(question).await } else { people.change(question).await };
            answer.unwrap();
            waits.push(asked.elapsed());
            tokio::time::sleep(PAUSE).await;
        }
        stop.cancel();
        waits.sort_unstable();
        let ms = |share: usize| waits[(waits.len() - 1) * share / 100].as_secs_f64() * 1e3;
        let writes = writing.await.unwrap();
        println!(
            "{way}: {} questions beside {writes} writes of 10 lines: median {:.2} ms, p99 {:.2} ms, most {:.2} ms",
            waits.len(),
            ms(50),
            ms(99),
            ms(100)
        );
    }
}

async fn write_until(people: People, stop: CancellationToken) -> usize {
    let line = |number: usize| Line {
        actor: "anna".to_owned(),
        address: "::1".to_owned(),
        action: "stop",
        subject: number.to_string(),
        outcome: "done".to_owned(),
    };
    let mut writes = 0;
    while !stop.is_cancelled() {
        people.record((0..10).map(line).collect(), PATIENCE).await.unwrap();
        writes += 1;
    }
    writes
}
