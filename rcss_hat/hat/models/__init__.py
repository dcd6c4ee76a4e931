"""Models that other libraries have trained, as policies."""
