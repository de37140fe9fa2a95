//! A serial CAN adapter on the simulated bus, as the computer sees it.

use devices::can::CanFrame;
use devices::slcan::{Command, Line, Reader, encode};

const DONE: &[u8] = b"\r";
const REFUSED: &[u8] = b"\x07";

/// The adapter: it is on the bus only while open.
#[derive(Debug, Default)]
pub(super) struct Adapter {
    reader: Reader,
    open: bool,
}

impl Adapter {
    /// Processes what the computer sends: frames go to `bus`, answers are returned.
    pub(super) fn receive(&mut self, bytes: &[u8], mut bus: impl FnMut(CanFrame)) -> Vec<u8> {
        let mut answers = Vec::new();
        let open = &mut self.open;
        self.reader.feed(bytes, |_, line| match line {
            Ok(Line::Frame { frame, .. }) if *open => {
                answers.extend(b"Z\r");
                bus(frame);
            }
            Ok(Line::Command(command)) => answers.extend(obey(open, command)),
            // An empty line counts as a command without effect.
            Ok(Line::Done) => answers.extend(DONE),
            _ => answers.extend(REFUSED),
        });
        answers
    }

    /// The bytes of a bus frame for the computer; none while the adapter is closed.
    pub(super) fn send(&self, frame: &CanFrame) -> Vec<u8> {
        if self.open { encode(frame) } else { Vec::new() }
    }
}

fn obey(open: &mut bool, command: Command) -> &'static [u8] {
    match command {
        Command::Close => *open = false,
        // Commands that an adapter accepts only while closed.
        Command::Open | Command::Listen | Command::Bitrate(_) | Command::Timestamps(_) if *open => {
            return REFUSED;
        }
        Command::Open | Command::Listen => *open = true,
        Command::Bitrate(_) | Command::Timestamps(_) => {}
        Command::Status => return b"F00\r",
        Command::Version => return b"V1013\r",
        Command::Serial => return b"NSIM1\r",
    }
    DONE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_pass_while_it_is_open_and_not_before() {
        let frame = CanFrame::new(0x00D0_FEAB, &[1, 2, 3, 4]).unwrap();
        let (mut adapter, mut bus) = (Adapter::default(), Vec::new());
        let mut ask = |adapter: &mut Adapter, bytes: &[u8]| adapter.receive(bytes, |frame| bus.push(frame));
        assert_eq!(ask(&mut adapter, &encode(&frame)), b"\x07");
        assert!(adapter.send(&frame).is_empty());
        assert_eq!(ask(&mut adapter, b"C\rS6\rO\rS6\rV\r"), b"\r\r\r\x07V1013\r");
        assert_eq!(ask(&mut adapter, &encode(&frame)), b"Z\r");
        assert_eq!((adapter.send(&frame), bus), (encode(&frame), vec![frame]));
    }
}
