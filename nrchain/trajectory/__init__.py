"""The trajectory of a run: its file, who may write to it, and how it is read.

- ``trajectory``: the poses of a run at its snapshots
- ``recorder``: what a run writes to, and the recorder that keeps a trajectory in memory
- ``writer``: the recorder that keeps a trajectory in a file
- ``file``: the file on the disk: create it, lock it, open it
- ``layout``: names and meanings of all that is in a file
- ``new_file``: makes the file of a run, with room for all its snapshots
- ``extension``: makes the file of a run anew, with a later end
- ``provenance``: what a run started from, step by step
- ``labelled``: a trajectory as a labelled dataset
- ``snapshots``: the snapshots in a file, which grow one by one
- ``checkpoint``: where a run can be resumed, and what it counts
- ``reader``: the fields of a trajectory, from its file
- ``checked_datasets``: data sets of a file, checked; damage is named
- ``write_lock``: the lock that lets one run at a time write a file
- ``data_file``: the data file, kept free of other programs that write to it
"""
