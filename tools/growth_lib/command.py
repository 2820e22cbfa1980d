"""How time grows with pixels, records, triangles and threads, and how long a start takes.

  tools/growth -o DIR [--only pixels records triangles start scaling octree] [options]

Writes NAME.csv (every run's figures), NAME.svg and NAME.png of each measurement into DIR, and prints the exponents e of
time = c size^e as Markdown tables: fitted to all sizes, and of the two largest, where fixed costs matter least.

  pixels     scenes/cornell-box.xml from 256x256 to 2048x2048, 4 samples a pixel, cached and path traced
  records    10^3 to 10^6 of them in a picture of fixed size (--width), by their spacing, with hemispheres of 4x8
  triangles  10^2 to 10^7 in a terrain (tools/make-terrain): loading, hierarchy and rendering apart
  start      from the command to a picture of one sample: with kernels of the build alone, cold (none compiled) and warm
  scaling    one thread against two, in turns
  octree     one look-up among 10^3 to 10^6 records, one insertion to 3 10^6 (the benchmark's; no GPU machine needs it)

Times of `render` are wall times without program start and compilation, the least of --repeat runs; one more goes before
them and compiles the kernels. On a machine that others use, --repeat 5. On machines with nothing but a compiler (-DIRRADIA_MINIMAL=ON)
there is no XML reader: pack the scenes elsewhere (render SCENE --pack FILE) and run `render --stats` by hand: hemisphere
rays a second are rays.hemisphere / stages.sample_hemispheres.seconds.
"""
import argparse
import os
import sys
import tempfile

from . import measure, report


def parse(argv):
    parser = argparse.ArgumentParser(prog="tools/growth", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--out", required=True, metavar="DIR", help="where CSV files and plots go")
    parser.add_argument("--only", nargs="+", choices=list(measure.ALL), default=list(measure.ALL), metavar="NAME",
                        help="measure these alone, of: " + ", ".join(measure.ALL))
    parser.add_argument("--sizes", metavar="A,B,...", help="instead of the default ones, with one --only: " + "; ".join(
        f"{name}: {what} ({','.join(map(str, sizes))})" for name, (_, sizes, what) in measure.ALL.items()))
    parser.add_argument("--device", metavar="SELECT", help="OpenCL device, as `render --device` takes it")
    parser.add_argument("--threads", type=int, default=0, help="of CPU devices; 0: all")
    parser.add_argument("--repeat", type=int, default=1, help="runs of each size; the quickest counts")
    parser.add_argument("--width", type=int, default=2048, help="records: edge of the picture")
    parser.add_argument("--render", default=os.path.join(measure.ROOT, "build", "bin", "render"))
    parser.add_argument("--bench", default=os.path.join(measure.ROOT, "build", "bench", "irradia_bench"))
    args = parser.parse_args(argv)
    args.given_sizes = None
    if args.sizes is not None:
        if len(args.only) != 1:
            parser.error("--sizes: belongs to one measurement, give one --only")
        try:
            args.given_sizes = [int(float(x)) for x in args.sizes.split(",")]
        except (ValueError, OverflowError):
            parser.error(f"--sizes {args.sizes}: numbers were expected, as in 1000,10000")
        if min(args.given_sizes) < 1:
            parser.error(f"--sizes {args.sizes}: positive numbers were expected")
    for name in ("repeat", "width"):
        if getattr(args, name) < 1:
            parser.error(f"--{name} {getattr(args, name)}: a positive number was expected")
    return args


def main(argv):
    args = parse(argv)
    try:
        os.makedirs(args.out, exist_ok=True)
        for name in args.only:
            run, sizes, _ = measure.ALL[name]
            with tempfile.TemporaryDirectory() as folder:
                rows = run(measure.Renderer(args, folder), args.given_sizes or sizes, args.out)
            report.write_csv(os.path.join(args.out, name + ".csv"), rows)
    except (OSError, RuntimeError, ValueError, measure.subprocess.CalledProcessError) as e:
        print(f"growth: {e}", file=sys.stderr)
        return 1
    return 0
