#!/usr/bin/env python3
"""What `linkwright fit TARGET` puts first, before and after a change, as the table of docs/benchmarks.md.

    tests/bench/first_answers.py [--before PROGRAM] PROGRAM TARGET... > table.md
    tests/bench/first_answers.py --shapes FOLDER           writes targets that docs/benchmarks.md names

Each program fits each target with its defaults.  Stray is the greatest distance between curve and target [mm], both ways
where the program tells it; sizes are measured here, in the linkage: the longest distance of two joints, or of a joint and
the tracer, of one link, over the diagonal of the target.  Seconds are processor seconds of all threads.  A target may carry
options: "line.csv --tolerance 1mm".
"""
import argparse
import json
import math
import os
import resource
import shlex
import subprocess
import sys


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


def processor_seconds():
    """Of all programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def first(program, target):
    """The first answer as a dict, and the seconds."""
    begin = processor_seconds()
    run = subprocess.run([program, "fit", *shlex.split(target), "--json", "--quiet"], capture_output=True, text=True)
    seconds = processor_seconds() - begin
    try:
        results = json.loads(run.stdout)["results"]
    except (ValueError, KeyError):
        results = []
    return (results[0] if results else None), seconds


def cell(result, diagonal_mm):
    """Stray, links, motion of the input, transmission angle, size."""
    if result is None:
        return "none"
    angle = result.get("transmission_min")
    text = []
    if result.get("error_max") is not None:
        known = [result[k] for k in ("stray", "error_curve", "error_max") if result.get(k) is not None]
        text.append("%.2g" % (known[0] if result.get("stray") is not None else max(known)))
    if result.get("angle_error_max") is not None:
        text.append("%.2g deg" % math.degrees(result["angle_error_max"]))
    if result.get("links"):
        text.append("%d links" % result["links"])
    text.append(result.get("input_motion") or ("turns" if result["crank"] else "rocks"))
    text.append("%.0f deg" % math.degrees(angle) if angle is not None else "-")
    if diagonal_mm and result.get("error_max") is not None:
        text.append("%.2g" % (size(result["linkage"])/diagonal_mm))
    return ", ".join(text)


def shapes(folder):
    """Targets by formula, in mm and degrees."""
    def turn(n):
        return (2*math.pi*k/n for k in range(n))

    def corner(k, t):
        return (80*(1 if k in (0, 3) else -1) + 20*math.cos(t), 10*(1 if k < 2 else -1) + 20*math.sin(t))
    arc = [math.radians(30 + 120*k/17) for k in range(18)]
    targets = {
        "dee": [(-100 + 12.5*k, 0) for k in range(17)] + [(100*math.cos(math.pi*k/16), 60*math.sin(math.pi*k/16))
                                                         for k in range(1, 16)],
        "roundrect": [corner(k, math.radians(90*k + 18*i)) for k in range(4) for i in range(6)],
        "banana": [(120*math.cos(t), 120*math.sin(t)) for t in arc]
                  + [((120 - 35*math.sin(math.pi*k/17))*math.cos(arc[17 - k]),
                      (120 - 35*math.sin(math.pi*k/17))*math.sin(arc[17 - k])) for k in range(1, 17)],
        "teardrop": [(80*math.cos(t), 40*math.sin(t)*math.sin(t/2)**1.5) for t in turn(36)],
        "circle": [(40*math.cos(t), 40*math.sin(t)) for t in turn(24)],
        "trainer": [(200*math.cos(t)*math.cos(.2) - 70*math.sin(t)*math.sin(.2)*(1 + .3*math.cos(t)),
                     200*math.cos(t)*math.sin(.2) + 70*math.sin(t)*math.cos(.2)*(1 + .3*math.cos(t))) for t in turn(36)],
        "triangle": [(60*math.cos(t) + 14*math.cos(2*t), 60*math.sin(t) - 14*math.sin(2*t)) for t in turn(36)],
        "takeup": [(30*math.sin(t) + 6*math.sin(2*t), 60*math.cos(t) - 10*math.cos(2*t)) for t in turn(24)],
        "lift": [(0, 12.5*k) for k in range(8)]
                + [(50 - 50*math.cos(math.pi*k/12), 100 + 50*math.sin(math.pi*k/12)) for k in range(7)]
                + [(50 + 100*k/6, 150) for k in range(1, 7)],
        "rake": [(-150 + 300*k/14, 0) for k in range(15)]
                + [(150 + 30*math.sin(math.pi*k/8), 30 - 30*math.cos(math.pi*k/8)) for k in range(1, 5)],
        "flap": [(0, 0, 0), (60, 40, -20), (120, 120, -45), (130, 220, -75), (110, 300, -95)],
        "garage": [(0, 0, 90), (100, 500, 72), (220, 1100, 50), (320, 1600, 28), (350, 1950, 8), (300, 2080, 0)],
    }
    for name, rows in targets.items():
        with open(os.path.join(folder, name + ".csv"), "w") as f:
            f.write("# units: mm deg\n# closed: %s\nx,y%s\n" % ("no" if name in ("lift", "rake", "flap", "garage") else "yes",
                                                               ",theta" if len(rows[0]) > 2 else ""))
            for row in rows:
                f.write(",".join("%.5g" % v for v in row) + "\n")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--before", help="an older program")
    options.add_argument("--shapes", metavar="FOLDER", help="write targets into this folder")
    options.add_argument("program", nargs="?")
    options.add_argument("target", nargs="*")
    o = options.parse_args()
    if o.shapes:
        return shapes(o.shapes)
    print("| target | " + ("before: stray [mm] or angle, links, input, transmission, size | s | " if o.before else "")
          + "stray [mm] or angle, links, input, transmission, size | s |\n|---|---|---|" + ("---|---|" if o.before else ""))
    for target in o.target:
        now, seconds = first(o.program, target)
        mm = now["size"]/now["size_over_path"] if now and now.get("size_over_path") else None
        name = os.path.splitext(os.path.basename(target.split()[0]))[0] + " ".join([""] + target.split()[1:])
        row = "| %s |" % name
        if o.before:
            plain = shlex.split(target)[0]                 # an older program may not know the options
            old, old_seconds = first(o.before, plain)
            row += " %s | %.1f |" % (cell(old, mm), old_seconds)
        print(row + " %s | %.1f |" % (cell(now, mm), seconds))
        sys.stdout.flush()


if __name__ == "__main__":
    main()
