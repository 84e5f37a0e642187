"""The scan and its result in Blender: reading, writing and stored data."""
