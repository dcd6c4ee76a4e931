"""Studies with people: steps, participants, what is kept of them, and from there to results."""
