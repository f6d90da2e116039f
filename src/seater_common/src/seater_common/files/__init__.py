"""Files of a chair and its docks."""
