"""The node round the driver."""
