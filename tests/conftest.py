"""Settings that every test shares."""

import os

import pytest
from hypothesis import HealthCheck, settings

# The first example of a property pays for loading its arm: neither a deadline nor "too slow" means anything then.
_SHARED = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("ci", derandomize=True, **_SHARED)
settings.register_profile("explore", max_examples=2000, **_SHARED)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# The files that take longest, each in one process: they come first, so that tests in parallel end together.
_LONGEST = ("test_wheel.py", "test_viewer_browser.py")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest files first."""
    items.sort(key=lambda item: item.path.name not in _LONGEST)
