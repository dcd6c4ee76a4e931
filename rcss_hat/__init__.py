"""RoboCup Keepaway and Human-Agent Transfer in Python."""

__version__ = "0.1.0"
