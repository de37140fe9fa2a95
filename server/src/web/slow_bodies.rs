//! Time limit for a request's whole body.
//!
//! Without this a stranger could hold a connection for weeks with a byte now and then. Uploads of logs may be long and
//! limit their pace themselves ([`crate::http`]'s imports).

use axum::body::Body;
use axum::extract::Request;
use axum::middleware::Next;
use axum::response::Response;
use futures_util::{StreamExt as _, stream};
use std::io;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};

/// Enough for 4 MiB over a bad mobile connection.
const WHOLE: Duration = Duration::from_mins(2);

/// Ends a body that is not complete in time with an error, so that no handler takes a part for the whole.
pub(crate) async fn keep(request: Request, next: Next) -> Response {
    let ends = Instant::now() + WHOLE;
    next.run(request.map(|body| until(body, ends))).await
}

fn until(body: Body, ends: Instant) -> Body {
    Body::from_stream(stream::unfold(body.into_data_stream(), move |mut chunks| async move {
        let chunk = match timeout_at(ends, chunks.next()).await {
            Ok(chunk) => chunk?.map_err(io::Error::other),
            Err(_) => Err(io::Error::new(io::ErrorKind::TimedOut, "the body took too long")),
        };
        Some((chunk, chunks))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::{Bytes, to_bytes};

    #[tokio::test]
    async fn a_body_is_whole_in_time_or_an_error() {
        let first = || stream::iter([Ok::<_, io::Error>(Bytes::from_static(b"a=1&"))]);
        let late = Body::from_stream(first().chain(stream::pending()));
        let error = to_bytes(until(late, Instant::now()), 100).await.unwrap_err();
        assert!(error.to_string().contains("too long"), "{error}");
        let whole = Body::from_stream(first().chain(first()));
        assert_eq!(to_bytes(until(whole, Instant::now() + WHOLE), 100).await.unwrap(), "a=1&a=1&");
    }
}
