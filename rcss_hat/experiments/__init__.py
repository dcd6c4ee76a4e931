"""Conditions, trials, metrics, statistics and figures of the paper's evaluation."""
