"""What the wheels say: messages, where the chair was at any recent time, and how that drifts."""
