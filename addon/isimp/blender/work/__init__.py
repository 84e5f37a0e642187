"""Runs steps on a worker thread: start, progress, preview and end."""
