"""Child processes with limits, on this machine or on the workers of a cluster; batches and tiles run on them."""
