"""What the chair's motors make of commands: as configured, as learned from the response, and how to ask them."""
