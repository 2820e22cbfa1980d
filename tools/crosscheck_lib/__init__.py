"""tools/crosscheck: ztest holds the statistics, renderers the two programs, pictures the files."""


class BadInput(Exception):
    """One line for the user: what was found, what was expected."""
