#!/usr/bin/env python3
"""What `linkwright fit TARGET` puts first, before and after a change, as the table of docs/benchmarks.md.

    tests/bench/first_answers.py [--before PROGRAM] [--time S] PROGRAM TARGET... > table.md

Each program fits each target with its defaults.  Stray is the greatest distance between curve and target [mm], both ways
where the program tells it; sizes are measured here, in the linkage: the longest distance of two joints, or of a joint and
the tracer, of one link, over the diagonal of the target.  A target may carry options: "line.csv --tolerance 1mm".
"""
import argparse
import json
import math
import os
import shlex
import subprocess
import sys
import time


def size(linkage):
    """Longest distance between two points of one link, in the unit of the linkage: that of the target."""
    points = {}
    for joint in linkage["joints"]:
        for link in joint["links"]:
            points.setdefault(link, []).append(joint["at"])
    most = 0
    for k, tracer in enumerate(linkage.get("tracers", [])):
        if k == 0:
            most = max([math.dist(tracer["at"], at) for at in points.get(tracer["link"], [])] + [0])
    return max([math.dist(a, b) for each in points.values() for a in each for b in each] + [most])


def first(program, target, limit):
    """The first answer as a dict, and the seconds."""
    words = shlex.split(target)
    begin = time.time()
    run = subprocess.run([program, "fit", *words, "--json", "--quiet", "--time", str(limit)], capture_output=True, text=True)
    seconds = time.time() - begin
    try:
        results = json.loads(run.stdout)["results"]
    except (ValueError, KeyError):
        results = []
    return (results[0] if results else None), seconds


def cell(result, diagonal_mm):
    """Stray, motion of the input, transmission angle, size."""
    if result is None:
        return "none"
    angle = result.get("transmission_min")
    text = []
    if result.get("error_max") is not None:
        known = [result[k] for k in ("stray", "error_curve", "error_max") if result.get(k) is not None]
        text.append("%.2g" % (known[0] if result.get("stray") is not None else max(known)))
    if result.get("angle_error_max") is not None:
        text.append("%.2g deg" % math.degrees(result["angle_error_max"]))
    text.append(result.get("input_motion") or ("turns" if result["crank"] else "rocks"))
    text.append("%.0f deg" % math.degrees(angle) if angle is not None else "-")
    if diagonal_mm and result.get("error_max") is not None:
        text.append("%.2g" % (size(result["linkage"])/diagonal_mm))
    return ", ".join(text)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--before", help="an older program")
    options.add_argument("--time", type=float, default=30, help="limit of each fit [s]")
    options.add_argument("program")
    options.add_argument("target", nargs="+")
    o = options.parse_args()
    print("| target | " + ("before: stray [mm] or angle, input, transmission, size | s | " if o.before else "")
          + "stray [mm] or angle, input, transmission, size | s |\n|---|---|---|" + ("---|---|" if o.before else ""))
    for target in o.target:
        now, seconds = first(o.program, target, o.time)
        mm = now["size"]/now["size_over_path"] if now and now.get("size_over_path") else None
        name = os.path.splitext(os.path.basename(target.split()[0]))[0] + " ".join([""] + target.split()[1:])
        row = "| %s |" % name
        if o.before:
            plain = shlex.split(target)[0]                 # an older program may not know the options
            old, old_seconds = first(o.before, plain, o.time)
            row += " %s | %.1f |" % (cell(old, mm), old_seconds)
        print(row + " %s | %.1f |" % (cell(now, mm), seconds))
        sys.stdout.flush()


if __name__ == "__main__":
    main()
