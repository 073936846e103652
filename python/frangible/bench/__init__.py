"""Measurements: times, memory, claims, and other engines beside ours."""
