//! Requests to app.db.

use super::fault::Fault;
use sqlx::SqliteConnection;

/// A query or change of app.db, as a value with its arguments.
pub trait Request: Send + 'static {
    /// Its result.
    type Answer: Send + 'static;

    /// Carries it out. An error undoes all of it.
    fn run(self, db: &mut SqliteConnection) -> impl Future<Output = Result<Self::Answer, Fault>> + Send;
}

/// Two requests in one transaction.
impl<A: Request, B: Request> Request for (A, B) {
    type Answer = (A::Answer, B::Answer);

    async fn run(self, db: &mut SqliteConnection) -> Result<Self::Answer, Fault> {
        Ok((self.0.run(db).await?, self.1.run(db).await?))
    }
}
