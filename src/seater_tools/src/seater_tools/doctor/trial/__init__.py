"""The doctor against simulated installations whose faults are known."""
