"""What a scene says about its run before it runs, and which effects it needs.

What does the run start from?
- ``checked_start``: the poses of the start, checked

What will the chain do? (``nrchain plan``, ``nrchain describe``)
- ``description``: what does a scene simulate, and what does it leave out?
- ``plan``: which loads, growth and motion follow from its numbers?
- ``plan_waves``: which rates have the waves of the infinite chain?
- ``plan_line``: one line of a plan
- ``soundness``: does the chain hold?
- ``weaknesses``: by which rules do bonds, links and spheres give way?
- ``remedies``: which change makes it hold?
- ``regime``: what should the user be warned of?
- ``missing_stokeslets``: does one-body friction drop a flow larger than one that is kept?
- ``strain_reach``: how much of the disturbance of a flow lies beyond its reach?

Which effects does it need? (``nrchain plan --effects``, ``effects = "auto"``)
- ``effect_changes``: which effects could a scene drop or add?
- ``estimate``: how far does each of them move the chain?
- ``auto``: which set of effects is the cheapest within a tolerance?
- ``probe``: how far are sets of effects from the full model in a short run?
- ``choice``: what did the choice leave out, and does its bound hold during the run?
- ``hydrodynamic_set``: how far do the flows between spheres reach in a scene?
- ``flow_keys``: which keys set the reach and the finite size of its flows?
- ``counted_work``: how much work is one right-hand side?
- ``shared_steps``: how do several scenes differ, integrated on the same steps?
- ``combined_chains``: their chains as one system of equations
"""
