#!/usr/bin/env python3
"""Are curves that a Watt I or a Stephenson III drew found exactly?  Draws linkages of random proportions whose crank turns,
fits the untimed curve of each, and prints the greatest error of the best result over the size of the curve.

usage: drawn_curves.py PROGRAM [--count N] [--seed S] [--only I] [OPTIONS of fit ...]
       (default options: --unlimited --links 6 --time 60)"""
import cmath, json, math, random, subprocess, sys, tempfile

STATIONS = 60


def meet(a, ra, b, rb, mode):
    """The point at the distances ra of a and rb of b, or None; complex numbers."""
    d = abs(b - a)
    if d == 0 or d > 0.97*(ra + rb) or d < 1.05*abs(ra - rb):
        return None
    x = (ra*ra - rb*rb + d*d)/(2*d)
    return a + (b - a)/d*complex(x, mode*math.sqrt(ra*ra - x*x))


def curve(rng, kind):
    """60 points of the point of a random linkage, or None if its crank does not turn."""
    u, c = rng.uniform, lambda r: complex(rng.uniform(-r, r), rng.uniform(-r, r))
    crank, coupler, rocker, ground = u(0.2, 0.45), u(0.7, 1.3), u(0.7, 1.3), u(0.8, 1.3)
    on_coupler, on_rocker, pivot = c(1), c(1), complex(ground/2, 0) + c(1.5)
    first, second, arm, modes = u(0.6, 1.6), u(0.6, 1.6), c(1), [rng.choice((-1, 1)) for _ in range(2)]
    points = []
    for k in range(STATIONS):
        a = cmath.rect(crank, 2*math.pi*k/STATIONS)
        b = meet(a, coupler, ground, rocker, modes[0])
        if b is None:
            return None
        q = a + on_coupler*(b - a)/coupler
        to = pivot if kind == "stephenson3" else ground + on_rocker*(b - ground)/rocker
        d = meet(q, first, to, second, modes[1])
        if d is None:
            return None
        points.append(q + arm*(d - q)/first)
    return points


def main(arguments):
    program, count, seed, only = arguments[0], 10, 1, None
    rest = arguments[1:]
    while rest and rest[0] in ("--count", "--seed", "--only"):
        count, seed, only = (int(rest[1]) if rest[0] == name else now
                             for name, now in (("--count", count), ("--seed", seed), ("--only", only)))
        rest = rest[2:]
    options = rest or ["--unlimited", "--links", "6", "--time", "60"]
    rng, found, tried = random.Random(seed), 0, 0
    for i in range(count):
        kind = ("watt1", "stephenson3")[i % 2]
        points = None
        while points is None:
            points = curve(rng, kind)
        if only not in (None, i):
            continue
        xs, ys = [p.real for p in points], [p.imag for p in points]
        size = math.hypot(max(xs) - min(xs), max(ys) - min(ys))
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as target:
            target.write("# closed\nx [m],y [m]\n" + "".join("%.17g,%.17g\n" % (p.real, p.imag) for p in points))
            target.flush()
            run = subprocess.run([program, "fit", target.name, "--closed", "--topology", kind, "--json", "--quiet"] + options,
                                 capture_output=True, text=True)
        if run.returncode not in (0, 5):                 # 5: ended by --time
            print(i, kind, run.stderr.strip())
            continue
        answer = json.loads(run.stdout)
        best = min(answer["results"], key=lambda r: r["error_max"])
        tried, found = tried + 1, found + (best["error_max"] <= 1e-9*size)
        print(f"{i} {kind}: {best['error_max']/size:.2e} ({best['type']}), {answer['evaluations']} evaluations, "
              f"{answer['seconds']:.1f} s", flush=True)
    print(f"{found} of {tried} within 1e-9")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
