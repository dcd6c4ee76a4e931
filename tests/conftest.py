"""Shared settings of all tests."""

from __future__ import annotations

import signal

from hypothesis import settings

settings.register_profile("project", deadline=None, max_examples=60, derandomize=True)
settings.load_profile("project")

# Shells start background jobs with SIGINT ignored, and programs that tests start and interrupt would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
