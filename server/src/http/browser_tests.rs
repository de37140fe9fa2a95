//! The first page in a real browser, on a made-up fleet.

use super::serve::serve;
use super::testing::{Boats, an_hour};
use crate::clock;
use crate::config::Config;

#[tokio::test(flavor = "multi_thread")]
async fn the_first_page_shows_the_fleet() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut config = Config { data: folder.path().to_owned(), ..Config::default() };
    config.imc.active = false;
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    an_hour(folder.path(), clock::now());
    let serving = serve(config).await.unwrap();
    Boats::join(&serving.relay).await.sail();
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let (ask_to_stop, mut asked) = tokio::sync::mpsc::channel(1);
    let script = tokio::task::spawn_blocking(move || {
        testkit::browser::run("fleet.mjs", &[&address, &password], |line| {
            if line == "stop the server" {
                ask_to_stop.blocking_send(()).unwrap();
            }
        });
    });
    if asked.recv().await.is_some() {
        serving.stop().await;
    }
    script.await.unwrap();
}
