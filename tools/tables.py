"""Splits a long generated text into pages of docs/tables, each with its date, commit, machine and command, and writes each table as CSV, too."""
import csv
import datetime
import pathlib
import platform
import re
import subprocess

SLUGS = {
    "Requirements and results": "requirements",
    "Error against run time": "tradeoff",
    "Few taxels and one force vector: over a grasp": "few-taxels",
    "A grasp's history": "histories",
    "What is known of friction": "friction",
    "Sigma over a grasp": "coverage",
    "Frames that are skipped": "overload",
    "Torque": "torque",
    "Skins and ellipses": "skins",
    "The paper's experiment": "paper",
    "Extremes": "extremes",
    "Extremes of force and torque": "extremes-torque",
    "Condition": "condition",
    "Deviations from the contact model": "deviations",
}


KEPT = "(kept)"  # stands in a section that was not measured again: its page and tables stay as they are


def stamp(root, command, machine=None):
    """When, where and by what the tables were measured: one sentence for the head of a page."""
    def git(*words):
        return subprocess.run(["git", "-C", root, *words], capture_output=True, text=True, check=True).stdout.strip()

    changed = " with changes" if git("status", "--porcelain", "--untracked-files=no") else ""
    return f"Measured on {datetime.date.today()} at commit {git('rev-parse', '--short', 'HEAD')}{changed} on {machine or platform.machine()} by `{command}`."


def processor():
    """The name of this machine's processor."""
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def markdown(head, rows):
    """A table as Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def replace_between(page, begin, end, text):
    """Puts `text` in place of what `page`, a path, has between two marks."""
    before, _, rest = page.read_text().partition(begin)
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{rest.partition(end)[2]}")


def cells(line):
    return [cell.strip().strip("*") for cell in line.strip().strip("|").split("|")]


def tables(text):
    """The tables of a Markdown text: lists of rows, the first of which is the head."""
    blocks = re.findall(r"(?:^\|.*\n?)+", text, re.MULTILINE)
    return [[cells(line) for at, line in enumerate(block.splitlines()) if at != 1] for block in blocks]


def from_below(text):
    """Links of a page of docs/, as a page of docs/tables needs them."""
    return re.sub(r"\]\((?!https?:|#)([\w./#-]+)\)", lambda link: f"]({link[1]})" if link[1].startswith("../") else f"](../{link[1]})", text)


def write(text, folder, stamped):
    """Writes each section of `text` to folder/SLUG.md, its tables to folder/SLUG.csv (SLUG-2.csv, …), and the head to folder/README.md."""
    folder.mkdir(exist_ok=True)
    head, *sections = re.split(r"^## ", text, flags=re.MULTILINE)
    index = []
    for section in sections:
        heading, body = section.split("\n", 1)
        slug = SLUGS[heading]
        index.append(f"* [{heading}]({slug}.md)")
        if KEPT in body:
            continue
        names = [f"{slug}{f'-{at}' if at > 1 else ''}.csv" for at in range(1, len(tables(body)) + 1)]
        for name, rows in zip(names, tables(body)):
            with open(folder / name, "w", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)
        links = ", ".join(f"[{name}]({name})" for name in names)
        (folder / f"{slug}.md").write_text(f"# {heading}\n\n{stamped} Terms: [README.md](README.md). As CSV: {links}.\n\n{from_below(body).strip()}\n",
                                           encoding="utf-8")
    (folder / "README.md").write_text(f"{from_below(head).strip()}\n\n{stamped}\n\n" + "\n".join(index) + "\n", encoding="utf-8")
