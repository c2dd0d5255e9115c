"""What is measured on a trajectory.

- ``measure``: waves and their rates, motions, straightness, handedness, with standard errors
- ``handedness``: the hand of a coil
- ``decomposition``: what each effect contributes to the motion
- ``measured_chain``: positions and links as all measurements take them
"""
