"""The most informative motion: what is to be learnt, within which limits, searched for and judged.

Example:
    >>> from dynident.model import load_robot
    >>> from dynident.trajectories import Goal, ViaPointShape, build_design, solve_design
    >>> problem = build_design(load_robot("rx90"), ViaPointShape(14), Goal("cond"))
    >>> design = solve_design(problem, seed=1)
    >>> motion = design.motion(rate=250.0)
"""
