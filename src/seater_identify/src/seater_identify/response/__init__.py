"""How speed answers to commands: model and fit of one axis."""
