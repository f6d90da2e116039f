"""Print sheets of the markers of a dock."""
