"""What a fault does to a docking that runs freely, fault by fault."""
