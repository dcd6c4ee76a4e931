"""What is soccer and not Keepaway: plain Python around the compiled step, which Keepaway plays without."""
