//! What is asked of app.db.

use super::fault::Fault;
use sqlx::SqliteConnection;

/// Something asked of app.db, as a value with its arguments.
pub trait Request: Send + 'static {
    /// What comes of it.
    type Answer: Send + 'static;

    /// Carries it out. A fault undoes all of it.
    fn run(self, db: &mut SqliteConnection) -> impl Future<Output = Result<Self::Answer, Fault>> + Send;
}

/// Two questions, of one moment.
impl<A: Request, B: Request> Request for (A, B) {
    type Answer = (A::Answer, B::Answer);

    async fn run(self, db: &mut SqliteConnection) -> Result<Self::Answer, Fault> {
        Ok((self.0.run(db).await?, self.1.run(db).await?))
    }
}
