"""What a user states: the scene of a run, and the poses its chain starts from.

- ``scene``: the scene and its sections together
- ``chain_sections``: ``[chain]``, ``[elasticity]``, ``[start]`` and ``[run]``
- ``fluid_sections``: ``[slip]`` and ``[friction]``
- ``effect_sections``: the sections that effects add, such as ``[steric]``
- ``derived``: drag, moduli, length and wavevector of a scene
- ``checks``: rules that need several sections
- ``loading``: a scene from a name, a file or a table, with changes
- ``toml``: TOML text, shipped scenes, changes by dotted key
- ``poses``: the positions and frames of each shape
- ``unwrapping``: periodic chains whose positions were put back into a box
- ``memory``: room for a trajectory in memory and on disk
- ``extensions``: how effects register their sections
"""
