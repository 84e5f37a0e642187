"""Steps on a worker thread: start, progress, preview and end."""
