def run(args):
    raise SystemExit(1)
