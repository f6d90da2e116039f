"""A web page to see and use the docking from a phone, and what rviz shows of it."""
