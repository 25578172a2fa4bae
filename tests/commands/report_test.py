#!/usr/bin/env python3
"""The report in a browser, and made again from a folder."""
import base64
import json
import os
import random
import re
import shutil
import subprocess
import tempfile
import zlib

from command_test import HANG_S, CalibratedTest, cpu_seconds_of_children, main, read, run, write
from png_files import png, read_png

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")

# Does what a reader does with the page's trial, and leaves in the page what came of it.
READER = """
const wait = async (isDone) => {
  while (!isDone()) await new Promise((done) => setTimeout(done, 10));
};
const byId = (id) => document.getElementById(id), told = document.documentElement.dataset;
const section = byId('trial'), kind = byId('trial-kind'), angle = byId('trial-angle');
const drop = async (base64, name) => {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name, {type: 'image/png'}));
  section.dispatchEvent(new DragEvent('drop', {dataTransfer, cancelable: true}));
  await wait(() => byId('trial-message').textContent.startsWith(name));
};
const bytesOf = (canvas) => {
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
  copy.drawImage(canvas, 0, 0);
  return copy.getImageData(0, 0, canvas.width, canvas.height).data;
};
const crcOf = (canvas) => {
  let crc = -1;
  for (const byte of bytesOf(canvas)) {
    crc ^= byte;
    for (let k = 0; k < 8; ++k) crc = crc & 1 ? 0xedb88320 ^ (crc >>> 1) : crc >>> 1;
  }
  return ~crc >>> 0;
};
await wait(() => !section.hidden);
await drop('SMALL', 'small.png');
told.refusal = byId('trial-message').textContent;
await drop('PHOTOGRAPH', 'photograph.png');
kind.value = 'packed';
kind.onchange();
told.packedCrc = crcOf(byId('trial-made'));
kind.value = 'pinhole';
angle.value = 60;
angle.dispatchEvent(new Event('input'));
told.figures = byId('trial-figures').textContent;
told.seen = crcOf(byId('trial-made')) !== Number(told.packedCrc);
const hover = (canvas, x, y) => {
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new PointerEvent('pointermove', {
    clientX: box.left + (x + 0.5) / canvas.width * box.width,
    clientY: box.top + (y + 0.5) / canvas.height * box.height}));
  return byId('tip').textContent;
};
told.ray = hover(byId('trial-taken'), 200, 150);
told.back = hover(byId('trial-made'), 319.5, 239.5);
angle.value = 150;
angle.dispatchEvent(new Event('input'));
told.corner = bytesOf(byId('trial-made')).slice(0, 4);
told.reader = 'done';
"""

NUM_IMAGES, PER_IMAGE = 1000, 240  # of the largest report


def browse(page, *options, width=1200, height=900):
    """Chromium's text for a page with these options, and its complaints."""
    with tempfile.TemporaryDirectory() as profile:
        result = subprocess.run(
            [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
             f"--user-data-dir={profile}", f"--window-size={width},{height}", *options,
             "file://" + page],
            capture_output=True, text=True, timeout=HANG_S, check=False)
    complaints = [line for line in result.stderr.splitlines() if "CONSOLE" in line]
    return result.stdout, complaints


