"""Branch coverage of the C runtime, measured by gcov over the tests (make coverage).

Every header of runtime/ is compiled into many programs: into each generated model that the tests
build, and into the test programs of tests/runtime. A shim for `gcc` and `cc` compiles all of them
without optimisation, with counters, and with every inline function kept as a function of its own,
so that one that nobody calls is seen too. The counts of all programs are added up by header, line
and branch. What no test takes is listed in docs/coverage.md with its reason (`reasons.toml`).
"""
