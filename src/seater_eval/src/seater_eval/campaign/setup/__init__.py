"""What a campaign consists of: its file, the configuration of each case, what the controller is told."""
