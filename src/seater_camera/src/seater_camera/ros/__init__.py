"""The node round the stream."""
