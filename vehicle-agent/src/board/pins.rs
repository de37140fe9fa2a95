//! GPIO pins of the computer: the kernel's character device, behind a trait that tests replace.

use anyhow::Context as _;
use gpiocdev::Request;
use gpiocdev::line::Value;
use std::time::Duration;
use units::MonoTime;

/// Pins that are absent or taken are looked for again after this time.
const AGAIN: Duration = Duration::from_secs(10);

/// Requested pins.
pub(super) trait Pins: Send {
    /// Sets an output.
    fn set(&mut self, number: u8, high: bool) -> anyhow::Result<()>;

    /// The level of an input.
    fn is_high(&mut self, number: u8) -> anyhow::Result<bool>;
}

/// Takes the pins.
pub(super) type Open = Box<dyn FnMut() -> anyhow::Result<Box<dyn Pins>> + Send>;

/// The wanted pins, by their Broadcom numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Wanted {
    pub(super) outputs: Vec<u8>,
    pub(super) inputs: Vec<u8>,
}

/// Pins of the kernel's character device `chip`. Outputs begin low.
pub(super) fn of_kernel(chip: String, wanted: Wanted) -> Open {
    Box::new(move || {
        let offsets = |pins: &[u8]| pins.iter().map(|pin| u32::from(*pin)).collect::<Vec<u32>>();
        let mut request = Request::builder();
        request.on_chip(&chip).with_consumer("lutra-agent");
        request.with_lines(&offsets(&wanted.outputs)).as_output(Value::Inactive);
        if !wanted.inputs.is_empty() {
            request.with_lines(&offsets(&wanted.inputs)).as_input();
        }
        let pins = request.request().with_context(|| {
            let Wanted { outputs, inputs } = &wanted;
            format!(
                "the pins {outputs:?} and {inputs:?} of {chip} cannot be taken; see that it exists, that this user may open \
                 it (group gpio), that no other program has them (gpioinfo), or give the section another `GPIO Chip`"
            )
        })?;
        Ok(Box::new(OfKernel(pins)))
    })
}

/// Pins granted by the kernel. It takes them back when the process ends in any way; whether an output keeps its level then
/// depends on the pin driver (on a Raspberry Pi `persist_gpio_outputs` of pinctrl-bcm2835).
struct OfKernel(Request);

impl Pins for OfKernel {
    fn set(&mut self, number: u8, high: bool) -> anyhow::Result<()> {
        let level = if high { Value::Active } else { Value::Inactive };
        self.0.set_value(number.into(), level).with_context(|| format!("pin {number} cannot be set"))?;
        Ok(())
    }

    fn is_high(&mut self, number: u8) -> anyhow::Result<bool> {
        let level = self.0.value(number.into()).with_context(|| format!("pin {number} cannot be read"))?;
        Ok(level == Value::Active)
    }
}

/// Access to pins that may be missing, or be lost.
pub(super) struct Access {
    open: Open,
    pins: Option<Box<dyn Pins>>,
    /// When to try again.
    again: MonoTime,
}

impl Access {
    pub(super) fn new(open: Open) -> Self {
        Self { open, pins: None, again: MonoTime::default() }
    }

    /// Requests the pins if they are not held and a retry is due; returns whether they have just been granted.
    ///
    /// # Errors
    /// When they are not granted; it is tried again later.
    pub(super) fn open(&mut self, now: MonoTime) -> anyhow::Result<bool> {
        if self.pins.is_some() || now < self.again {
            return Ok(false);
        }
        self.again = now + AGAIN;
        self.pins = Some((self.open)()?);
        Ok(true)
    }

    /// The pins, if they are held.
    pub(super) fn pins(&mut self) -> Option<&mut dyn Pins> {
        match &mut self.pins {
            Some(pins) => Some(pins.as_mut()),
            None => None,
        }
    }

    /// Releases the pins, as after an error.
    pub(super) fn close(&mut self) {
        self.pins = None;
    }
}
