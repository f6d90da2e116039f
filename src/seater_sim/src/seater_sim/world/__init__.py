"""What surrounds the chair: the visible scene, walls and charging contact, events that change them."""
