//! Doors through which IMC comes in and goes out, one module each.
