"""`make demo`: every system compiled, run, validated, drawn; one table, one page.

    stages.py        what is done, two at a time
    systems.py       one line of the table: a spec, its run, its comparison, its picture
    experiments.py   the runs behind the figures
    moving.py        the three spheres that move at the head of the page
    exact.py         the free body's solution in Jacobi's functions
    paths.py         trajectories that cover a sphere evenly
"""
