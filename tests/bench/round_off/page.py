"""The page docs/round_off.md from its tables."""


def write_page(growth, cost, prose, page):
    """Stub."""
