"""Python runs this as it starts, where its folder is on the path: programs in tests mutate too."""

import os

if mutant := os.environ.get("NRCHAIN_MUTANT"):
    from validation.mutants.loading import load_as_mutant

    load_as_mutant(mutant)
