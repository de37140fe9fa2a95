//! Quantities, angles, time and places that all of Lutra shares.
