"""Table, figures and the copies of the configuration files."""
