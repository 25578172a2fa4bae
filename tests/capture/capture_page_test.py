#!/usr/bin/env python3
"""The page of a capture in a browser: what it shows, and that its buttons reach the program.

With --pictures FOLDER it leaves screenshots there.
"""
import argparse
import os
import re
import select
import subprocess
import sys
import time
import unittest

from browser import BROWSER, HANG_S, Browser

programs = argparse.Namespace()

# Each name is one that a careless page would take for something else.
NAMES = ["frame_0001.png", 'a "b"<i>&+%41.png', "\u00fcber/../x.png"]


def text_of(name):
    return f"document.getElementById('{name}').textContent"


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def setUp(self):
        self.browser.complaints.clear()
        self.start()
        self.open()

    def tearDown(self):
        self.stop()

    def start(self, *arguments):
        self.demo = subprocess.Popen([programs.demo, *arguments], stdin=subprocess.PIPE,
                                     stdout=subprocess.PIPE)
        self.link = self.read_line()

    def stop(self):
        self.demo.stdin.close()
        self.assertEqual(self.demo.wait(10), 0)
        self.demo.stdout.close()

    def open(self, width=1280, height=800, **options):
        self.browser.open(self.link, width, height, **options)
        self.browser.wait_for("document.documentElement.dataset.states > 0 && "
                              "document.documentElement.clientWidth")

    def read_line(self):
        """What the program printed next; it is told commands so."""
        if not select.select([self.demo.stdout], [], [], HANG_S)[0]:
            self.fail("the program was told nothing")
        return self.demo.stdout.readline().decode().rstrip("\n")

    def tell(self, *lines):
        self.demo.stdin.write("".join(line + "\n" for line in lines).encode())
        self.demo.stdin.flush()

    def shows(self, name, text):
        self.browser.wait_for(f"{text_of(name)} === {text!r}")

    def evaluate(self, expression):
        return self.browser.evaluate(expression)

    def wait_for(self, expression):
        return self.browser.wait_for(expression)

    def take_picture(self, name):
        if programs.pictures:
            time.sleep(0.5)  # for what moves
            self.browser.screenshot(os.path.join(programs.pictures, name + ".png"))

    def fill(self):
        """All that a page can show at once."""
        self.tell("known 1", "next", *(f"keep {name}" for name in NAMES),
                  "remark Exposure is <b>not</b> locked: pictures get darker and brighter",
                  "word moving Hold the board still, a little nearer to the camera, and tilt it",
                  "picture 2")
        self.shows("word-text", "Moving")

    def test_word_and_hint(self):
        for word, sign, text, kind in (
                ("blurred", "\u2248", "Blurred", "bad"), ("absent", "\u25cb", "No board", "idle"),
                ("bright", "\u25b2", "Too bright", "bad"), ("busy", "\u2026", "Working", "busy"),
                ("unheard-of", "\u2022", "unheard-of", "idle")):
            self.tell(f"word {word} Tilt it <i>now</i>, {word}")
            self.shows("word-text", text)
            self.shows("sign", sign)
            self.shows("hint", f"Tilt it <i>now</i>, {word}")
            self.assertEqual(self.evaluate("document.getElementById('word').dataset.kind"), kind)
        self.wait_for(f"/unheard-of. Tilt it/.test({text_of('spoken')})")
        self.assertGreaterEqual(self.evaluate(
            "parseFloat(getComputedStyle(document.getElementById('hint')).fontSize)"), 32)

    def test_picture_and_what_lies_over_it(self):
        self.tell("next", "picture 2")
        # One picture alone is shown at once, too.
        self.wait_for("document.getElementById('live').naturalWidth === 960")
        path = "document.getElementById('%s').getAttribute('d')"
        self.wait_for(f"({path % 'dots'} || '').split('M').length === 55")
        self.assertEqual(self.evaluate(
            "document.getElementById('overlay').getAttribute('viewBox')"), "-0.5 -0.5 960 720")
        outline, top = self.evaluate(path % "next"), self.evaluate(path % "top")
        self.assertTrue(outline.endswith("Z"))
        self.assertTrue(outline.startswith(top), (outline, top))
        self.assertRegex(self.evaluate(path % "arrow"), r"^M[\d.]+ [\d.]+L")
        width = "parseFloat(getComputedStyle(document.getElementById('%s')).strokeWidth)"
        self.assertGreater(self.evaluate(width % "top"), 2 * self.evaluate(width % "next"))

    def test_a_rig_shows_all_its_cameras(self):
        self.assertTrue(self.evaluate("document.getElementById('rig').hidden"))
        self.tell("rig", "next", "picture 2")
        self.shows("rig", "left \u2194 0.04 pxright \u2713 0.2 pxleft\u2013right 0.013 px")
        self.assertEqual(self.evaluate("document.querySelector('#rig .shown').textContent"),
                         "left \u2194 0.04 px")
        self.take_picture("rig")

    def test_map(self):
        label = "document.getElementById('map').getAttribute('aria-label')"
        self.assertEqual(self.evaluate(label), "No estimate yet")
        self.assertTrue(self.evaluate("document.getElementById('legend').hidden"))
        self.tell("known 1")
        self.wait_for("!document.getElementById('legend').hidden")
        self.assertRegex(self.evaluate(label), r"from 0\.05 px at the middle centre to "
                         r"0\.\d+ px at the bottom right")
        self.assertRegex(self.evaluate(text_of("ticks")), r"^0\.05 px.*0\.2 px.*1 px$")
        self.shows("above", "\u2022 above 0.2 px")
        self.shows("known", "Uncertainty 0.4 px, target 0.2 px")
        self.assertEqual(self.evaluate(
            "document.getElementById('progress').getAttribute('aria-valuenow')"), "50")
        # Bright where little is known.
        brightness = """(([x, y]) => {
          const canvas = document.getElementById('map');
          const data = canvas.getContext('2d').getImageData(
            Math.floor(x * canvas.width), Math.floor(y * canvas.height), 1, 1).data;
          return data[0] + data[1] + data[2];
        })"""
        self.assertGreater(self.evaluate(brightness + "([0.95, 0.75])"),
                           self.evaluate(brightness + "([0.45, 0.3])") + 100)
        # Dots, too, say that places are above the target, until none is.
        dot = brightness + "([11.5 / 12, 4.5 / 9])"
        self.assertEqual(self.evaluate(dot), 3 * 255)
        self.tell("known 0.1")
        self.shows("known", "Uncertainty 0.04 px, target 0.2 px")
        self.wait_for(f"{dot} < {3 * 255}")

    def test_kept_frames(self):
        self.fill()
        self.shows("num-kept", "3")
        self.shows("expected", ", about 12 more")
        self.wait_for("[...document.querySelectorAll('#kept img')].length === 3 && "
                      "[...document.querySelectorAll('#kept img')].every((img) => "
                      "img.naturalWidth === 320)")
        self.assertEqual(self.evaluate("[...document.querySelectorAll('#kept span')].map("
                                       "(node) => node.textContent)"), NAMES[::-1])
        self.tell("keep one-more.png")
        self.shows("word-text", "Kept")
        self.shows("num-kept", "4")
        self.shows("word-text", "Moving")
        self.wait_for(f"/Kept, 4 frames/.test({text_of('spoken')})")
        # It is announced even if the next state arrives before its turn.
        self.tell("keep two-more.png", "word absent Show the board")
        self.wait_for(f"/Kept, 5 frames. .*Show the board/.test({text_of('spoken')})")
        # A look at one, then at the one before.
        self.browser.click("#kept li:nth-child(2) .open")
        picture = "document.getElementById('look-picture')"
        self.wait_for(f"{picture}.naturalWidth === 960")
        self.shows("look-name", "one-more.png")
        self.browser.click("#look-older")
        self.shows("look-name", NAMES[2])
        self.wait_for(f"{picture}.complete && {picture}.naturalWidth === 960")
        self.browser.click("#look-close")
        self.wait_for("!document.getElementById('look').open")
        self.tell("keep lost.png")
        self.shows("num-kept", "6")
        self.browser.click("#kept li:nth-child(1) .open")
        self.shows("look-text", "Cannot read this frame.")
        self.browser.complaints[:] = [complaint for complaint in self.browser.complaints
                                      if "lost.png" not in complaint]
        self.assertEqual(self.browser.complaints, [])

    def test_buttons_reach_the_program(self):
        self.fill()
        self.browser.click("#pause")
        self.assertEqual(self.read_line(), "pause")
        self.shows("pause", "Continue")
        self.shows("word-text", "Paused")
        self.browser.click("#pause")
        self.assertEqual(self.read_line(), "go-on")
        self.shows("pause", "Pause")
        self.shows("word-text", "Moving")
        # A frame is deleted once that is confirmed.
        self.browser.click("#kept li:nth-child(2) .delete")
        self.shows("ask-text", f"Delete the frame {NAMES[1]}?")
        self.browser.click("#ask-no")
        self.wait_for("!document.getElementById('ask').open")
        self.browser.click("#kept li:nth-child(2) .delete")
        self.browser.click("#ask-yes")
        self.assertEqual(self.read_line(), "delete " + NAMES[1])
        self.shows("num-kept", "2")
        self.browser.click("#kept li:nth-child(1) .delete")
        self.browser.click("#ask-yes")
        self.assertEqual(self.read_line(), "delete " + NAMES[2])
        self.browser.click("#undo")
        self.assertEqual(self.read_line(), "undo")
        self.wait_for("document.getElementById('undo').disabled")
        self.browser.click("#finish")
        self.shows("ask-text", "Finish now? More frames would improve the calibration.")
        self.browser.click("#ask-yes")
        self.assertEqual(self.read_line(), "finish")
        self.assertEqual(self.browser.complaints, [])

    def test_done_and_the_end(self):
        self.fill()
        self.assertTrue(self.evaluate("document.getElementById('done').hidden"))
        self.tell("done")
        self.wait_for("!document.getElementById('done').hidden")
        self.assertTrue(self.evaluate("document.title").startswith("Done"))
        self.browser.click("#finish")  # nothing is asked any more
        self.assertEqual(self.read_line(), "finish")
        self.tell("quit")
        self.shows("lost", "\u2713 Done. The capture ended with 3 frames.")
        # Another capture at this address goes on there.
        self.stop()
        self.start("127.0.0.1", re.search(r":(\d+)/", self.link)[1])
        self.wait_for("document.getElementById('lost').hidden")
        self.shows("num-kept", "0")

    def test_lost_connection_comes_back(self):
        self.fill()
        self.demo.kill()
        self.demo.wait(10)
        for stream in (self.demo.stdin, self.demo.stdout):
            stream.close()
        self.wait_for(f"/^! Connection lost at .* Reconnecting/.test({text_of('lost')})")
        self.assertTrue(self.evaluate("document.getElementById('pause').disabled"))
        self.start("127.0.0.1", re.search(r":(\d+)/", self.link)[1])
        self.wait_for("document.getElementById('lost').hidden")
        self.tell("word dark Give it more light", "picture 1")
        self.shows("hint", "Give it more light")
        self.assertFalse(self.evaluate("document.getElementById('pause').disabled"))
        self.wait_for("document.getElementById('live').naturalWidth === 960")

    def test_sound_after_a_click(self):
        self.shows("sound", "Tap to enable sound")
        self.browser.click("#sound")
        self.shows("sound", "Sound on")
        self.browser.click("#sound")
        self.shows("sound", "Sound off")

    def test_who_has_the_link_has_the_buttons(self):
        self.stop()
        self.start("0.0.0.0")
        self.link = re.sub(r"//[^/]*:", "//localhost:", self.link)
        self.assertRegex(self.link, r"\?token=[0-9a-f]{32}$")
        self.open()
        self.assertNotIn("token", self.evaluate("location.href"))
        self.browser.click("#pause")
        self.assertEqual(self.read_line(), "pause")
        self.assertEqual(self.browser.complaints, [])

    def test_fits_a_phone(self):
        self.open(390, 844, scale=2)
        self.fill()
        self.assertLessEqual(self.evaluate("document.documentElement.scrollWidth"), 390)
        small = self.evaluate("""[...document.querySelectorAll('button')].map((button) => {
          const box = button.getBoundingClientRect();
          return [button.id || button.className, box.width, box.height];
        }).filter(([, width, height]) => width > 0 && (width < 44 || height < 44))""")
        self.assertEqual(small, [])
        # The buttons can be pressed wherever the page is.
        for at in (0, 600, 10000):
            self.evaluate(f"window.scrollTo(0, {at})")
            box = self.evaluate("document.getElementById('pause').getBoundingClientRect().bottom")
            self.assertLessEqual(box, 844)

    def test_pictures_of_all_sizes(self):
        for name, width, height, options in (
                ("desk", 1280, 800, {}), ("desk-dark", 1280, 800, {"is_dark": True}),
                ("phone", 390, 844, {"scale": 2}), ("phone-dark", 390, 844,
                                                    {"scale": 2, "is_dark": True})):
            self.open(width, height, **options)
            if name == "desk":
                self.fill()
            self.wait_for("document.getElementById('live').naturalWidth === 960 || "
                          "document.documentElement.dataset.states > 1")
            self.tell("picture 2")
            self.wait_for("document.getElementById('live').naturalWidth === 960")
            self.take_picture(name)
            # Text and ground differ enough to be read.
            low = self.evaluate(CONTRASTS)
            self.assertEqual(low, [])
        self.assertEqual(self.browser.complaints, [])


# Elements whose text has less contrast than WCAG's 4.5 to its ground.
CONTRASTS = """(() => {
  const channels = (color) => color.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((c) => c / 255)
    .map((c) => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, k) => sum + c * [0.2126, 0.7152, 0.0722][k], 0);
  const groundOf = (node) => {
    for (; node; node = node.parentElement) {
      const color = channels(getComputedStyle(node).backgroundColor);
      if (color.length === 3 || color[3] === 1) return color;
    }
    return [255, 255, 255];
  };
  const low = [];
  for (const node of document.querySelectorAll('p, span, h2, button, output, li')) {
    if (node.checkVisibility && !node.checkVisibility() || node.disabled) continue;
    if (![...node.childNodes].some((child) => child.nodeType === 3 && child.data.trim())) continue;
    const [a, b] = [light(channels(getComputedStyle(node).color)), light(groundOf(node))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) low.push(`${node.id || node.className || node.textContent}: ${contrast}`);
  }
  return low;
})()"""


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--demo", required=True)
    parser.add_argument("--pictures")
    _, rest = parser.parse_known_args(namespace=programs)
    if not BROWSER:
        print("no chromium; tools/install_packages tests installs it")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0]] + rest, verbosity=2)
