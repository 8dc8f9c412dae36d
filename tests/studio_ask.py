#!/usr/bin/env -S python3 -IS
"""Start `PROGRAM studio`, ask it questions, end it by SIGINT, and print what it answered (tests/test_cli_faults.c).

Exit code 4, with a message, if the studio says that it failed in an answer; its own if it ends by itself.  No module that takes
long to load: the faults start it a hundred times."""
import os, signal, socket, sys, zlib

FOURBAR = open("examples/chebyshev.json").read()
QUESTIONS = [("GET", "", ""), ("GET", "main.js", ""), ("POST", "begin", "{}"),
             ("POST", "motion", '{"linkage": %s, "points": 50}' % FOURBAR), ("POST", "analyse", '{"linkage": %s}' % FOURBAR),
             ("POST", "mobility", '{"linkage": %s}' % FOURBAR), ("POST", "chains", '{"links": 4}'),
             ("POST", "open", r'{"name": "a.csv", "text": "x,y\n0,0\n1,0\n1,1\n"}'),
             ("POST", "export", '{"format": "dxf", "linkage": %s}' % FOURBAR), ("POST", "gallery", '{"name": "klann"}'),
             ("POST", "forces", '{"linkage": %s, "speed": 1, "seconds": 0.1}' % FOURBAR),
             ("POST", "nearest", '{"x": [0, 1, 2, 2, 1], "y": [0, 0, 0.5, 1, 1]}'),
             ("POST", "target", r'{"name": "d.csv", "unit": "mm", "force_unit": true, "stations": 9, "closed": true, '
                                r'"text": "x,y\n0,0\n10,0\n10,10\n0,10\n"}')]


def ask(host, method, path, body):
    """The status and the text of the answer, without the milliseconds that it took."""
    name, port = host.split(":")
    with socket.create_connection((name, int(port)), 20) as link:
        link.sendall(("%s %s HTTP/1.1\r\nHost: %s\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: %d\r\n\r\n%s"
                      % (method, path, host, len(body.encode()), body)).encode())
        head, _, text = b"".join(iter(lambda: link.recv(1 << 16), b"")).partition(b"\r\n\r\n")
    before, taken, after = text.partition(b'"ms":')
    size = dict(line.lower().split(b": ", 1) for line in head.split(b"\r\n")[1:])[b"content-length"]
    if len(text) != int(size):
        raise OSError("%d of %d bytes" % (len(text), int(size)))
    return int(head.split()[1]), before + after.lstrip(b"0123456789.e+-") if taken else text


read, write = os.pipe()
studio = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, write, 1)])
os.close(write)
address = open(read).readline().strip()
if not address:
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(studio, 0)[1]))
host, token = address.removeprefix("http://").split("/", 1)
failed = None
for method, path, body in QUESTIONS:
    try:
        status, text = ask(host, method, "/" + token + ("api/" if method == "POST" else "") + path, body)
    except (OSError, ValueError, KeyError, IndexError) as error:
        failed = "%s: %s" % (path, error)
        continue
    if status != 200:
        failed = "%s: %s" % (path, text[:100])
    print(path, status, "%08x" % zlib.crc32(text))
os.kill(studio, signal.SIGINT)
code = os.waitstatus_to_exitcode(os.waitpid(studio, 0)[1])
if code != 130:
    print("ended with", code)
    sys.exit(code or 1)
elif failed:
    print("linkwright studio:", failed, file=sys.stderr)
    sys.exit(4)
