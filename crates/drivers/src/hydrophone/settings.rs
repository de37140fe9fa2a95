//! Command mode: the receiver's settings, one command after another, each answer compared with what it must be.

use devices::tbr_clock::ClockCommand;

/// A command of command mode, and what its answer must be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    command: ClockCommand,
    answer: Answer,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Answer {
    Exactly(String),
    /// Any with this beginning.
    Begins(String),
}

/// The text is not a command that a driver may send.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{0}' is not a setting of the hydrophone: FC=69, LM=08, LI=01 and FV? are; commands that restart or erase it are never sent"
)]
pub struct NoSetting(String);

impl Setting {
    /// From a text such as `FC=69`, `LM=08`, `LI=01`, whose answer is the same, `FV?`, answered by `FV=` and anything, or
    /// `FV?v1.0.6`, answered by `FV=v1.0.6` alone.
    ///
    /// # Errors
    /// For any other command: none that restarts the receiver, erases it or loads firmware is ever sent.
    pub fn parse(text: &str) -> Result<Self, NoSetting> {
        let refused = || NoSetting(text.to_owned());
        let (name, value) = text.split_at_checked(2).ok_or_else(refused)?;
        if let Some(version) = value.strip_prefix('?').filter(|_| name == "FV") {
            let answer = match version {
                "" => Answer::Begins("FV=".to_owned()),
                version => Answer::Exactly(format!("FV={version}")),
            };
            return Ok(Self { command: ClockCommand::Version, answer });
        }
        let digits = value.strip_prefix('=').ok_or_else(refused)?;
        let two_digits = digits.len() == 2 && digits.bytes().all(|byte| byte.is_ascii_digit());
        if !two_digits || !["FC", "LM", "LI"].contains(&name) {
            return Err(refused());
        }
        let answer = Answer::Exactly(text.to_owned());
        Ok(Self { command: ClockCommand::Setting(text.to_owned()), answer })
    }

    pub(super) fn text(&self) -> String {
        self.command.text()
    }

    pub(super) fn accepts(&self, reply: &str) -> bool {
        match &self.answer {
            Answer::Exactly(answer) => reply == answer,
            Answer::Begins(beginning) => reply.starts_with(beginning),
        }
    }

    pub(super) fn expected(&self) -> String {
        match &self.answer {
            Answer::Exactly(answer) => answer.clone(),
            Answer::Begins(beginning) => format!("{beginning}.."),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_settings_are_sent() {
        for text in ["FC=69", "LM=08", "LI=01"] {
            let setting = Setting::parse(text).unwrap();
            assert!(setting.accepts(text) && !setting.accepts("FC=67"));
            assert_eq!(setting.text(), text);
        }
        let version = Setting::parse("FV?").unwrap();
        assert!(version.accepts("FV=v9") && !version.accepts("ERR"));
        let version = Setting::parse("FV?v1.0.6").unwrap();
        assert_eq!(version.text(), "FV?");
        assert!(version.accepts("FV=v1.0.6") && !version.accepts("FV=v1.0.7"));
        for text in ["UF!", "FS!", "RR!", "EX!", "UT=1234567890", "FC=", "FC=6", "FC=xx", "", "F", "æø"] {
            assert_eq!(Setting::parse(text), Err(NoSetting(text.to_owned())), "{text}");
        }
    }
}
