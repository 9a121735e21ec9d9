#!/usr/bin/env python3
"""The page in a real browser (Debian's Chromium), with the real slipd and simulated fingers.

SLIPD_SCREENSHOTS=FOLDER keeps pictures of the page at three widths in both themes, for whoever changes it to look at.
"""
import itertools
import json
import math
import os
import random
import signal
import sys
import threading
import unittest
from pathlib import Path

try:
    from selenium.common.exceptions import StaleElementReferenceException
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
except ImportError:
    pass

import slipd
from awaiting import await_true
from bed import Bed, of_trials, two_fingers
from page import PageCase, browser, missing

WIDTHS = {390: 844, 1280: 900, 2560: 1440}
TOLD_WITHIN_MS = 1000


def configured(folder):
    return two_fingers(folder, recorder={"seconds": 4})


class Margins(threading.Thread):
    """Every margin that slipd's own socket gives."""

    def __init__(self, path):
        super().__init__(daemon=True)
        self.path, self.seen, self.states, self.stopping = path, set(), set(), False
        self.start()

    def run(self):
        with slipd.Client(str(self.path)) as client:
            for estimate in client.estimates(max_age_s=10):
                self.seen.add(estimate.gamma)
                self.states.add(estimate.state)
                if self.stopping:
                    return


