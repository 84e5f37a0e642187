"""Tests; `shared` has modules for benchmarks too."""
