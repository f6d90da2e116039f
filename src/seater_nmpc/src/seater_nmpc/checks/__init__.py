"""Whether chair, dock, camera and parameters fit together: checks across files, before anything moves."""
