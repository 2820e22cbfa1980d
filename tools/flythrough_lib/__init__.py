"""tools/flythrough: runs renders the flight in several ways, flicker compares neighbouring frames point by point,
report writes what came out."""
from crosscheck_lib import BadInput

__all__ = ["BadInput"]
