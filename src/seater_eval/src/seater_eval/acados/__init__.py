"""acados as a peer of the controller: the same problem, in a process of its own. Optional: nothing else needs it."""
