"""An emergency stop: a normally closed contact at GPIO lines."""
