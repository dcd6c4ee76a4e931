"""A stand-in for rcssserver that real Keepaway clients can play on."""
