"""The page in Debian's Chromium, for tests: a browser, and a test case that has both programs and one."""
import shutil
import unittest

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
except ImportError:
    webdriver = None

from awaiting import await_true

DRIVER = shutil.which("chromedriver")


def missing():
    """Why there is no browser; None: there is."""
    if webdriver is None or DRIVER is None:
        return "chromium-driver and python3-selenium are not installed (tools/setup --peers): skipped"
    return None


def browser(width=1280, height=900):
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", f"--window-size={width},{height}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(DRIVER), options=options)


class PageCase(unittest.TestCase):
    """`bed` and `browser` are the test's."""

    def open(self, where, bed=None):
        self.browser.get("about:blank")
        self.browser.get((bed or self.bed).url + where)

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def module(self, text, *arguments):
        """What the body of an async function returns, which may import the page's modules."""
        answer = self.browser.execute_async_script(
            "const given = [...arguments], done = given.pop(); (async (...arguments_) => {" + text + "})(...given).then((value) => done({ value }), (error) => done({ error: String(error.stack) }));",
            *arguments)
        self.assertNotIn("error", answer)
        return answer["value"]

    def all(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def card(self, name, state):
        """Waits until a card shows this state."""
        return await_true(lambda: self.all(f'.card[data-name="{name}"][data-state="{state}"]'), f"{name} {state}")[0]

    def no_errors(self):
        self.assertEqual([entry for entry in self.browser.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")], [])
