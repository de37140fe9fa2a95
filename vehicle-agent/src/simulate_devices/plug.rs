//! One simulated device's end of its line: plugged in or not, at its own speed, with faults.

use super::nonsense;
use crate::io::Pty;
use anyhow::Context as _;
use rustix::event::{PollFd, PollFlags};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Bits of a line for a byte: start, eight data, stop.
const BITS_PER_BYTE: f64 = 10.0;
/// Speed of the noise of a device without a fixed speed (bit/s).
const USUAL_BAUD: u32 = 115_200;
/// Most bytes of noise at once: unread bytes are lost, as on a line.
const MOST_NOISE: f64 = 4096.0;

/// One device's end of its line.
#[derive(Debug)]
pub(super) struct Plug {
    name: &'static str,
    /// The stable name, if one is requested.
    link: Option<PathBuf>,
    /// The line's speed (bit/s); `None` for a device without a fixed one.
    baud: Option<u32>,
    pty: Option<Pty>,
    /// The device sends noise instead of data.
    pub(super) babbles: bool,
    /// It sends invalid values.
    pub(super) nonsense: bool,
    /// Up to when noise has been sent.
    babbled: Duration,
    /// The begin of a sentence, while values are made invalid.
    begun: Vec<u8>,
    /// State of the noise generator.
    noise: u32,
}

impl Plug {
    /// A device that is plugged in.
    pub(super) fn new(name: &'static str, links: Option<&Path>, baud: Option<u32>) -> anyhow::Result<Self> {
        let link = links.map(|folder| folder.join(name));
        let mut plug = Self {
            name,
            link,
            baud,
            pty: None,
            babbles: false,
            nonsense: false,
            babbled: Duration::ZERO,
            begun: Vec::new(),
            noise: 1,
        };
        plug.plug_in()?;
        Ok(plug)
    }

    /// Plugs it in, with a new path and its stable name.
    pub(super) fn plug_in(&mut self) -> anyhow::Result<()> {
        self.unplug();
        let pty = Pty::open().context("a pseudo-terminal")?;
        if let Some(link) = &self.link {
            // The link of another run.
            std::fs::remove_file(link).ok();
            symlink(pty.path(), link).with_context(|| format!("making {}", link.display()))?;
        }
        self.pty = Some(pty);
        Ok(())
    }

    /// Unplugs the cable: the device's name is removed.
    pub(super) fn unplug(&mut self) {
        if self.pty.take().is_some()
            && let Some(link) = &self.link
        {
            std::fs::remove_file(link).ok();
        }
    }

    /// The device changes the speed of its line (bit/s).
    pub(super) const fn set_baud(&mut self, baud: u32) {
        self.baud = Some(baud);
    }

    /// Its name and path: the stable name, if there is one.
    pub(super) fn shown(&self) -> String {
        let path = self.link.as_deref().or(self.pty.as_ref().map(Pty::path));
        format!(
            "{}={}",
            self.name,
            path.map_or_else(|| "unplugged".to_owned(), |path| path.display().to_string())
        )
    }

    /// The file descriptor to poll; `None` while the other end is closed.
    pub(super) fn waits_at(&self) -> Option<PollFd<'_>> {
        let pty = self.pty.as_ref().filter(|pty| pty.is_open())?;
        Some(PollFd::new(pty, PollFlags::IN))
    }

    /// Sends the device's bytes; at another speed of the line they arrive as noise.
    pub(super) fn send(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        let Some(pty) = &mut self.pty else { return Ok(()) };
        if self.baud.is_some() && pty.baud() != self.baud {
            self.send_noise(bytes.len())
        } else if self.babbles {
            Ok(())
        } else {
            pty.write(bytes)?;
            Ok(())
        }
    }

    /// Sends lines of text, with invalid values if so set.
    pub(super) fn send_text(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        if !self.nonsense {
            self.begun.clear();
            return self.send(bytes);
        }
        self.begun.extend(bytes);
        let end =
            self.begun.iter().rposition(|byte| matches!(byte, b'\r' | b'\n')).map_or(0, |last| last + 1);
        let whole: Vec<u8> = self.begun.drain(..end).collect();
        let lines = whole.split_inclusive(|byte| *byte == b'\r');
        self.send(&lines.flat_map(nonsense::line).collect::<Vec<u8>>())
    }

    /// Sends the noise of a babbling device up to this time since the start, at the full speed of its line.
    pub(super) fn babble(&mut self, now: Duration) -> anyhow::Result<()> {
        let since_s = now.saturating_sub(self.babbled).as_secs_f64();
        if !self.babbles {
            self.babbled = now;
            return Ok(());
        }
        let bytes_per_s = f64::from(self.baud.unwrap_or(USUAL_BAUD)) / BITS_PER_BYTE;
        let whole = (since_s * bytes_per_s).min(MOST_NOISE).floor();
        if whole < 1.0 {
            return Ok(());
        }
        self.babbled = if whole < MOST_NOISE {
            self.babbled + Duration::from_secs_f64(whole / bytes_per_s)
        } else {
            now
        };
        // At most 4096.
        self.send_noise(whole as usize)
    }

    fn send_noise(&mut self, count: usize) -> anyhow::Result<()> {
        let noise: Vec<u8> = (0..count).map(|_| next(&mut self.noise)).collect();
        if let Some(pty) = &mut self.pty {
            pty.write(&noise)?;
        }
        Ok(())
    }

    /// Receives the computer's bytes, if sent at the right speed.
    pub(super) fn receive(&mut self) -> anyhow::Result<Vec<u8>> {
        let Some(pty) = &mut self.pty else { return Ok(Vec::new()) };
        let mut buffer = [0; 1024];
        let count = pty.read(&mut buffer)?.unwrap_or(0);
        let right = self.baud.is_none() || pty.baud() == self.baud;
        Ok(if right { buffer[..count].to_vec() } else { Vec::new() })
    }
}

impl Drop for Plug {
    fn drop(&mut self) {
        self.unplug();
    }
}

/// The next byte of noise: a linear congruence (Numerical Recipes, 7.1), of which the upper bits are used.
fn next(state: &mut u32) -> u8 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 24) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::Serial;
    use std::os::fd::AsFd as _;

    #[test]
    fn a_babbling_device_says_as_much_as_its_line_carries() {
        let Some(_) = Pty::for_test() else { return };
        let mut plug = Plug::new("test", None, Some(115_200)).unwrap();
        let line = Serial::open(plug.pty.as_ref().unwrap().path(), 115_200).unwrap();
        plug.babbles = true;
        let (mut all, mut buffer) = (0, [0; 4096]);
        for ms in (0..=2000).step_by(7) {
            plug.babble(Duration::from_millis(ms)).unwrap();
            while let Ok(count) = rustix::io::read(line.as_fd(), &mut buffer) {
                all += count;
            }
        }
        // Two seconds at 11 520 bytes a second, but for what the last piece left over.
        assert!((22_900..=23_040).contains(&all), "{all}");
    }
}
