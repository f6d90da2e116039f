"""Weights of the controller, searched over a campaign of simulated dockings."""