class Page(PageCase):
    @classmethod
    def setUpClass(cls):
        cls.bed = Bed(configured)
        cls.browser = browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.bed.close()

    def setUp(self):
        if self.bed.slipd.process.poll() is not None:
            self.bed.start_slipd()
        self.browser.get_log("browser")
        self.open("#/live")
        self.card("left", "ok")

    def test_the_page_shows_the_margins_of_the_socket(self):
        margins = Margins(self.bed.folder / "slipd.sock")
        await_true(lambda: len(margins.seen) > 10, "margins")
        # What is on the page from now on was sent after the thread had begun.
        shown = self.browser.execute_async_script("""
          const done = arguments[arguments.length - 1], seen = new Set(), begin = performance.now();
          let first = null;
          const look = () => {
            const now = performance.now();
            for (const card of document.querySelectorAll('.card[data-kind="sensor"]')) {
              const text = card.querySelector(".number span").textContent, value = card.dataset.gamma;
              if (now - begin > 500 && value !== "") seen.add(JSON.stringify([Number(value), text]));
            }
            if (seen.size >= 40) done([...seen]); else requestAnimationFrame(look);
          };
          look();""")
        await_true(lambda: all(json.loads(each)[0] in margins.seen for each in shown), "the thread")
        margins.stopping = True
        for each in shown:
            value, text = json.loads(each)
            self.assertEqual(text, f"{value:.2f}")
        self.no_errors()

    def test_states_and_alerts_change_on_the_page(self):
        for state, words in (("no_contact", "nothing touches"), ("learning", "let it slip once or give a friction"), ("ok", "the margin is measured")):
            card = self.card("left", state) if state != "learning" else None
            if card is None:
                continue
            await_true(lambda words=words, card=card: words in card.find_element(By.CSS_SELECTOR, ".state").text, words)
        await_true(lambda: self.all('.card[data-name="left"][data-alert="slip"]'), "an alert of slip")
        await_true(lambda: self.all('.card[data-name="left"][data-alert="none"]'), "no alert")
        said = await_true(lambda: self.script("return document.querySelector('.said').textContent"), "the alert for those who cannot see")
        self.assertRegex(said, "(left|right|gripper): ")
        self.no_errors()

    def test_no_margin_is_shown_without_the_state_ok(self):
        wrong = self.browser.execute_async_script("""
          const done = arguments[arguments.length - 1], wrong = [], states = new Set(), begin = performance.now();
          const look = () => {
            for (const card of document.querySelectorAll(".card[data-name]")) {
              states.add(card.dataset.state);
              const number = card.querySelector(".number span").textContent, dial = card.querySelector(".dial"), low = card.querySelector("p.low").textContent;
              if (card.dataset.state === "ok") continue;
              if (number !== "–" || dial.hasAttribute("aria-valuenow") || dial.querySelector(".low").getAttribute("d")) wrong.push(card.dataset.state + number);
              if (!/^no (margin|lower bound)/.test(low)) wrong.push(card.dataset.state + low);
            }
            if (states.size >= 2 && performance.now() - begin > 4000) done(wrong); else requestAnimationFrame(look);
          };
          look();""")
        self.assertEqual(wrong, [])

    def test_a_lower_bound_without_a_margin_does_not_look_like_one(self):
        def shown(**estimate):
            return self.browser.execute_async_script("""
              const done = arguments[arguments.length - 1], estimate = arguments[0];
              import("./card.js").then(({ Card }) => {
                const card = new Card("any", "sensor");
                document.querySelector(".cards").append(card.element);
                card.show(estimate);
                const low = card.element.querySelector("p.low"), number = card.element.querySelector(".number");
                const size = (element) => Number.parseFloat(getComputedStyle(element).fontSize);
                done({ number: number.textContent, low: low.textContent, small: size(low) < size(document.body) && size(low) < 0.5 * size(number),
                       muted: getComputedStyle(low).color !== getComputedStyle(document.body).color,
                       marked: Boolean(card.element.querySelector(".dial .low").getAttribute("d")) });
                card.element.remove();
              });""", {"sensor": "any", "alert": "none", "gamma": None, "sigma": None, **estimate})
        # Hardly any tangential load: the bound is near 1 although nothing is known of the contact.
        for state in ("out_of_model", "learning", "no_shear", "unzeroed", "fault"):
            card = shown(state=state, gamma_low=0.97)
            self.assertEqual((card["number"], card["marked"]), ("–", False), state)
            self.assertRegex(card["low"], r"^no margin; lower bound 0\.97", state)
            self.assertTrue(card["small"] and card["muted"], card)
        self.assertEqual(shown(state="out_of_model", gamma_low=None)["low"], "no lower bound")
        card = shown(state="ok", gamma=0.62, sigma=0.01, gamma_low=0.59)
        self.assertEqual((card["number"], card["low"], card["marked"]), ("0.62 ± 0.01", "lower bound 0.59 (95\u00a0%)", True))
        self.no_errors()

    def test_simulated_is_marked(self):
        for name in ("left", "right", "gripper"):
            card = self.all(f'.card[data-name="{name}"]')[0]
            self.assertTrue(card.find_element(By.CSS_SELECTOR, ".simulated").is_displayed(), name)

    def test_pictures_of_the_sensor_that_is_looked_at_follow_each_other(self):
        first = await_true(lambda: self.script("return document.querySelector('canvas.map').dataset.sequence"), "a picture")
        await_true(lambda: int(self.script("return document.querySelector('canvas.map').dataset.sequence")) > int(first) + 3, "a later picture")
        self.no_errors()

    def test_the_stick_zone_on_the_picture_is_that_of_the_margin(self):
        def seen():
            margin, stick = self.script("""return [document.querySelector('.card[data-name="left"]').dataset.gamma,
                                                   document.querySelector('canvas.map').dataset.stick].map(Number.parseFloat)""")
            # Far from both ends, where any circle would do, and of one moment: the picture may be older than the card.
            return margin is not None and stick is not None and 0.2 < margin < 0.8 and abs(stick ** 3 - margin) < 0.02
        await_true(seen, "the margin's stick zone")
        self.no_errors()

    WATCH = """
      window.told = null;
      window.heard = performance.now();
      const send = WebSocket.prototype.send;  // the page answers each message
      WebSocket.prototype.send = function (text) { window.heard = performance.now(); return send.call(this, text); };
      const sign = document.getElementById("link");
      new MutationObserver(() => { if (sign.dataset.state === "away" && window.told === null) window.told = performance.now(); })
        .observe(sign, { attributes: true });
    """

    def told(self, what, silent=False):
        """How long it takes, ms: after `what`, or after the last message where there are none any more."""
        self.script(self.WATCH)
        before = self.script("return performance.now()")
        what()
        shown = await_true(lambda: self.script("return window.told"), "the page says it")
        if silent:
            before = self.script("return window.heard")
        state = await_true(lambda: self.all('.card[data-name="left"][data-state="disconnected"]'), "no margin")[0]
        self.assertEqual(state.find_element(By.CSS_SELECTOR, ".number span").text, "–")
        return shown - before

    def test_a_slipd_that_was_stopped_is_told_within_a_second(self):
        self.assertLess(self.told(lambda: self.bed.slipd.signal(signal.SIGKILL)), TOLD_WITHIN_MS)
        self.assertIn("slipd", self.all(".lost")[0].text)
        self.bed.slipd.process.wait()
        self.bed.start_slipd()
        self.card("left", "ok")
        self.assertFalse(self.all(".lost")[0].is_displayed())

    def test_a_slipd_that_hangs_is_told_within_a_second(self):
        try:
            self.assertLess(self.told(lambda: self.bed.slipd.signal(signal.SIGSTOP)), TOLD_WITHIN_MS)
        finally:
            self.bed.slipd.signal(signal.SIGCONT)
        self.card("left", "ok")

    def test_a_slipd_web_that_hangs_is_told_within_a_second(self):
        try:
            self.assertLess(self.told(lambda: self.bed.web.signal(signal.SIGSTOP), silent=True), TOLD_WITHIN_MS)
        finally:
            self.bed.web.signal(signal.SIGCONT)
        self.card("left", "ok")

    def test_everything_that_is_used_has_a_name(self):
        for where in ("#/live", "#/recordings", "#/method"):
            self.script("location.hash = arguments[0]", where)
            await_true(lambda where=where: self.all(f'nav a[href="{where}"][aria-current]'), where)
            for element in self.all("a, button, input, select, canvas, [role=meter], section, article"):
                try:
                    if element.is_displayed():
                        self.assertTrue(element.accessible_name, element.get_attribute("outerHTML")[:120]) if element.tag_name != "section" else None
                except StaleElementReferenceException:
                    pass
            self.assertEqual(len(self.all("h1")), 1)
            self.assertEqual(self.all("main")[0].aria_role, "main")

    def test_the_keyboard_reaches_everything(self):
        reached = set()
        for _ in range(20):
            self.browser.switch_to.active_element.send_keys(Keys.TAB)
            reached.add(self.script("return document.activeElement.textContent.trim().slice(0, 12) || document.activeElement.tagName"))
        self.assertLessEqual({"Live", "Recordings", "Method", "Details", "60 s"}, reached)
        details = self.all('.card[data-name="gripper"] button')[0]
        details.send_keys(Keys.ENTER)
        self.assertEqual(details.get_attribute("aria-pressed"), "true")

    def test_scripts_within_the_page_do_not_run(self):
        self.script("""const script = document.createElement("script"); script.textContent = "window.inside = true"; document.body.append(script);
                       const image = document.createElement("img"); image.src = "https://elsewhere.example/x.png"; document.body.append(image);""")
        self.assertIsNone(self.script("return window.inside ?? null"))
        await_true(lambda: len([e for e in self.browser.get_log("browser") if "Content Security Policy" in e["message"]]) >= 1, "two reports")

    def test_recordings_are_listed_and_play(self):
        with slipd.Client(str(self.bed.folder / "slipd.sock")) as client:
            await_true(lambda: list((self.bed.folder / "recordings").glob("*.rec")), "a recording")
            del client
        self.script("location.hash = '#/recordings'")
        link = await_true(lambda: self.all("td a"), "the list")[0]
        name = link.text
        recording = slipd.open(self.bed.folder / "recordings" / name)
        frames = {frame.seq: frame for frame in recording}
        link.click()
        scrub = await_true(lambda: self.all("input[type=range]"), "the player")[0]
        self.assertAlmostEqual(float(scrub.get_attribute("max")), max(frame.time_s for frame in frames.values()), places=3)
        # Frames that slipd had no processor for have no estimate, and end no alert.
        alerts = [frame.estimate["alert"] for frame in sorted(frames.values(), key=lambda frame: frame.seq) if frame.estimate]
        slips = [now for before, now in zip([None, *alerts], alerts) if now == "slip" and before != "slip"]
        self.assertEqual(len(self.all('[aria-label^="Go to the slip"]')), min(len(slips), 12))
        play = self.all('button[aria-label="Play or pause"]')[0]
        at = lambda: int(self.script("return document.querySelector('canvas.map').dataset.sequence"))
        before = at()
        self.all('option[value="0.02"]')[0].click()  # so slow that it does not end meanwhile
        play.click()
        await_true(lambda: at() > before + 5, "it plays")
        play.click()
        self.assertIn("Play", play.text)
        before = at()
        self.all('button[aria-label="One frame on"]')[0].click()
        self.assertEqual(at(), before + 1)
        moment = frames[before + 1]
        shown = self.all(".facts")[-1].text
        self.assertIn(f"{moment.time_s:.3f} s", shown)
        estimate = moment.estimate or {}  # a frame that was skipped has none
        if estimate.get("state") == "ok":
            self.assertIn(f"{estimate['gamma']:.2f}", shown)
        address = self.all(".bar a")[0].get_attribute("href")
        self.browser.get("about:blank")
        self.browser.get(address)
        await_true(lambda: self.all("input[type=range]"), "the player")
        self.assertEqual(at(), before + 1)
        self.no_errors()

    def test_the_method_is_explained(self):
        self.script("location.hash = '#/method'")
        text = await_true(lambda: [each.text for each in self.all("main .card") if "moments" in each.text], "the sensor")[0]
        self.assertIn("second moments", text)
        self.assertIn("The configuration names it", text)
        self.assertNotIn("auto", text)
        self.no_errors()

    def test_pictures_at_all_sizes(self):
        folder = os.environ.get("SLIPD_SCREENSHOTS")
        if folder:
            self.browser.set_script_timeout(60)
            self.browser.execute_async_script("setTimeout(arguments[0], 12000)")  # a history to look at
        for theme in ("dark", "light"):
            if self.script("return document.documentElement.dataset.theme") != theme:
                self.all("#theme")[0].click()
            for width, height in WIDTHS.items():
                self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
                self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), width)
                if folder:
                    self.keep(Path(folder), f"{width}-{theme}")
        self.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        self.no_errors()

    def keep(self, folder, name):
        folder.mkdir(parents=True, exist_ok=True)
        for page, where in {"recordings": "#/recordings", "method": "#/method", "live": "#/live"}.items():
            self.script("location.hash = arguments[0]", where)
            if page == "live":
                await_true(lambda: self.script("""const card = document.querySelector('.card[data-name="left"]');
                  return card.dataset.state === "ok" && card.dataset.gamma > 0.1 && card.dataset.gamma < 0.7"""), "a good moment")
            else:
                await_true(lambda: self.all("main .card"), page)
            self.browser.save_screenshot(str(folder / f"{page}-{name}.png"))


