"""Images, materials and UV maps of scans and results."""
