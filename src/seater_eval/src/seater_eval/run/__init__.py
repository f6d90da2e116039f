"""Running evaluation commands: options, files, processes, progress, interrupted runs."""
