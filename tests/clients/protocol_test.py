"""docs/socket.md, both clients and what slipd serves have the same methods and parameters."""
import json, os, re, unittest

from python_test import PATIENCE_S, Daemon
import slipd

SOURCE = os.environ["SLIPD_SOURCE_DIR"]
CODE = re.compile(r"`([^`]+)`")


def text_of(*path):
    with open(os.path.join(SOURCE, *path), encoding="utf-8") as file:
        return file.read()


def documented():
    """Of each method in the table of docs/socket.md: its parameters, and whether each is required."""
    table = text_of("docs", "socket.md").split("| method, parameters")[1].split("\n\n")[0]
    methods = {}
    for row in table.splitlines()[2:]:
        cell = CODE.findall(row.split(" | ")[0])
        keys = {key: mark != "?" for part in cell if part[0] == "{" for key, mark in re.findall(r'"(\w+)"(\??)', part)}
        methods.update({name: keys for name in cell if name[0] != "{"})
    return methods


class Protocol(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.close)
        cls.client = slipd.Client(cls.daemon.socket, timeout_s=PATIENCE_S)
        cls.addClassCleanup(cls.client.close)
        cls.document = cls.client.call("rpc.discover")
        cls.methods = {method["name"]: {each["name"]: each["required"] for each in method["params"]} for method in cls.document["methods"]}

    def test_the_page_has_the_methods_and_parameters_that_slipd_serves(self):
        self.assertEqual(documented(), self.methods)

    def test_it_is_an_openrpc_document(self):
        self.assertRegex(self.document["openrpc"], r"^1\.2\.")
        self.assertEqual(self.document["info"]["version"], self.client.call("version")["version"])
        for method in self.document["methods"]:
            self.assertLessEqual({"name", "params", "result"}, set(method))
            self.assertLessEqual({"name", "schema"}, set(method["result"]))
            for parameter in method["params"]:
                self.assertLessEqual({"name", "schema"}, set(parameter))

    def test_each_method_is_served_with_these_parameters_and_no_others(self):
        for name, parameters in self.methods.items():
            with self.assertRaises(slipd.SlipdError, msg=name) as refused:
                self.client.call(name, {"nonsense": 1})
            self.assertEqual(refused.exception.code, -32602, name)
            expected = 'there is no parameter "nonsense"' + ("; there are: " + ", ".join(parameters) if parameters else "")
            self.assertEqual(str(refused.exception), expected)
            for parameter, required in parameters.items():
                if required and name != "record":  # which has two, and misses the first
                    with self.assertRaisesRegex(slipd.SlipdError, parameter):
                        self.client.call(name)

    def asked(self, text, call, keys):
        """The methods that a source asks for, with the parameters on the same line."""
        found = {}
        for line in text.splitlines():
            for name in re.findall(call, line):
                found.setdefault(name, set()).update(re.findall(keys, line.split(name, 1)[1]))
        return found

    def test_the_clients_ask_for_methods_and_parameters_that_exist(self):
        python = self.asked(text_of("clients", "python", "slipd", "__init__.py"), r'(?:call|request|_send)\("([\w.]+)"', r'"(\w+)":')
        folder = os.path.join(SOURCE, "clients", "c")
        sources = "".join(text_of("clients", "c", name) for name in os.listdir(folder) if name.endswith(".cpp"))
        c = self.asked(sources, r'(?:call|request)\((?:\*?s, )?"([\w.]+)"', r'\{"(\w+)":')
        self.assertLessEqual({"gamma", "sensors", "status", "frame", "record", "subscribe", "attach"}, set(python))
        self.assertLessEqual({"gamma", "sensors", "status", "frame", "subscribe", "attach"}, set(c) | {"sensors", "status"})
        for client in (python, c):
            for name, parameters in client.items():
                self.assertIn(name, self.methods)
                self.assertLessEqual(parameters, set(self.methods[name]), name)

    def test_the_clients_know_every_number_and_key_of_the_shared_memory(self):
        page = text_of("docs", "clients.md")
        rows = {int(row[0]): row[1] for row in re.findall(r"^\| (19\d) \| u8 \| (.*) \|$", page, re.MULTILINE)}
        for at, names in ((192, slipd._STATES), (193, slipd._ALERTS), (195, slipd._METHODS), (196, slipd._HEALTHS), (197, slipd._SLIDINGS)):
            numbers = [(int(number), name) for number, name in re.findall(r"\b(\d+) ([a-z_-]+)", rows[at])]
            self.assertEqual([each for each in numbers if each != (slipd._UNKNOWN, "unknown")], list(enumerate(names)), at)
        states = re.findall(r"SLIPD_STATE_(\w+) = (\d)", text_of("clients", "c", "slipd.h"))
        self.assertEqual([name.lower() for name, _ in states][:8], list(slipd._STATES))
        self.assertEqual([int(number) for _, number in states], list(range(9)))


if __name__ == "__main__":
    unittest.main()
