"""Other controllers for the same task, behind one interface, to compare with."""
