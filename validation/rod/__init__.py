"""Does the nonlinear rod have the motion of the chain?"""
