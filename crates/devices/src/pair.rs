//! Two of something, one to port and one to starboard.

/// A side of the vessel, seen when looking forward.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Left; thruster and motor 0.
    Port,
    /// Right; thruster and motor 1.
    Starboard,
}

impl Side {
    /// Both sides, in the order of their motor numbers.
    pub const BOTH: [Self; 2] = [Self::Port, Self::Starboard];

    /// The motor's number on the bus: 0 to port, 1 to starboard.
    pub const fn index(self) -> u8 {
        match self {
            Self::Port => 0,
            Self::Starboard => 1,
        }
    }
}

/// One value for each side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Pair<T> {
    /// The port value.
    pub port: T,
    /// The starboard value.
    pub starboard: T,
}

impl<T> Pair<T> {
    /// Port first.
    pub const fn new(port: T, starboard: T) -> Self {
        Self { port, starboard }
    }

    /// The value of one side.
    pub const fn of(&self, side: Side) -> &T {
        match side {
            Side::Port => &self.port,
            Side::Starboard => &self.starboard,
        }
    }

    /// The value of one side, to change.
    pub const fn of_mut(&mut self, side: Side) -> &mut T {
        match side {
            Side::Port => &mut self.port,
            Side::Starboard => &mut self.starboard,
        }
    }

    /// The same function of both.
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> Pair<U> {
        Pair { port: f(self.port), starboard: f(self.starboard) }
    }
}
