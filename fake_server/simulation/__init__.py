"""Match state, physics, perception and referee of rcssserver as compiled kernels; no text, no sockets."""