class GelPage(PageCase):
    """A camera that looks at a gel: a program pushes its displacement, in mm."""

    MOVED_MM = 0.4

    @classmethod
    def setUpClass(cls):
        sensor = {"name": "gel", "driver": "push", "rate_hz": 25, "stale_after_ms": 5000, "layout": {"grid": [9, 7], "pitch_mm": 1.8}, "options": {"unit": "mm"}}
        cls.bed = Bed(of_trials(sensor))
        cls.browser = browser()
        cls.ended = threading.Event()
        cls.pushing = threading.Thread(target=cls.push)
        cls.pushing.start()

    @classmethod
    def tearDownClass(cls):
        cls.ended.set()
        cls.pushing.join()
        cls.browser.quit()
        cls.bed.close()

    @classmethod
    def push(cls):
        noise = random.Random(1)

        def frame(moved_mm):
            for row in range(7):
                for column in range(9):
                    near = math.exp(-((column - 4) ** 2 + (row - 3) ** 2) / 4)
                    yield from (moved_mm * near + noise.gauss(0, 0.002), noise.gauss(0, 0.002), 0.3 * near)
        with slipd.Source("gel", taxels=63, unit="mm", rate_hz=25, zeroed=True, path=f"{cls.bed.folder}/slipd.sock") as source:
            for picture in itertools.count():
                source.push(list(frame(cls.MOVED_MM if picture > 50 else 0)))
                if cls.ended.wait(0.04):
                    return

    def test_shows_how_far_the_surface_has_moved_in_mm_and_no_pressure_and_no_margin(self):
        self.open("#/live/gel")
        caption = lambda: self.script("return document.querySelector('figcaption').textContent")
        await_true(lambda: f"up to {self.MOVED_MM:.2f} mm" in caption() or f"up to {self.MOVED_MM + 0.01:.2f} mm" in caption(), "the displacement")
        self.assertNotIn("Pa", caption())
        await_true(lambda: int(self.script("return document.querySelector('canvas.map').dataset.arrows")) > 5, "arrows")
        card = self.all('.card[data-name="gel"]')[0]
        self.assertRegex(card.text, r"0\.\d\d mm from rest, in contact")
        self.assertEqual(card.find_element(By.CSS_SELECTOR, ".number span").text, "–")
        if folder := os.environ.get("SLIPD_SCREENSHOTS"):
            self.browser.save_screenshot(str(Path(folder) / "gel.png"))
        self.no_errors()


if __name__ == "__main__":
    if missing():
        print(missing())
        sys.exit(77)
    unittest.main()
