"""The interface of libslipd is what its packages promise: its symbols, and the layout of its struct.

dpkg-gensymbols compares the symbols as Debian's builders do; abidiff, where it is installed, the types with the ABI of the headers."""
import os, re, shutil, subprocess, tempfile, unittest

BUILD, SOURCE = os.environ["SLIPD_BINARY_DIR"], os.environ["SLIPD_SOURCE_DIR"]
LIBRARY = os.path.join(BUILD, "lib", "libslipd.so.0")
SYMBOLS = os.path.join(SOURCE, "packaging", "libslipd0", "symbols")
HEADER = os.path.join(SOURCE, "clients", "c", "slipd.h")

# struct slipd_estimate of soname 0, on 64 bit machines: field, offset, bytes. Programs were compiled with it: a field may replace a
# reserved one, and none may move.
LAYOUT = """name 0 64, state 64 4, alert 68 4, sliding 72 4, event 76 4, simulated 80 4, alert_cause 84 4, sequence 88 8, dropped 96 8,
time_ns 104 8, age_s 112 8, gamma 120 8, sigma 128 8, gamma_low 136 8, friction 144 8, friction_sigma 152 8, normal_n 160 8, shear_n 168 8,
torque_nm 176 8, torque_sigma_nm 184 8, center_x_m 192 8, center_y_m 200 8, radius_m 208 8, time_to_slip_s 216 8, grip_increase_n 224 8,
grip_increase_sigma_n 232 8, sliding_for_s 240 8, valid_until_ns 248 8, shear_x_n 256 8, shear_y_n 264 8, realtime_ns 272 8, reserved 280 40"""
ESTIMATE_BYTES = 320
# Numbers that programs were compiled with.
NUMBERS = {"SLIPD_DONE": 0, "SLIPD_TIMEOUT": 1, "SLIPD_DISCONNECTED": -1, "SLIPD_REFUSED": -2, "SLIPD_INVALID": -3, "SLIPD_NO_MEMORY": -4,
           "SLIPD_ATTACH_ANEW": -5, "SLIPD_STATE_OK": 0, "SLIPD_STATE_NO_CONTACT": 1, "SLIPD_STATE_LEARNING": 2,
           "SLIPD_STATE_OUT_OF_MODEL": 3, "SLIPD_STATE_NO_SHEAR": 4, "SLIPD_STATE_UNZEROED": 5, "SLIPD_STATE_STALE": 6,
           "SLIPD_STATE_FAULT": 7, "SLIPD_STATE_DISCONNECTED": 8, "SLIPD_ALERT_NONE": 0, "SLIPD_ALERT_WARN": 1, "SLIPD_ALERT_SLIP": 2,
           "SLIPD_CAUSE_NONE": 0,
           "SLIPD_CAUSE_MARGIN": 1, "SLIPD_CAUSE_SLIDING": 2, "SLIPD_CAUSE_UNKNOWN": 255, "SLIPD_SLIDING_UNKNOWN": 255, "SLIPD_EVENT_ESTIMATE": 1, "SLIPD_EVENT_ALERT": 2, "SLIPD_EVENT_STATE": 4}


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, **options)


class Abi(unittest.TestCase):
    @unittest.skipUnless(shutil.which("dpkg-gensymbols"), "dpkg-gensymbols is not installed: run tools/setup")
    def test_the_symbols_file_is_that_of_the_library(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "debian"))
            with open(os.path.join(folder, "debian", "control"), "w") as control:
                control.write("Source: slipd\n\nPackage: libslipd0\nArchitecture: any\n")
            # -c4: a symbol that is new, and one that is gone, are both errors.
            ran = run("dpkg-gensymbols", "-plibslipd0", "-v0", f"-e{LIBRARY}", f"-I{SYMBOLS}", "-O", "-c4", cwd=folder)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)

    def test_no_symbol_is_without_a_version(self):
        listed = run("nm", "-D", "--defined-only", "--with-symbol-versions", LIBRARY, check=True).stdout.split("\n")
        for line in filter(None, listed):
            self.assertRegex(line, r"LIBSLIPD_0$")

    def test_the_struct_and_the_numbers_are_those_of_compiled_programs(self):
        fields = [field.split() for field in LAYOUT.replace("\n", " ").split(",")]
        checks = [f"_Static_assert(offsetof(struct slipd_estimate, {name}) == {offset}, \"{name}\");\n"
                  f"_Static_assert(sizeof ((struct slipd_estimate *)0)->{name} == {size}, \"{name}\");" for name, offset, size in fields]
        checks += [f"_Static_assert({name} == {value}, \"{name}\");" for name, value in NUMBERS.items()]
        checks.append(f"_Static_assert(sizeof(struct slipd_estimate) == {ESTIMATE_BYTES}, \"size\");")
        source = f'#include "{HEADER}"\n' + "\n".join(checks)
        ran = run("cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c", "-", input=source)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        with open(HEADER) as header:
            struct = re.search(r"struct slipd_estimate \{(.*?)\};", header.read(), re.S)[1]
        declared = re.findall(r"(\w+)(?:\[\d+\])?\s*[,;]", re.sub(r"/\*.*?\*/", "", struct, flags=re.S))
        self.assertEqual(sorted(declared), sorted(name for name, _, _ in fields), "each field is in the table above")

    @unittest.skipUnless(shutil.which("abidw"), "abidw is not installed: abigail-tools has it")
    def test_abigail_reads_the_library(self):
        ran = run("abidw", "--abidiff", LIBRARY)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)


if __name__ == "__main__":
    unittest.main()
