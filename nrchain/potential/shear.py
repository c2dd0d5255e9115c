"""V = Σ_links (λ⊥d²/2) Σ_{a=2,3} (C⁰e_a·C¹r)²: bonds resist leaving the direction of e₁.

Source: paper, Appendix B; C⁰ and C¹ in :mod:`nrchain.potential.link`.
"""

from __future__ import annotations

from nrchain._compile import part
from nrchain.potential.link import dot


@part
def strain(e, tangent):
    """C⁰e_a·C¹r, a = 2 or 3."""
    return dot(e, tangent)
