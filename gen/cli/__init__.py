"""The command `smidgen`."""


def main() -> int:
    """Placeholder until the sub-commands are in."""
    print("smidgen", __import__("smidgen").__version__)
    return 0
