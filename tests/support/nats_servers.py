"""nats-servers with MQTT and JetStream on loopback, as docs/fleet.md sets them up, and as much of NATS's protocol as JetStream's API needs."""
import base64, json, os, shutil, socket, subprocess, time

from ports import free_port

PROGRAM = shutil.which("nats-server", path=os.environ["PATH"] + ":/usr/sbin")
MESSAGES = "$MQTT_msgs"  # nats-server keeps messages of QoS 1 in it
MESSAGES_KEPT_S = 7 * 86400


class Node:
    """A server that can be killed and started again. `port`: of MQTT."""

    def __init__(self, command, port, log, client=None):
        self.command, self.port, self.log, self.client = command, port, log, client
        self.start()

    def start(self):
        with open(self.log, "a") as log:
            self.process = subprocess.Popen(self.command, stdout=log, stderr=log)

    def kill(self):
        self.process.kill()
        self.process.wait()


def start_servers(folder, count=3):
    """A cluster of `count`, or one server by itself."""
    clients, routes, ports = ([free_port() for _ in range(count)] for _ in range(3))
    nodes = []
    for i in range(count):
        path = os.path.join(folder, f"nats{i}.conf")
        with open(path, "w") as file:
            file.write(f'server_name: n{i}\nlisten: "127.0.0.1:{clients[i]}"\n'
                       f'jetstream {{ store_dir: "{folder}/n{i}", max_mem: 256M, max_file: 4G }}\n')
            if count > 1:
                file.write(f'cluster {{ name: fleet, listen: "127.0.0.1:{routes[i]}", '
                           f'routes: [{", ".join(f"nats://127.0.0.1:{r}" for r in routes)}] }}\n')
            file.write(f'mqtt {{ listen: "127.0.0.1:{ports[i]}", stream_replicas: {count}, ack_wait: "5s", max_ack_pending: 1000 }}\n')
        nodes.append(Node([PROGRAM, "-c", path], ports[i], os.path.join(folder, f"nats{i}.log"), clients[i]))
    return nodes


class Nats:
    """A connection that asks."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.file = self.socket.makefile("rb")
        self.file.readline()
        self.socket.sendall(b'CONNECT {"verbose":false}\r\nSUB reply 1\r\n')

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()
        self.socket.close()

    def ask(self, subject, body):
        text = json.dumps(body).encode()
        self.socket.sendall(b"PUB %s reply %d\r\n%s\r\n" % (subject.encode(), len(text), text))
        while line := self.file.readline():
            if line == b"PING\r\n":
                self.socket.sendall(b"PONG\r\n")
            if line.startswith(b"MSG"):
                return json.loads(self.file.read(int(line.split()[-1]) + 2))
        raise OSError("the server has closed the connection")


def ask_any(nodes, subject, body=None, patience_s=120):
    """The first answer without an error, of any server that runs. RuntimeError if there is none in time."""
    last, until = None, time.monotonic() + patience_s
    while time.monotonic() < until:
        for node in nodes:
            try:
                with Nats(node.client) as connection:
                    last = connection.ask(subject, body or {})
                if "error" not in last:
                    return last
            except OSError as error:
                last = error
        time.sleep(0.5)
    raise RuntimeError(f"nats-server, {subject}: {last}")


def make_messages_stream(nodes):
    """The stream of messages of QoS 1, before the first MQTT client connects: nats-server would make one that forgets what no session waits for."""
    ask_any(nodes, f"$JS.API.STREAM.CREATE.{MESSAGES}",
            {"name": MESSAGES, "subjects": ["$MQTT.msgs.>"], "num_replicas": len(nodes), "storage": "file", "retention": "limits",
             "max_age": MESSAGES_KEPT_S * 1_000_000_000, "discard": "old"})


def alerts_in(nodes, stream):
    """(host, number) of the alerts in a stream, in its order."""
    state = ask_any(nodes, f"$JS.API.STREAM.INFO.{stream}")["state"]
    found = []
    with Nats(next(node.client for node in nodes if node.process.poll() is None)) as connection:
        for sequence in range(state["first_seq"], state["last_seq"] + 1):
            got = connection.ask(f"$JS.API.STREAM.MSG.GET.{stream}", {"seq": sequence}).get("message")
            if got and got["subject"].endswith(".alert"):
                found.append((got["subject"].split(".")[-3], json.loads(base64.b64decode(got["data"]))["number"]))
    return found
