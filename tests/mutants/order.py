"""A plugin of pytest: the tests of a list, in its order, each with a limit; what happens is written down at once.

$MUTANT_ORDER names a JSON file {test: seconds it may take}; without it, every test that counts runs
in the order of the files. $MUTANT_LOG receives a line of JSON when a test begins and when it ends.
"""
import faulthandler
import json
import os
import re

FREE = 300.0        # limit of a test that is run for the first time, seconds

# Tests that say nothing about a fault: they compare text, only compile it, or plant faults of their own.
TEXT = re.compile(r"golden|mutants_are_caught|test_determinism|compiles?_clean|clean_c\b|free_of_warnings|without_a_warning"
                  r"|no_compiler_(complains|warns)|have_nothing_to_say|headers_compile_alone|compiles_for_ranks")


def listed():
    name = os.environ.get("MUTANT_ORDER")
    return json.loads(open(name).read()) if name else None


def note(**what):
    with open(os.environ["MUTANT_LOG"], "a") as log:
        log.write(json.dumps(what) + "\n")


def pytest_collection_modifyitems(config, items):
    wanted = listed()
    by_name = {item.nodeid: item for item in items if not TEXT.search(item.nodeid)}
    chosen = list(by_name.values()) if wanted is None else [by_name[n] for n in wanted if n in by_name]
    items[:] = chosen
    config.limits = wanted or {}


def pytest_runtest_logstart(nodeid, location):
    note(begins=nodeid)


def pytest_runtest_setup(item):
    item.user_properties.append(("quick", item.get_closest_marker("quick") is not None))
    faulthandler.dump_traceback_later(item.config.limits.get(item.nodeid, FREE), exit=True)


def pytest_runtest_logreport(report):
    if report.when == "teardown":
        faulthandler.cancel_dump_traceback_later()
    if report.when == "call" or report.outcome != "passed":
        note(ends=report.nodeid, outcome=report.outcome, seconds=report.duration, when=report.when,
             quick=dict(report.user_properties).get("quick", False))
