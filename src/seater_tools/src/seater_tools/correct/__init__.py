"""A dock file with the sizes that were really printed."""
