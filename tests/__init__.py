"""The tests, and in `shared` what the benchmarks use too."""
