"""Commissioning tools: what a technician needs between the box and the first docking."""
