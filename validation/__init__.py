"""Why to trust nrchain: studies that hold it against derivations, the paper and PyStokes.

``python -m validation`` runs them all and writes a report; a study is a module of this package with
a function ``study(recorder)``, named in :mod:`validation.report.studies`.
"""
