"""Reference driver of a base: a microcontroller with two motors and encoders behind a serial port."""
