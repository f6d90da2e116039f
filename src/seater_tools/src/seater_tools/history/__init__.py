"""One line per docking, what it tells over time, and when something has changed."""
