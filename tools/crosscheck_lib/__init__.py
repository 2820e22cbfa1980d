"""tools/crosscheck: ztest holds the statistics, renderers the two programs, pictures the files."""


class BadInput(Exception):
    """One line for the user: what was found, what was expected."""


MITSUBA = "3.9.1"  # what is installed from PyPI, for tools/study too
