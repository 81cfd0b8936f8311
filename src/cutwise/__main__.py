"""``python -m cutwise``: the command line without the installed script."""

from cutwise.app.cli import main

if __name__ == "__main__":
    main()
