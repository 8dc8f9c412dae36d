#!/usr/bin/env python3
"""Start `PROGRAM studio`, ask it questions, end it by SIGINT, and print what it answered (tests/test_cli_faults.c).

Exit code 4, with a message, if the studio says that it failed in an answer; its own if it ends by itself."""
import hashlib, http.client, json, re, signal, subprocess, sys
from urllib.parse import urlparse

FOURBAR = json.load(open("examples/chebyshev.json"))
QUESTIONS = [("GET", "", None), ("GET", "main.js", None), ("POST", "begin", {}),
             ("POST", "motion", {"linkage": FOURBAR, "points": 50}), ("POST", "analyse", {"linkage": FOURBAR}),
             ("POST", "mobility", {"linkage": FOURBAR}), ("POST", "chains", {"links": 4}),
             ("POST", "open", {"name": "a.csv", "text": "x,y\n0,0\n1,0\n1,1\n"}),
             ("POST", "export", {"format": "dxf", "linkage": FOURBAR}), ("POST", "gallery", {"name": "klann"}),
             ("POST", "forces", {"linkage": FOURBAR, "speed": 1, "seconds": 0.1}),
             ("POST", "nearest", {"x": [0, 1, 2, 2, 1], "y": [0, 0, 0.5, 1, 1]}),
             ("POST", "target", {"name": "d.csv", "unit": "mm", "force_unit": True, "stations": 9, "closed": True,
                                 "text": "x,y\n0,0\n10,0\n10,10\n0,10\n"})]

studio = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE)
address = studio.stdout.readline().decode()
if not address:
    sys.exit(studio.wait())
base = urlparse(address.strip())
failed = None
for method, path, body in QUESTIONS:
    try:
        link = http.client.HTTPConnection(base.hostname, base.port, timeout=20)
        link.request(method, base.path + ("api/" if method == "POST" else "") + path, json.dumps(body) if method == "POST" else None,
                     {"Content-Type": "application/json"})
        answer = link.getresponse()
        text = answer.read()
    except (OSError, http.client.HTTPException) as error:
        failed = "%s: %s" % (path, error)
        continue
    if answer.status != 200:
        failed = "%s: %s" % (path, text[:100])
    print(path, answer.status, hashlib.md5(re.sub(rb'"ms":[^,}]*', b"", text)).hexdigest())
studio.send_signal(signal.SIGINT)
code = studio.wait()
if code != 130:
    print("ended with", code)
    sys.exit(code or 1)
elif failed:
    print("linkwright studio:", failed, file=sys.stderr)
    sys.exit(4)
