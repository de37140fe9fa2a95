//! What browsers and scripts send to the server and get from it.
