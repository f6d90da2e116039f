"""Live parameters on dynamic_reconfigure."""
