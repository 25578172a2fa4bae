#!/usr/bin/env python3
"""Hostile requests to the page of raygrid-camera, for --seconds: mutants of good requests, whole, in
pieces and cut off. None without the token is answered. The page answers good requests after each
round, keeps its memory, and ends in order."""
import argparse
import os
import random
import signal
import socket
import subprocess
import tempfile
import time

# Statuses that a request of any kind may get; None: the connection is closed without an answer.
ALLOWED = {200, 303, 400, 401, 404, 405, 408, 411, 413, 414, 421, 431, 501, 503, 505, None}
MAX_GROWTH_KB = 16 * 1024
TOKEN = "0123456789abcdef-fuzz"


def good_requests(port):
    host = f"Host: localhost:{port}"
    return [f"GET {path} HTTP/1.1\r\n{fields}\r\n\r\n".encode() for path, fields in (
        ("/", host),
        (f"/?token={TOKEN}", host),
        ("/before", f"{host}\r\nAuthorization: Bearer {TOKEN}"),
        ("/after", f"{host}\r\nCookie: a=b; raygrid_{port}={TOKEN}"),
        ("/", f"{host}\r\nContent-Length: 5\r\nConnection: close\r\n\r\nhello"),
        ("/", f"{host}\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0"),
        ("/%2e%2e/%00?token=%41&token=&=&&", f"{host}\r\nExpect: 100-continue"))]


PARTS = [b"\r\n", b"\n", b"\r", b"\0", b" ", b":", b"/", b"?", b"%", b"%00", b"\xff" * 9, b"A" * 20000,
         b"HTTP/1.1", b"HTTP/9.9", b"Host: localhost\r\n", b"Content-Length: -1\r\n",
         b"Content-Length: 99999999999999999999\r\n", b"Transfer-Encoding: chunked\r\n",
         b"Cookie: " + b"a=b;" * 2000 + b"\r\n", b"Cookie: =;=;\"\r\n", b"\r\n ffffffffffffffff\r\n",
         b"Connection: upgrade\r\n", b"Range: bytes=0-\r\n", b"Authorization: Bearer \r\n"]


def mutant(rng, request):
    request = bytearray(request)
    for _ in range(rng.choice((1, 1, 2, 3, 8))):
        at = rng.randrange(len(request) + 1)
        kind = rng.randrange(5)
        if kind == 0:
            request[at:at] = rng.choice(PARTS)
        elif kind == 1:
            del request[at:at + rng.choice((1, 2, 10))]
        elif kind == 2 and at < len(request):
            request[at] = rng.randrange(256)
        elif kind == 3:
            request[at:at] = request[rng.randrange(len(request) + 1):][:rng.choice((3, 40))]
        else:
            del request[at:]
    return bytes(request)


def status_of(connection):
    try:
        answer = connection.recv(64)
    except (TimeoutError, OSError):
        return None
    parts = answer.split(b" ", 2)
    return int(parts[1]) if answer.startswith(b"HTTP/1.") and parts[1:] else None


def send(rng, port, request):
    """The status of the answer; now and then, the request comes in pieces or nobody listens."""
    with socket.create_connection(("127.0.0.1", port), timeout=5) as connection:
        connection.settimeout(0.05)
        try:
            cut = rng.randrange(len(request) + 1) if rng.random() < 0.2 else len(request)
            connection.sendall(request[:cut])
            if rng.random() < 0.2:
                return None
            connection.sendall(request[cut:])
        except OSError:
            return None
        return status_of(connection)


def memory_kb(process):
    with open(f"/proc/{process.pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS:"))


def start(arguments, folder):
    run = [arguments.raygrid, "simulate", "--images", "1", "--lens", "wide", "--size", "160x120",
           "-o", "scene"], [arguments.raygrid, "pack", "scene/true_camera.yaml", "-o",
                            "flat.raygrid", "--remap", "160x120,hfov=80"]
    for command in run:
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    for name, contents in (("frames.yuyv", bytes(range(256)) * 150), ("token", TOKEN.encode())):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(contents)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    # pylint: disable=consider-using-with
    # Of what was freed, the sanitizer keeps 4 MB, not 256.
    options = ":".join(filter(None, (os.environ.get("ASAN_OPTIONS"), "quarantine_size_mb=4")))
    process = subprocess.Popen(
        [arguments.camera, "flat.raygrid", "--from", "frames.yuyv", "--format", "YUYV", "--quiet",
         "--http", str(port), "--token-file", "token"],
        cwd=folder, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
        env={**os.environ, "ASAN_OPTIONS": options})
    return process, port


def is_served(port):
    """A good request gets the page, if not at once: others may have all places for a while."""
    request = good_requests(port)[0].replace(
        b"\r\n\r\n", f"\r\nAuthorization: Bearer {TOKEN}\r\nConnection: close\r\n\r\n".encode())
    end = time.monotonic() + 30
    while time.monotonic() < end:
        try:
            with socket.create_connection(("127.0.0.1", port), timeout=5) as connection:
                connection.sendall(request)
                if status_of(connection) == 200:
                    return True
        except OSError:
            pass
        time.sleep(0.1)
    return False


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--raygrid", required=True)
    parser.add_argument("--camera", required=True)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    counts, first_kb = {}, None
    with tempfile.TemporaryDirectory() as folder:
        process, port = start(arguments, folder)
        try:
            assert is_served(port), "the page is not served"
            end = time.monotonic() + arguments.seconds
            while time.monotonic() < end:
                for _ in range(200):
                    request = mutant(rng, rng.choice(good_requests(port)))
                    status = send(rng, port, request)
                    assert status in ALLOWED, (status, request)
                    assert status not in (200, 303) or TOKEN.encode() in request, request
                    counts[status] = counts.get(status, 0) + 1
                assert process.poll() is None, process.stderr.read().decode()
                assert is_served(port), f"no answer any more, seed {arguments.seed}"
                first_kb = first_kb or memory_kb(process)
                grown_kb = memory_kb(process) - first_kb
                assert grown_kb < MAX_GROWTH_KB, f"{grown_kb} kB more"
            process.send_signal(signal.SIGTERM)
            error = process.communicate(timeout=30)[1].decode()
            assert process.returncode == 0 and error == "", (process.returncode, error)
        finally:
            process.kill()
            process.wait()
    print(f"{sum(counts.values())} requests; answers:",
          ", ".join(f"{status or 'none'} {n}" for status, n in sorted(counts.items(), key=str)))
    print(f"memory grew by {grown_kb} kB")


if __name__ == "__main__":
    main()
