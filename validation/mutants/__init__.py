"""Single-point mutants of the package outside its kernels, and the tests that notice them."""
