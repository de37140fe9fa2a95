//! The transfer of the chart to a vessel.

use super::vessel::{Answer, Task};
use link::{ChartReport, ChartRequest, ConnectionId, ShoreInput};

impl Task {
    /// Offers the chart that is ashore.
    pub(crate) fn offer_chart(&mut self) {
        let offer = self.chart.borrow_and_update().as_ref().map(|package| package.offer());
        self.handle(ShoreInput::Chart(offer));
    }

    /// Reads a part of the chart for the vessel.
    pub(crate) fn read_chart(&self, id: ConnectionId, ask: ChartRequest) {
        let package = self.chart.borrow().clone().filter(|package| package.digest() == ask.digest);
        let answers = self.answers.0.clone();
        let read = move || package.and_then(|package| package.part(ask.offset, ask.length));
        tokio::spawn(async move {
            let bytes = tokio::task::spawn_blocking(read).await.ok().flatten();
            answers.send(Answer::Part(id, ask, bytes)).await.ok();
        });
    }

    /// The vessel reports which chart it holds.
    pub(super) fn chart_aboard(&self, report: ChartReport) {
        self.aboard.tell(self.vessel, report, self.now().utc);
        let aboard = self.aboard.clone();
        tokio::task::spawn_blocking(move || aboard.save());
    }
}
