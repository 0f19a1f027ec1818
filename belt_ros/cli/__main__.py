"""`python -m belt_ros.cli`."""

from belt_ros.cli import main

if __name__ == "__main__":
    main()
