"""Each test draws and measures from made-up data what it did before (`support/fingerprint.py`)."""

import pytest

import fingerprint


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """Compare what a test has seen, if it passes otherwise."""
    with fingerprint.of_test(item.nodeid) as check:
        outcome = yield
        check()
    return outcome


def pytest_sessionfinish():
    fingerprint.write()
