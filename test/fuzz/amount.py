"""How many hostile messages: a few where every change is tested, 100 000 for a release."""

import os

MESSAGES = int(os.environ.get("SEATER_FUZZ_MESSAGES", "300"))  # per topic
PER_EPISODE = min(1000, max(1, MESSAGES))
EPISODES = -(-MESSAGES // PER_EPISODE)
