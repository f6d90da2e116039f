"""Several docks at the docking node: which there are, which one is looked for, and whether the chair stands in it."""
