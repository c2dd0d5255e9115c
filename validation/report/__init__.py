"""What all studies share: recorder, report, style, scenes, and the laws of the paper."""
