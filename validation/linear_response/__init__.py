"""The linear operator of the simulated chain against the paper's equations and laws."""
