"""Function approximators, Sarsa and exploration, compiled."""
