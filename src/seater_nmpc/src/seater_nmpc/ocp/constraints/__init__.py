"""One module for each kind of area: what it is, and the soft constraint that it puts on every stage."""
