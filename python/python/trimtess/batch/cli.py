"""The program `trimtess-batch`: arguments -> exit status.

0 every file is whole; 3 all files have their row, but some are not whole; 1 the run cannot go on; 2 wrong usage;
130 and 143 stopped by SIGINT or SIGTERM.
"""

from __future__ import annotations

import argparse
import math
import sys
from typing import List, Optional, Tuple

import trimtess

from .errors import CANNOT, PARTIAL, USAGE, WHOLE, BatchError
from .options import FORMATS, Options


def positive(text: str) -> float:
    number = float(text)
    if not (math.isfinite(number) and number > 0):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return number


def count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not at least 1")
    return number


def count_or_zero(text: str) -> int:
    number = int(text)
    if number < 0:
        raise argparse.ArgumentTypeError(f"{text} is negative")
    return number


def formats(text: str) -> Tuple[str, ...]:
    names = [name.strip() for name in text.split(",")]
    unknown = [name for name in names if name not in FORMATS]
    if unknown:
        raise argparse.ArgumentTypeError(f"{unknown[0]!r} is none of {', '.join(FORMATS)}")
    return tuple(sorted(set(names)))


def size(text: str) -> Tuple[int, int]:
    sides = text.split("x")
    if len(sides) != 2 or not all(side.isdigit() and 0 < int(side) <= 16384 for side in sides):
        raise argparse.ArgumentTypeError(f"{text} is not WIDTHxHEIGHT, like 800x600")
    return int(sides[0]), int(sides[1])


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(prog="trimtess-batch", description=__doc__.splitlines()[0])
    top.add_argument("--version", action="version", version=f"trimtess-batch {trimtess.__version__}")
    commands = top.add_subparsers(dest="command", required=True)
    add_convert(commands.add_parser("convert", help="convert files to meshes, on this machine or on a Ray cluster"))
    report = commands.add_parser("report", help="print and plot what a catalogue holds")
    report.add_argument("catalogue", help="the catalogue's folder, or the output folder that has it")
    report.add_argument("--plot", metavar="OUT.png", help="write plots, as PNG, SVG or PDF")
    report.add_argument("--top", type=count, default=10, metavar="N", help="files per list (default: %(default)s)")
    return top


def add_convert(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "sources",
        nargs="+",
        metavar="SOURCE",
        help="file, folder, glob, URL (s3://, gs://, file://), or a manifest: CSV or Parquet with a column `path`",
    )
    command.add_argument("--out", required=True, metavar="FOLDER", help="output folder, seen by all workers")
    command.add_argument("--formats", type=formats, default=("glb",), help=f"of {','.join(FORMATS)} (default: glb)")
    chord = command.add_mutually_exclusive_group()
    chord.add_argument("--chord", type=positive, metavar="MM", help="largest distance to the surface, millimetres")
    chord.add_argument("--chord-rel", type=positive, metavar="F", help="as a fraction of the diagonal (default: 1e-3)")
    command.add_argument("--angle", type=positive, default=20.0, metavar="DEG", help="(default: %(default)s)")
    command.add_argument("--max-edge", type=positive, metavar="MM", help="longest cell diagonal and edge segment")
    command.add_argument("--recenter", action="store_true", help="move the centre of each scene to the origin")
    command.add_argument("--supplemental", action="store_true", help="read supplemental geometry too")
    command.add_argument(
        "--size", type=size, default=Options.size, metavar="WxH", help="of pictures (default: 800x600)"
    )
    run = command.add_argument_group("where and how")
    run.add_argument("--address", help="a Ray cluster: ray://HOST:PORT, HOST:PORT or auto (default: start Ray here)")
    run.add_argument("--cores", type=count, metavar="N", help="cores of the Ray that is started here (default: all)")
    run.add_argument("--max-memory", type=count, metavar="MIB", help="of one file (default: 4096, or the node's)")
    run.add_argument("--time-limit", type=positive, default=600.0, metavar="S", help="of one file (default: 600)")
    run.add_argument("--retries", type=count_or_zero, default=2, metavar="N", help="after a failure (default: 2)")
    run.add_argument("--large", type=count, default=64, metavar="MIB", help="size that adds a core (default: 64)")
    run.add_argument("--retry-failed", action="store_true", help="try files again whose row is a passing failure")
    run.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")


def run_convert(args: argparse.Namespace) -> int:
    # Imported here: wrong usage is told without them, and without the extra.
    from . import drive
    from .plan import MIB

    chord_rel = None if args.chord else args.chord_rel or Options.chord_rel
    options = Options(
        args.chord, chord_rel, args.angle, args.max_edge, args.formats, args.size, args.recenter, args.supplemental
    )
    settings = drive.Settings(
        address=args.address,
        cores=args.cores,
        max_memory=args.max_memory and args.max_memory * MIB,
        seconds=args.time_limit,
        retries=args.retries,
        large=args.large * MIB,
        retry_failed=args.retry_failed,
        quiet=args.quiet,
    )
    summary = drive.convert(args.sources, args.out, options, settings)
    if not args.quiet:
        from .report import summary_line

        print(summary_line(summary))
    return WHOLE if set(summary.statuses) <= {"whole"} else PARTIAL


def run_report(args: argparse.Namespace) -> int:
    from . import catalogue, report

    head, table = catalogue.read(args.catalogue)
    print(report.text(head, table, args.top), end="")
    if args.plot:
        from .plots import plot

        plot(table, args.plot)
    return WHOLE


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the program. Returns its exit status."""
    try:
        args = parser().parse_args(arguments)
    except SystemExit as wrong:
        return USAGE if wrong.code else WHOLE
    try:
        return run_convert(args) if args.command == "convert" else run_report(args)
    except BatchError as error:
        print(f"trimtess-batch: {error}", file=sys.stderr)
        return error.status
    except KeyboardInterrupt:
        print("trimtess-batch: stopped", file=sys.stderr)
        return 130
    except ImportError as error:
        print(f"trimtess-batch: {error}; pip install 'trimtess[batch]'", file=sys.stderr)
        return CANNOT


if __name__ == "__main__":
    sys.exit(main())
