"""All estimates of one recording, with what was not excited."""
