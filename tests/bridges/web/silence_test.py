#!/usr/bin/env python3
"""What the page says of something that is dead: in a real browser, with the real programs. Nothing reads as well, and nothing is a picture
of what is past.

SLIPD_SCREENSHOTS=FOLDER keeps pictures of the page in each case.
"""
import os
import re
import signal
import socket
import sys
import tempfile
import threading
import unittest
from pathlib import Path

from awaiting import await_true
from bed import Bed, WebSocket, of_trials, trial
from page import PageCase, browser, missing

SHOWN = """
  const card = document.querySelector(`.card[data-name="${arguments[0]}"]`), text = (selector) => card.querySelector(selector).textContent;
  const map = document.querySelector("canvas.map");
  const fact = (label) => [...document.querySelectorAll("dt")].filter((each) => each.textContent === label && each.offsetParent)
    .map((each) => each.nextElementSibling.textContent).at(-1);
  return card && { state: card.dataset.state, level: card.dataset.alert, number: text(".number span"), alert: text(".alert"), words: text(".state"),
    forces: [...card.querySelectorAll("dt")].find((each) => each.textContent === "Forces").nextElementSibling.textContent,
    slides: [...card.querySelectorAll("dt")].find((each) => each.textContent === "Sliding").nextElementSibling.textContent,
    needle: card.querySelector(".needle").getAttribute("d"), picture: map.dataset.picture, sequence: map.dataset.sequence,
    caption: document.querySelector("figcaption").textContent, health: fact("Frames"), rate: fact("Rate") };
"""


