"""The node round the finder."""
