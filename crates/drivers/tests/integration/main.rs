//! Tests of `drivers` from outside, one program: it is linked once.

mod hostile;
