"""The pictures of docs/performance.md, by gnuplot and growth.gp."""
import pathlib
import shutil
import subprocess

from measured import METHODS

HERE = pathlib.Path(__file__).resolve().parent


def draw(of, docs, folder):
    """Whether there is a gnuplot to draw them."""
    gnuplot = shutil.which("gnuplot")
    if gnuplot is None:
        return False
    out = docs / "performance"
    out.mkdir(parents=True, exist_ok=True)

    def data(name, rows):
        (folder / f"{name}.dat").write_text("\n".join(" ".join("NaN" if v is None else str(v) for v in row) for row in rows) + "\n")
    data("taxels", [[side * side] + [of.method(name, side).get("p50_us") for name in METHODS] for side in (4, 8, 16, 32, 64, 100, 160, 256)])
    data("points", [[size, of.estimators.get(f"points/svd-knn/{size}", {}).get("p50_us")] for size in (1000, 10000, 100000, 1000000)])
    data("sensors", [[each["sensors"], 100 * each["cpu"], each["p50_us"], each["p99_us"]] for each in of.of("sensors")])
    data("clients", [[clients] + [of.queries(server, clients).get("per_s") for server in ("slipd", "redis")]
                     for clients in (1, 10, 100)])
    for name in ("taxels", "points", "sensors", "clients"):
        subprocess.run([gnuplot, "-e", f"data = '{folder / (name + '.dat')}'; picture = '{out / (name + '.svg')}'; which = '{name}'",
                        str(HERE / "growth.gp")], check=True)
    return True
