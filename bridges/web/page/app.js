// The page's frame: which page is shown, the theme, and how the connection is.
import { setData, setText } from "./dom.js";
import { Link } from "./link.js";
import { LivePage } from "./live.js";
import { MethodPage } from "./method.js";
import { RecordingsPage } from "./recordings.js";

const link = new Link();
const pages = { live: new LivePage(link), recordings: new RecordingsPage(), method: new MethodPage() };
const main = document.getElementById("main"), sign = document.getElementById("link");
let shown = null;

// #/live, #/live/NAME, #/recordings, #/recordings/FILE@SECONDS, #/method
function route() {
  const [name = "live", ...rest] = location.hash.replace(/^#\/?/, "").split("/");
  const page = pages[name] ?? pages.live;
  if (shown !== page) {
    shown?.hide();
    main.replaceChildren(page.element);
    shown = page;
  }
  for (const entry of document.querySelectorAll("nav a")) {
    if (entry.hash === `#/${page === pages.live ? "live" : name}`) entry.setAttribute("aria-current", "page");
    else entry.removeAttribute("aria-current");
  }
  page.show(decodeURIComponent(rest.join("/")));
}

function say(state, text) {
  setData(sign, "state", state);
  setText(sign, text);
}

link.addEventListener("live", ({ detail }) => (detail.slipd === "ok" ? say("live", "live") : say("away", "slipd is not reached")));
link.addEventListener("lost", () => say("away", "no connection"));

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  window.dispatchEvent(new Event("resize"));  // canvases are drawn anew
}

const dark = window.matchMedia("(prefers-color-scheme: dark)");
let chosen = null;
try { chosen = localStorage.getItem("theme"); } catch { /* no storage is allowed: the system's theme */ }
setTheme(chosen ?? (dark.matches ? "dark" : "light"));
dark.addEventListener("change", () => { if (!chosen) setTheme(dark.matches ? "dark" : "light"); });
document.getElementById("theme").addEventListener("click", () => {
  chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  try { localStorage.setItem("theme", chosen); } catch { /* as above */ }
  setTheme(chosen);
});

window.addEventListener("hashchange", route);
route();
