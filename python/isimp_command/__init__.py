"""The command `isimp` as it is installed: so small that next to nothing is loaded before Ctrl-C is taken care of."""


def main() -> int:
    """Run the command; returns its exit status. The engine sees that this module is there, and acts as a command."""
    from isimp_engine.cli import main as run

    return run()
