//! A thread that plans routes, so that the control loop never waits for one.
//!
//! At most one request is queued: a newer one replaces it, and cancels the work on an older one. The chart is the brain's
//! own, shared and not loaded again; the prepared water on it is kept for the next request. A route is only returned to the
//! brain, which checks it. A panic of the planner is an answer like any other: the vessel continues without a route.

use crate::ending::ROUTING_THREAD;
use onboard::{Chart, RouteAnswer, RouteRequest, Routes};
use planner::Cancel;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Planning recurses over the chart's trees: more than a thread has by default.
const STACK_BYTES: usize = 8 << 20;

/// Handle of the thread; the thread ends with it.
#[derive(Debug)]
pub(crate) struct Routing {
    desk: Arc<Desk>,
    /// Digest of the chart that was in force at the last call.
    digest: Option<[u8; 32]>,
}

/// An order for the thread.
enum Order {
    Find(Chart, Box<RouteRequest>),
    KeepTo(Chart),
}

#[derive(Debug, Default)]
struct Desk {
    orders: Mutex<Orders>,
    came: Condvar,
}

#[derive(Debug, Default)]
struct Orders {
    waiting: Option<(Chart, Box<RouteRequest>)>,
    /// A new chart in force, until the thread has taken it.
    chart: Option<Chart>,
    /// The number of the only request whose answer is still needed.
    wanted: Option<u32>,
    over: bool,
}

impl Desk {
    fn lock(&self) -> MutexGuard<'_, Orders> {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn next(&self) -> Option<Order> {
        let mut orders = self.lock();
        loop {
            if orders.over {
                return None;
            }
            if let Some((chart, request)) = orders.waiting.take() {
                return Some(Order::Find(chart, request));
            }
            if let Some(chart) = orders.chart.take() {
                return Some(Order::KeepTo(chart));
            }
            orders = self.came.wait(orders).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn wants(&self, number: u32) -> bool {
        let orders = self.lock();
        !orders.over && orders.wanted == Some(number)
    }
}

impl Routing {
    /// Starts the thread; `answer` is called by it and must not wait.
    pub(crate) fn start(answer: impl Fn(RouteAnswer) + Send + 'static) -> anyhow::Result<Self> {
        let desk = Arc::new(Desk::default());
        let work = Arc::clone(&desk);
        let builder = std::thread::Builder::new().name(ROUTING_THREAD.to_owned()).stack_size(STACK_BYTES);
        builder.spawn(move || {
            let mut routes = Routes::default();
            while let Some(order) = work.next() {
                let (chart, request) = match order {
                    Order::Find(chart, request) => (chart, request),
                    Order::KeepTo(chart) => {
                        routes.keep_to(&chart);
                        continue;
                    }
                };
                let wanted = || work.wants(request.number);
                let found = AssertUnwindSafe(|| routes.answer(&chart, &request, &Cancel::unless(&wanted)));
                let found = catch_unwind(found).unwrap_or_else(|_| {
                    // State from before the panic is discarded.
                    routes = Routes::default();
                    let why = "the planner failed by a fault of its own; please report what the log says"
                        .to_owned();
                    Some(RouteAnswer { number: request.number, outcome: Err(why) })
                });
                if let Some(found) = found.filter(|_| wanted()) {
                    answer(found);
                }
            }
        })?;
        Ok(Self { desk, digest: None })
    }

    /// Sets the chart in force: an earlier one and its prepared data do not stay in memory.
    pub(crate) fn keep_to(&mut self, chart: &Chart) {
        let digest = chart.digest();
        if digest != self.digest {
            self.digest = digest;
            self.desk.lock().chart = Some(chart.clone());
            self.desk.came.notify_one();
        }
    }

    /// Plans this route on this chart, in place of the previous one; without a request it only cancels.
    pub(crate) fn ask(&self, chart: &Chart, request: Option<Box<RouteRequest>>) {
        let mut orders = self.desk.lock();
        orders.wanted = request.as_ref().map(|request| request.number);
        orders.waiting = request.map(|request| (chart.clone(), request));
        drop(orders);
        self.desk.came.notify_one();
    }
}

impl Drop for Routing {
    fn drop(&mut self) {
        self.desk.lock().over = true;
        self.desk.came.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planner::{Needs, Zones};
    use std::sync::mpsc::channel;
    use std::time::Duration;
    use testkit::sea::Sea;
    use units::{LatLon, LocalPoint};

    const LONG: Duration = Duration::from_secs(30);

    fn request(number: u32, chart: &Sea) -> Box<RouteRequest> {
        let place = |north_m| chart.frame().to_place(LocalPoint { north_m, east_m: 0.0 });
        let (from, to, needs) = (place(-300.0), place(300.0), Needs::depth_and_clearance(5.0, 25.0));
        Box::new(RouteRequest { number, from, to, needs, zones: Zones::default(), longest_m: 5_000.0 })
    }

    #[test]
    fn the_newest_request_takes_the_place_of_one_that_waits_and_what_is_called_off_is_not_answered() {
        let sea = Sea::new(LatLon::from_deg(63.33, 10.08).unwrap(), 800.0, 20.0);
        let chart = Chart::of("sea", sea.index());
        let (answered, answers) = channel();
        let (go_on, may_go_on) = channel::<()>();
        let routing = Routing::start(move |answer| {
            answered.send(answer).unwrap();
            may_go_on.recv().ok();
        })
        .unwrap();
        routing.ask(&chart, Some(request(1, &sea)));
        let first = answers.recv_timeout(LONG).unwrap();
        assert_eq!((first.number, first.outcome.unwrap().places.len()), (1, 2));
        // The thread is busy with the answer meanwhile.
        routing.ask(&chart, Some(request(2, &sea)));
        routing.ask(&chart, Some(request(3, &sea)));
        go_on.send(()).unwrap();
        assert_eq!(answers.recv_timeout(LONG).unwrap().number, 3);
        routing.ask(&chart, Some(request(4, &sea)));
        routing.ask(&chart, None);
        routing.ask(&Chart::Off, Some(request(5, &sea)));
        go_on.send(()).unwrap();
        let last = answers.recv_timeout(LONG).unwrap();
        assert!(last.number == 5 && last.outcome.unwrap_err().contains("no chart"));
        drop((routing, go_on));
        assert!(answers.recv_timeout(LONG).is_err(), "the thread ends with the way to it");
    }
}
