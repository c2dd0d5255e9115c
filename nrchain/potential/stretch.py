"""V = Σ_links (λ∥d²/2)(C⁰e₁·C¹r − 1)²: bonds resist being longer or shorter than d along e₁.

Source: paper, Appendix B; C⁰ and C¹ in :mod:`nrchain.potential.link`.
"""

from __future__ import annotations

from nrchain._compile import part
from nrchain.potential.link import dot


@part
def strain(e, tangent):
    """C⁰e₁·C¹r − 1."""
    return dot(e, tangent) - 1.0
