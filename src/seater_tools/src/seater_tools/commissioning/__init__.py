"""From the box to the docked chair, at simulated installations whose truth nobody is told."""
