"""Entry point of the installed command `isimp`. It loads almost nothing before it can handle Ctrl-C."""


def main() -> int:
    """Run the command; returns its exit status. The engine detects this module and sets up its process as a command."""
    from isimp_engine.cli import main as run

    return run()