class Silence(PageCase):
    """left holds, right is near slip: a raised alert."""

    @classmethod
    def setUpClass(cls):
        cls.browser = browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()

    def begin(self, *sensors):
        """Opens the page of these sensors, and looks at the first once all have a margin."""
        self.bed = Bed(of_trials(*sensors), drivers="test-drivers")
        self.addCleanup(self.bed.close)
        self.addCleanup(self.browser.get, "about:blank")  # before the bed goes
        self.browser.get_log("browser")
        self.open("#/live")
        for sensor in sensors:
            self.card(sensor["name"], "ok")
        self.look(sensors[0]["name"])

    def look(self, name):
        self.all(f'.card[data-name="{name}"] button')[0].click()

    def shown(self, name):
        return self.script(SHOWN, name)

    def until(self, name, what, **wanted):
        """What is shown of a sensor once that fits."""
        last = {}

        def fits():
            last.update(self.shown(name) or {})
            return last and all(re.search(pattern, last[key] or "") for key, pattern in wanted.items()) and dict(last)
        try:
            return await_true(fits, what, 60)
        except AssertionError as error:
            raise AssertionError(f"{error}; shown: {last}") from None

    def well(self, name):
        return self.until(name, "a sensor that is well", state="^ok$", alert="^no alert$", number=r"^0\.", picture="shown", health="^good$", rate=r"^[1-9]")

    def keep(self, name):
        folder = os.environ.get("SLIPD_SCREENSHOTS")
        if folder:
            Path(folder).mkdir(parents=True, exist_ok=True)
            self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 1280, "height": 1500, "deviceScaleFactor": 1, "mobile": False})
            self.browser.save_screenshot(str(Path(folder) / f"{name}.png"))
            self.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

    def assert_nothing_reads_as_well(self, shown):
        self.assertEqual((shown["number"], shown["needle"], shown["forces"], shown["slides"]), ("–", "", "–", "–"))
        self.assertNotIn(shown["level"], ("none", "", None))
        self.assertEqual((shown["picture"], shown["sequence"]), ("none", ""))
        self.assertRegex(shown["caption"], "^no picture: ")
        self.assertRegex(shown["health"], "^unknown")
        self.assertNotRegex(shown["rate"], "^[1-9]")

    def silent(self, behaviour, states):
        """The first sensor ends by itself; the others go on."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        gone = Path(folder.name) / "gone"
        ends = {"behaviour": behaviour, "well_until": str(gone)}
        self.begin(trial("left", ends), trial("right"), trial("slips", {**ends, "gamma": 0.01}))
        self.well("left")
        self.until("slips", "an alert", alert="slip", state="^ok$")
        gone.touch()
        self.assert_nothing_reads_as_well(self.until("left", "its end", state=f"^({states})$", alert="unknown", caption=rf"({states}) for \d+ s", health="^unknown"))
        self.until("slips", "that the alert stands", state=f"^({states})$", alert=r"slip \(stands\)")
        self.keep(f"sensor-{behaviour}")
        self.look("right")
        self.well("right")
        self.look("left")
        self.open("#/live")
        self.assert_nothing_reads_as_well(self.until("left", "the same when loaded anew", state=f"^({states})$", caption=rf"({states}) for \d+ s", health="^unknown"))
        self.until("slips", "the same when loaded anew", alert=r"slip \(stands\)")
        self.no_errors()

    def test_a_sensor_that_was_unplugged(self):
        self.silent("vanish", "fault|stale|learning")

    def test_a_sensor_that_has_ended(self):
        self.silent("end", "stale")

    def lost(self, what, says):
        """slipd or slipd-web is gone for the page."""
        self.begin(trial("left"), trial("slips", {"gamma": 0.01}))
        self.well("left")
        self.until("slips", "an alert", alert="slip", state="^ok$")
        what()
        self.assert_nothing_reads_as_well(self.until("left", "that it is gone", state="^disconnected$", alert="unknown", caption=says, health="^unknown$", rate="^–$"))
        self.until("slips", "that the alert stands", state="^disconnected$", alert=r"slip \(stands\)")

    def anew(self):
        self.open("#/live")
        self.assert_nothing_reads_as_well(self.until("left", "the same when loaded anew", state="^disconnected$", alert="unknown", health="^unknown$"))
        self.until("slips", "the same when loaded anew", state="^disconnected$", alert=r"slip \(stands\)")

    def test_a_slipd_that_was_killed(self):
        def kill():
            self.bed.slipd.signal(signal.SIGKILL)
            self.bed.slipd.process.wait()
        self.lost(kill, "slipd is not reached")
        self.keep("slipd-killed")
        self.anew()
        self.keep("slipd-killed-anew")
        self.bed.start_slipd()
        self.well("left")

    def test_a_slipd_that_was_stopped(self):
        self.lost(lambda: self.bed.slipd.signal(signal.SIGSTOP), "slipd is not reached")
        self.keep("slipd-stopped")
        self.anew()
        self.bed.slipd.signal(signal.SIGCONT)
        self.well("left")

    def test_a_slipd_web_that_was_stopped(self):
        self.lost(lambda: self.bed.web.signal(signal.SIGSTOP), "slipd-web is not reached")
        self.keep("slipd-web-stopped")
        self.bed.web.signal(signal.SIGCONT)
        self.well("left")

    PAGE = """
      const { LivePage } = await import("./live.js");
      const clock = performance.now, link = new EventTarget();
      let now = clock.call(performance), late = 0;
      performance.now = () => now;
      try {
        Object.assign(link, { late: () => late, look() {} });
        const page = new LivePage(link);
        document.body.append(page.element);
        page.show("");
        const drawn = () => new Promise((resolve) => setTimeout(() => requestAnimationFrame(() => setTimeout(resolve)), 50));
        const tell = (type, detail) => link.dispatchEvent(new CustomEvent(type, { detail }));
        const estimate = { sensor: "any", state: "ok", gamma: 0.5, sigma: 0.01, alert: "none", age_ms: 30, normal_n: 1, shear_n: 1, center_mm: [0, 0], radius_mm: 1 };
        const look = async () => {
          await drawn();
          const card = page.element.querySelector(".card"), text = (selector) => card.querySelector(selector).textContent;
          return [card.dataset.state, text(".number span"), text(".alert"), page.canvas.dataset.picture ?? ""].join();
        };
        tell("hello", { max_age_ms: 100 });
        %s
      } finally {
        performance.now = clock;
      }
    """

    def test_the_page_itself_judges_how_old_each_thing_is(self):
        self.begin(trial("left"))
        picture = """
          const frame = (age_ms) => {
            const head = JSON.stringify({ kind: "frame", sensor: "any", taxels: 1, seq: 7, age_ms, made_ms: 0, peak_pa: 1, peak_shear_pa: 1 });
            const bytes = new Uint8Array(4 + head.length + 3);
            new DataView(bytes.buffer).setUint32(0, head.length, true);
            bytes.set(new TextEncoder().encode(head), 4);
            return bytes.buffer;
          };
          tell("live", { slipd: "ok", made_ms: 0, grasps: [], sensors: [estimate] });
          tell("picture", frame(30));
          const young = await look();
          now += 70;
          const oldest = await look();
          now += 1;
          const old = await look();
          late = 71;
          tell("live", { slipd: "ok", made_ms: 0, grasps: [], sensors: [estimate] });
          tell("picture", frame(30));
          return [young, oldest, old, await look()];"""
        well, gone = "ok,0.50,no alert,shown", "stale,–,? alert unknown,none"
        self.assertEqual(self.module(self.PAGE % picture), [well, well, gone, gone])

    def test_where_it_may_slip_the_page_says_so_first(self):
        self.begin(trial("left"))
        words = self.module("""
          const { Card } = await import("./card.js");
          return arguments_[0].map((estimate) => {
            const card = new Card("any", "sensor");
            card.show({ sensor: "any", state: "ok", sigma: 0.01, ...estimate });
            const fact = [...card.element.querySelectorAll("dt")].find((each) => each.textContent === "Sliding").nextElementSibling.textContent;
            return [card.element.querySelector(".verdict").textContent, fact];
          });""", [
            {"gamma": 0.5, "alert": "none", "sliding": "none", "sliding_for_ms": 800},
            {"gamma": 0, "sigma": 0, "alert": "slip", "alert_cause": "margin", "sliding": None},
            {"gamma": 0.02, "sigma": 0.02, "alert": "none", "sliding": "none", "sliding_for_ms": 800},
            {"gamma": 0.08, "alert": "slip", "alert_cause": "margin", "sliding": "none", "sliding_for_ms": 800},
            {"gamma": 0.2, "alert": "warn", "alert_cause": "margin", "sliding": None},
            {"state": "learning", "gamma": None, "alert": "unknown", "sliding": None},
            {"state": "no_contact", "gamma": None, "alert": "none", "sliding": None}])
        verdicts, slides = zip(*words)
        self.assertEqual(verdicts[0], "no alertok: the margin is measured")
        self.assertEqual(verdicts[1], "✕ slip: marginslip: the margin is measured, and may be 0")
        self.assertEqual(verdicts[2], "no alertslip: the margin is measured, and may be 0")
        self.assertEqual(verdicts[3], "✕ slip: marginslip: the margin is measured, and too small")
        self.assertEqual(verdicts[4], "⚠ warn: marginwarn: the margin is measured, and small")
        self.assertTrue(verdicts[5].startswith("? alert unknownlearning"), verdicts[5])
        calm, unknown = "does not slide, for 0.8 s", "not known: the pattern cannot show it"
        self.assertEqual(slides, (calm, unknown, unknown, calm, unknown, unknown, "–"))

    def test_noise_has_no_arrows(self):
        self.begin(trial("left"))
        arrows = self.module("""
          const { Layout, TaxelMap, shearNoise } = await import("./map.js");
          const side = 20, count = side * side, peak = 10000;  // Pa
          const at = (i) => [i % side - 9.5, Math.floor(i / side) - 9.5];
          const layout = new Layout(Float32Array.from({ length: count }, (_, i) => at(i)[0]), Float32Array.from({ length: count }, (_, i) => at(i)[1]));
          let seed = 1;
          const random = () => (seed = seed * 16807 % 2147483647) / 2147483647 * 2 - 1;  // -1 ... 1, the same each time
          const seen = (shear, noise, known) => {
            const normal = new Float32Array(count), x = new Float32Array(count), y = new Float32Array(count);
            for (let i = 0; i < count; ++i) {
              const share = Math.sqrt(Math.max(0, 1 - (at(i)[0] ** 2 + at(i)[1] ** 2) / 36));
              normal[i] = peak * share;
              x[i] = shear * share + noise * random();
              y[i] = noise * random();
            }
            const most = Math.max(...x.map(Math.abs), ...y.map(Math.abs));
            const canvas = document.createElement("canvas");
            canvas.style.width = canvas.style.height = "400px";
            document.body.append(canvas);
            new TaxelMap(canvas).draw(layout, { normal, x, y, normalScale: 1 / peak, shearScale: 1 / most, noise: shearNoise(peak, most, known) }, null);
            canvas.remove();
            return Number(canvas.dataset.arrows);
          };
          // Noise as is usual, shear in it; noise that slipd has measured to be larger, or smaller than usual.
          return [seen(0, 100, null), seen(3000, 100, null), seen(0, 1000, 577), seen(8000, 1000, 577), seen(200, 5, 3)];""")
        nothing, sheared, noisy, sheared_in_noise, weak = arrows
        self.assertEqual((nothing, noisy), (0, 0))
        for count in (sheared, sheared_in_noise, weak):
            self.assertTrue(60 < count < 125, arrows)  # the contact has 112 taxels, and the others none

    def test_a_message_that_waited_is_older_than_it_says(self):
        self.begin(trial("left"))
        late = self.module("""
          const clock = performance.now;
          let now = 5000;
          performance.now = () => now;
          try {
            const { Link } = await import("./link.js");
            const link = new Link(), ways = [];
            for (const [at, made] of [[5000, 100], [5010, 100], [5020, 125], [5030, 130], [9030, 130]]) {
              now = at;
              ways.push(link.late(made));
            }
            return ways;
          } finally { performance.now = clock; }""")
        for value, wanted in zip(late, (0, 10, 0, 5, 4005)):
            self.assertAlmostEqual(value, wanted, delta=5)


class Tokens(PageCase):
    def test_two_pages_on_one_host_keep_their_tokens(self):
        self.browser = browser()
        self.addCleanup(self.browser.quit)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        beds = []
        for i in range(2):
            file = Path(folder.name) / str(i)
            file.write_text(f"0123456789abcdef{i}\n")
            beds.append(Bed(slipd=False, token_file=str(file)))
            self.addCleanup(beds[-1].close)
        for i, bed in enumerate(beds):
            self.open(f"?token=0123456789abcdef{i}", bed)
            await_true(lambda: self.all("nav a"), "the page")
        for bed in [*beds, *beds]:
            self.open("", bed)
            await_true(lambda: self.all("nav a"), "the page without the token")
        cookies = {each["name"]: each for each in self.browser.get_cookies()}
        self.assertEqual(set(cookies), {f"slipd-token-{bed.port}" for bed in beds})
        for each in cookies.values():
            self.assertEqual((each["httpOnly"], each["sameSite"], each["path"]), (True, "Strict", "/"))


class WithoutABrowser(unittest.TestCase):
    def test_a_sensor_without_frames_does_not_stop_the_pictures_of_others(self):
        # It sorts first, and its page is always ready for a picture, and there to the end.
        bed = Bed(of_trials(trial("aaa", {"gate": "/nowhere/at/all"}), trial("left")), drivers="test-drivers")
        self.addCleanup(bed.close)
        waits, looks = WebSocket(bed.port), WebSocket(bed.port)
        waits.say("look aaa")
        there = threading.Thread(target=lambda: self.assertRaises((ConnectionError, OSError), waits.message, "frame"))
        there.start()
        self.addCleanup(there.join)
        self.addCleanup(waits.socket.shutdown, socket.SHUT_RDWR)
        looks.say("look left")
        heads = [looks.message("frame") for _ in range(10)]
        self.assertEqual([head["sensor"] for head in heads], ["left"] * 10)
        self.assertLess(heads[0]["seq"], heads[-1]["seq"])
        self.assertTrue(there.is_alive())
        looks.close()

    def test_a_new_page_is_not_told_what_was_said_before_it_was_there(self):
        bed = Bed(of_trials(trial("left", {"gamma": 0.01})), drivers="test-drivers")
        self.addCleanup(bed.close)
        before = WebSocket(bed.port)
        await_true(lambda: before.message("live")["sensors"][0]["state"] == "ok", "a margin")
        before.message("status")
        before.close()
        bed.slipd.signal(signal.SIGKILL)
        bed.slipd.process.wait()
        page = WebSocket(bed.port)
        first = page.message("live")
        self.assertEqual((first["slipd"], first["sensors"][0]["state"], first["sensors"][0]["alert"]), ("away", "disconnected", "slip"))
        self.assertIsNone(first["sensors"][0]["gamma"])
        page.close()


if __name__ == "__main__":
    if missing():
        print(missing())
        sys.exit(77)
    unittest.main()
