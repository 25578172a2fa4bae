"""Manual pages and completion, which are made of what the commands print as help."""
import os
import re
import subprocess
import sys

import command_test
from command_test import CommandTest, read, run, write

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools",
                      "command_pages")


class Pages(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.succeed("-B", SCRIPT, "--version", "1.2.3", "-o", cls.path("pages"),
                    command_test.programs.raygrid, program=sys.executable)

    def page(self, name):
        return read(self.path(f"pages/man1/{name}.1")).decode()

    def complete(self, *words):
        """What bash offers for the last word."""
        script = ('source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _raygrid; '
                  'echo "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-uec", script, "bash", self.path("pages/bash/raygrid"),
                               *words], capture_output=True, text=True, check=False)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_every_option_of_the_help_is_in_the_page_and_completed(self):
        for command in (["calibrate"], ["pack"], ["export"], ["pattern", "star"]):
            with self.subTest(command=command):
                told = re.findall(r"^  (?:-\w,)?(--[\w-]+)", run(*command, "--help").stdout,
                                  re.MULTILINE)
                page = self.page("_".join(["raygrid", *command])).replace("\\-", "-")
                self.assertGreater(len(told), 8)
                self.assertEqual([name for name in told if f"\\fB{name}\\fR" not in page], [])
                offered = self.complete("raygrid", *command, "--")
                self.assertEqual(sorted(offered), sorted(set(told) | {"--help"}))

    def test_every_command_has_a_page(self):
        main = self.page("raygrid")
        self.assertIn("raygrid 1.2.3", main)
        commands = self.complete("raygrid", "")
        self.assertIn("calibrate", commands)
        for command in commands:
            self.assertIn(f"raygrid_{command}\\fR(1)", main.replace("\\-", "-"))
            page = self.page(f"raygrid_{command}")
            self.assertIn(f"raygrid_{command} \\- ", page)
            self.assertIn("SEE ALSO\n\\fBraygrid\\fR(1)", page)
            self.assertEqual(page.count('.SH "EXIT CODES"'), 1)

    def test_lines_of_the_help_are_no_requests_of_troff(self):
        program = write(self.path("program"), "#!/bin/sh\ncat <<'E'\nDoes it.\n\n"
                        "Usage: program FILE\n  FILE  a\\b\n.SH x\n\nNotes\n'x'\n  -n N  some\nE\n")
        os.chmod(program, 0o755)
        made = run("-B", SCRIPT, "--version", "1", "-o", self.path("other"), "sh", "-e", program,
                   program=sys.executable)
        self.assertEqual(made.stderr, "")
        page = read(self.path("other/man1/program.1")).decode()
        self.assertIn("\n  FILE  a\\eb\n\\&.SH x\n", page)
        self.assertIn('\n.SH "NOTES"\n.nf\n\\&\'x\'\n  \\-n N', page)
        self.assertIn("program \\- Does it\n", page)

    def test_bash_completes_words(self):
        self.assertEqual(self.complete("raygrid", "cal"), ["calibrate"])
        self.assertEqual(self.complete("raygrid", "pattern", "c"), ["chessboard", "charuco"])
        self.assertEqual(self.complete("raygrid", "calibrate", "a/", "--area", ""),
                         ["image", "features"])
        self.assertEqual(self.complete("raygrid", "calibrate", "--area", "=", "i"), ["image"])
        self.assertIn("mrcal", self.complete("raygrid", "export", "a.yaml", "--to", "m"))

    def test_bash_leaves_files_to_itself(self):
        self.assertEqual(self.complete("raygrid", "calibrate", "ph"), [])
        self.assertEqual(self.complete("raygrid", "calibrate", "--pattern", ""), [])
        self.assertEqual(self.complete("raygrid", "calibrate", "--name", "pattern", "st"), [])


if __name__ == "__main__":
    command_test.main(__name__)
