"""Tests of failures.py, which prints the failures at the end of a run of tests."""

import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).parent))
import failures  # noqa: E402

REPORT = """<?xml version="1.0"?>
<testsuite>
  <testcase name="Passes" status="run"><system-out>well</system-out></testcase>
  <testcase name="Suite" time="1.5" status="fail"><failure message=""/><system-out>random numbers: SFT_TEST_SEED=7
[ RUN      ] Suite.Passes
a line of the one that passes
[       OK ] Suite.Passes (0 ms)
[ RUN      ] Suite.Fails
{lines}
it is wrong, to repeat: SFT_TEST_SEED=9
[  FAILED  ] Suite.Fails (1 ms)
</system-out></testcase>
  <testcase name="Hangs/0" time="900" status="fail"><failure message="Timeout"/><system-out/></testcase>
</testsuite>"""


class Failures(unittest.TestCase):
    def report(self, lines):
        text = io.StringIO()
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "report.xml")
            file.write_text(REPORT.replace("{lines}", lines))
            with mock.patch.object(sys, "argv", ["failures.py", str(file)]), contextlib.redirect_stdout(text):
                failures.main()
        return text.getvalue()

    def test_each_has_its_reason_the_seed_that_failed_and_a_command_that_repeats_it(self):
        text = self.report("")
        self.assertIn("== Suite: Failed after 1.5 s; to repeat: SFT_TEST_SEED=9 ./run test '^Suite$'", text)
        self.assertIn("== Hangs/0: Timeout after 900.0 s; to repeat: ./run test '^Hangs/0$'", text)

    def test_the_end_of_the_log_is_shown_without_what_passed(self):
        text = self.report("\n".join(f"line {n}" for n in range(100)))
        self.assertIn("line 99", text)
        self.assertNotIn("line 50\n", text)
        self.assertNotIn("the one that passes", text)

    def test_the_names_of_all_come_last(self):
        self.assertTrue(self.report("").endswith("2 tests failed:\n  Suite\n  Hangs/0\n"))


if __name__ == "__main__":
    unittest.main()
