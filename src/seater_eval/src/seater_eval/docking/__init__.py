"""Single dockings: recordings, summaries, figures."""
