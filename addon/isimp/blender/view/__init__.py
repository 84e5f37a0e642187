"""What the 3D view shows over and beside a scan."""
