"""Steps of work that know about how long they take."""
import subprocess
import sys
import time


class Step:
    """One piece of work: seconds are what it took once."""

    def __init__(self, name, seconds, work):
        self.name, self.seconds, self.work = name, seconds, work


def run(steps):
    """Runs all. Returns the seconds, and the names of those whose program failed."""
    failed = []
    total, done, begin = sum(s.seconds for s in steps), 0, time.monotonic()
    for number, step in enumerate(steps, 1):
        elapsed = time.monotonic() - begin
        pace = elapsed / done if done > 30 else 1
        minutes = (total - done) * pace / 60
        print(f"[{number}/{len(steps)}, about {minutes:.0f} min left] {step.name}", flush=True)
        try:
            step.work()
        except (subprocess.CalledProcessError, RuntimeError, OSError) as error:
            print(f"measure_readme: {step.name}: {error}", file=sys.stderr)
            failed.append(step.name)
        done += step.seconds
    return time.monotonic() - begin, failed
