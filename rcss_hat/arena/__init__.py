"""Simulation, players and policies in one compiled loop; no text, no sockets."""
