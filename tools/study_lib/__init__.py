"""tools/study: sweeps names what is rendered, processes and renderers run it, ledger remembers it, statistics, report,
plots and page say what came out. peers runs other renderers."""
from crosscheck_lib import BadInput

__all__ = ["BadInput"]
