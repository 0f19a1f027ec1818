"""The `belt` command. What a command needs is imported when it runs, so that help comes at once."""

from belt_ros.cli import bags, describing, live
from belt_ros.cli.app import app

__all__ = ["app", "bags", "describing", "live", "main"]


def main() -> None:
    """Run the `belt` command."""
    app()