def large_folder(source, folder):
    """The files of source as if it had had very many images."""
    shutil.copytree(source, folder)
    header, *lines = read(os.path.join(source, "residuals.csv")).decode().splitlines()
    by_set = {name: [line.split(",") for line in lines if line.startswith(name + ",")]
              for name in ("training", "held-out")}
    out, features = [header], ["image,board,column,row,x,y"]
    for name, rows in by_set.items():
        for i in range(NUM_IMAGES):
            for k in range(PER_IMAGE):
                row = list(rows[(i * PER_IMAGE + k) % len(rows)])
                row[1] = f"{i:04}.png"
                row[3], row[4] = str(k % 14), str(k // 14 % 10)
                out.append(",".join(row))
                if name == "training" and k < 140:
                    features.append(",".join([row[1], "0", str(k % 14), str(k // 14), *row[5:7]]))
    write(os.path.join(folder, "residuals.csv"), "\n".join(out) + "\n")
    write(os.path.join(folder, "features.csv"), "\n".join(features) + "\n")
    # 3 MB, which is what calibrate stops at; these are no pictures.
    jpeg = base64.b64encode(bytes(3000)).decode()
    write(os.path.join(folder, "thumbnails.json"), json.dumps({
        "raygrid_thumbnails": 1, "images": {f"{i:04}.png": jpeg for i in range(NUM_IMAGES)}}))


class Report(CalibratedTest):
    def test_made_again_it_has_the_same_bytes(self):
        before = read(self.path("out/report.html"))
        self.succeed("report", self.path("out"))
        self.assertEqual(read(self.path("out/report.html")), before)

    def test_other_models_are_in_it(self):
        result = json.loads(read(self.path("out/result.json")))
        models = [entry["model"] for entry in result["parametric_models"]]
        self.assertEqual(models, ["opencv", "thin-prism-fisheye", "central-radial"])
        for entry in result["parametric_models"]:
            self.assertGreater(entry["held_out"]["median_px"], result["held_out"]["median_px"])

    def test_browser_has_no_complaints(self):
        if not BROWSER:
            self.skipTest("no chromium; tools/install_packages tests installs it")
        for width in (400, 1200):
            page = self.path("out/report.html") if width == 400 else self.page_with_reader()
            dom, complaints = browse(page, "--dump-dom", "--virtual-time-budget=20000", width=width)
            self.assertEqual(complaints, [])
            self.assertRegex(dom, r'data-ready-ms="\d+"')
            self.assertIn("<option>", dom)
        self.check_trial(dict(re.findall(r'data-([\w-]+)="([^"]*)"', dom[:2000])))

    def page_with_reader(self):
        """The report, with a script that drops two pictures, chooses views and points at pixels."""
        samples = random.Random(1).randbytes(3 * 640 * 480)
        pngs = {}
        for name, size in (("PHOTOGRAPH", (640, 480)), ("SMALL", (320, 480))):
            path = write(self.path(name + ".png"),
                         png(samples[:3 * size[0] * size[1]], size, channels=3))
            pngs[name] = base64.b64encode(read(path)).decode()
        script = re.sub("SMALL|PHOTOGRAPH", lambda match: pngs[match.group()], READER)
        html = read(self.path("out/report.html")).decode().replace(
            "</body>", f'<script type="module">{script}</script></body>')
        return write(self.path("reader.html"), html)

    def check_trial(self, told):
        self.assertEqual(told.get("reader"), "done", told)
        self.assertIn("small.png has 320", told["refusal"])
        blob = self.path("out/camera.raygrid")
        self.succeed("undistort", blob, self.path("PHOTOGRAPH.png"), "-o",
                     self.path("undistorted"))
        _, _, samples = read_png(self.path("undistorted/PHOTOGRAPH.png"))
        rgba = bytearray(b"\xff") * (len(samples) // 3 * 4)
        for channel in range(3):
            rgba[channel::4] = bytes(samples[channel::3])
        self.assertEqual(int(told["packed-crc"]), zlib.crc32(rgba))
        self.assertEqual(told["seen"], "true")
        self.assertIn("640 \u00d7 480 px, fx 554.3 px", told["figures"])
        self.assertEqual(told["corner"], "0,0,0,255")
        rays = run("unproject", blob, "--pixels",
                   write(self.path("pixel.csv"), "x,y\n200,150\n"))
        expected = [f"{float(v):.4f}" for v in rays.stdout.split()[-1].split(",")[2:5]]
        self.assertIn(f"(200.0, 150.0): ray direction ({', '.join(expected)}), ", told["ray"])
        self.assertRegex(told["back"], r"ray direction \(-?0\.0000, -?0\.0000, 1\.0000\)")

    def test_report_of_a_thousand_images(self):
        folder = self.path("large")
        large_folder(self.path("out"), folder)
        before = cpu_seconds_of_children()
        self.succeed("report", folder)
        seconds = cpu_seconds_of_children() - before
        size = os.path.getsize(os.path.join(folder, "report.html"))
        print(f"\n{NUM_IMAGES} images: {size / 1e6:.1f} MB, made in {seconds:.1f} CPU seconds", flush=True)
        self.assertLess(size, 15e6)
        self.assertLess(seconds, 20)
        if not BROWSER:
            return
        dom, complaints = browse(os.path.join(folder, "report.html"), "--dump-dom")
        self.assertEqual(complaints, [])
        # How long that takes depends on what else the machine does.
        ready = re.search(r'data-ready-ms="(\d+)"', dom).group(1)
        print(f"ready in the browser after {ready} ms", flush=True)

    def test_bad_folders(self):
        self.assert_refused(run("report", self.path("nowhere")), 2, "result.json", "missing")
        folder = self.path("older")
        shutil.copytree(self.path("out"), folder)
        write(os.path.join(folder, "result.json"), "{}")
        self.assert_refused(run("report", folder), 2, "another version")
        result = json.loads(read(self.path("out/result.json")))
        write(os.path.join(folder, "result.json"), json.dumps({**result, "parameters": [1]}))
        refusal = run("report", folder)
        self.assert_refused(refusal, 2, "result.json", "type must be number, but is array")
        self.assertNotIn("json.exception", refusal.stderr)
        shutil.copy(self.path("out/result.json"), folder)
        for text, word in (("{}", "malformed"), ('{"raygrid_thumbnails": 2}', "another version")):
            write(os.path.join(folder, "thumbnails.json"), text)
            self.assert_refused(run("report", folder), 2, "thumbnails.json", word)


class Check(CalibratedTest):
    options = ("--skip-comparison", "--hold-out", "sim0011.png")

    def features(self, name, move):
        """A few images of the camera with its pixels moved."""
        header, *lines = read(self.path("sim/features.csv")).decode().splitlines()
        out = [header]
        for line in lines:
            image, *rest, x, y = line.split(",")
            if image > "sim0004.png":
                break
            x, y = move(float(x), float(y))
            if 0 <= x <= 639 and 0 <= y <= 479:
                out.append(",".join([image, *rest, f"{x:.4f}", f"{y:.4f}"]))
        return write(self.path(name), "\n".join(out) + "\n")

    def check(self, name, move, *options):
        return run("check", self.path("out/camera.yaml"), "--features",
                   self.features(name, move), *options)

    def test_unchanged(self):
        result = self.check("same.csv", lambda x, y: (x, y))
        self.assert_done(result)
        self.assertTrue(result.stdout.startswith("OK"), result.stdout)

    def test_copies_of_views_count_once(self):
        once = json.loads(self.check("once.csv", lambda x, y: (x, y), "--json").stdout)
        header, *lines = read(self.path("once.csv")).decode().splitlines()
        for copies in (2, 3):
            text = [header] + [f"copy{k}_{line}" for k in range(copies) for line in lines]
            result = self.succeed("check", self.path("out/camera.yaml"), "--features",
                                  write(self.path(f"copies{copies}.csv"), "\n".join(text) + "\n"), "--json")
            found = json.loads(result.stdout)
            self.assertEqual(found["images"], once["images"])
            self.assertEqual(found["changes"], once["changes"])
            self.assertEqual(len(found["rejected_images"]), (copies - 1) * once["images"])
            self.assertIn("duplicate of copy0_sim0000.png", found["rejected_images"][0]["reason"])

    def test_noise_that_hides_everything_is_no_ok(self):
        randomly = random.Random(1)
        result = self.check("noisy.csv", lambda x, y: (x + randomly.gauss(0, 3), y + randomly.gauss(0, 3)))
        self.assert_refused(result, 3, "no change detected", "take more or sharper images")
        self.assertTrue(result.stdout.startswith("INCONCLUSIVE"), result.stdout)

    def test_scaled(self):
        result = self.check("scaled.csv",
                            lambda x, y: (319.5 + 1.003 * (x - 319.5), 239.5 + 1.003 * (y - 239.5)),
                            "--json")
        self.assert_refused(result, 6, "scale", "calibrate")
        found = json.loads(result.stdout)
        self.assertEqual(found["status"], "DEGRADED")
        self.assertEqual(found["significant_changes"], ["scale"])
        self.assertAlmostEqual(found["changes"]["scale"]["relative_change"], 0.003, delta=0.0005)

    def test_wrong_usage(self):
        camera = self.path("out/camera.yaml")
        self.assert_refused(run("check", camera), 1, "--features")
        other = write(self.path("alone/camera.yaml"), read(camera))
        self.assert_refused(run("check", other, "--features", self.path("sim/features.csv")), 1,
                            "--pattern")


if __name__ == "__main__":
    main(__name__)
