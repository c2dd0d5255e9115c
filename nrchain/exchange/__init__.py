"""Trajectories in the formats of other programs, and starts from any of them.

- ``export``: writes a trajectory in the format of the ending of its path
- ``start``: the frame of a run or of an exported file, as the start of another run
- ``formats``: the formats, by the ending of their files
- ``record``: what an exported file says of the run it comes from
- ``gsd_files``, ``xyz_files``, ``vtk_files``, ``numpy_files``, ``netcdf_files``: one format each
"""
