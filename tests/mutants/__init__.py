"""Mutants: faults planted in what decides the generated C, and the tests that must notice them.

    python tests/mutants/run.py [--seed 1] [--jobs 2] [--only ID] [--list]        (or: make mutants)

A mutant is one changed line of a template or of the runtime (--generator: of a module of the generator
that decides C). Candidates come from two sources (`operators.py`: every operator, index, coefficient,
comparison and constant in the code; `rules.py`: faults of the kinds that integrators suffer from,
written as patterns, so that they follow the code when it moves). A seed draws a number of each kind,
file after file in turn. Each drawn mutant is planted in a copy of the tree (`plant.py`); what no
longer generates or compiles is thrown away and the next one drawn. The tests then run in an order
that finds most faults soonest, and stop at the first that fails (`judge.py`). A test that compares
the text of generated C with a stored one does not count and is not run.

A mutant that no test notices is compared with the original: when the generated C of every spec,
method and solver compiles to the same object code, nothing was changed and the next one is drawn.
Any other is a survivor; `explained.toml` must say why it does no harm.

What is found out is kept at once (`record.py`): a run that is interrupted goes on where it stopped.
The outcome is written to docs/mutants.csv (all) and docs/mutants.md (summary and survivors).
"""
