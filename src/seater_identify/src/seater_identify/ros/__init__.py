"""The node for a real chair."""
