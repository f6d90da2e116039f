"""What runs the parts in time: the simulator's steps and the waiting of the lock-step."""
