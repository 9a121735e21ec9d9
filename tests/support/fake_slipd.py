"""A stand-in for slipd's socket: sensors with recorded-like estimates and alerts on command. One thread serves any number of sockets,
so that hundreds of grippers fit on a machine."""
import json, math, os, selectors, socket, struct, threading, time


class FakeSlipd:
    """One slipd. `estimate` and `alert` may be called from any thread; what a client does not take in time is dropped."""

    def __init__(self, path, sensors, server, grasps=()):
        self.path, self.sensors, self.server = path, list(sensors), server
        self.grasps = {name: {} for name in grasps}  # of all sensors: members of the next answers
        self.alerts = {}  # by sensor: the alert that stands
        self.sequence = 0
        self.clients = []  # [socket, input, events, next due, period]
        self.recordings = []  # [client, the end into which its frames are written]
        self.lock = threading.Lock()
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen(16)
        self.listener.setblocking(False)
        server.add(self.listener, self._accept)

    def close(self):
        with self.lock:
            clients, self.clients = self.clients, []
        for client in clients:
            self.server.remove(client["socket"])
        self.server.remove(self.listener)
        os.unlink(self.path)

    def message(self, sensor, **members):
        self.sequence += 1
        gamma = 0.5 + 0.4 * math.sin(self.sequence / 50)
        level = self.alerts.get(sensor, "none")
        return {"sensor": sensor, "seq": self.sequence, "time_ns": time.time_ns(), "state": "ok", "gamma": gamma, "sigma": 0.02,
                "class": min(4, int(5 * gamma)) + 1, "gamma_low": gamma - 0.03, "friction": 0.45, "friction_sigma": 0.02, "normal_n": 2.1,
                "shear_n": 0.36, "torque_nmm": 0.4, "torque_sigma_nmm": 0.02, "turned_deg": None, "turned_sigma_deg": None,
                "center_mm": [0.1, -0.4], "radius_mm": 3.1, "a_over_r": 0.31, "time_to_slip_ms": None, "grip_increase_n": 0.0,
                "grip_increase_sigma_n": 0.1, "alert": level, "alert_cause": "margin" if level in ("warn", "slip") else None,
                "sliding": "none", "sliding_for_ms": 812, "method": "registered", "health": "good", "simulated": True, "latency_us": 35.2,
                "age_ms": 0.8} | members

    def grasp(self, name):
        return {"grasp": name, "sensors": self.sensors, "state": "ok", "gamma": 0.5, "sigma": 0.02, "class": 3, "gamma_low": 0.45, "friction": 0.45,
                "friction_sigma": 0.02, "normal_n": 4.2, "shear_n": 0.7, "time_to_slip_ms": None, "grip_increase_n": 0.0, "grip_increase_sigma_n": 0.1,
                "alert": "none", "alert_cause": None, "sliding": "none", "sliding_for_ms": 812,
                "first": {"sensor": self.sensors[0], "gamma": 0.5}} | self.grasps[name]

    def send(self, event, params):
        line = (json.dumps({"jsonrpc": "2.0", "method": event, "params": params | {"dropped": 0}}) + "\n").encode()
        with self.lock:
            for client in self.clients:
                if event in client["events"]:
                    try:
                        client["socket"].send(line, socket.MSG_DONTWAIT)
                    except OSError:
                        pass

    def estimate(self, sensor, **members):
        self.send("estimate", self.message(sensor, **members))

    def alert(self, sensor, level=None, **members):
        """Without a level another one than that which stands, as slipd tells of changes only: slip, or warn after slip."""
        level = level or ("warn" if self.alerts.get(sensor) == "slip" else "slip")
        self.alerts[sensor] = level
        params = self.message(sensor, gamma=0.1, **members)
        self.send("alert", params)
        return params["seq"]

    def subscribers(self, process=None):
        """How many there are; with the id of a process, of its own."""
        with self.lock:
            return sum("estimate" in client["events"] and process in (None, client["process"]) for client in self.clients)

    def _accept(self):
        connection, _ = self.listener.accept()
        process, _, _ = struct.unpack("3i", connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))
        client = {"socket": connection, "process": process, "input": b"", "events": ()}
        with self.lock:
            self.clients.append(client)
        self.server.add(connection, lambda: self._read(client))

    def _read(self, client):
        try:
            got = client["socket"].recv(65536)
        except OSError:
            got = b""
        if not got:
            with self.lock:
                if client in self.clients:
                    self.clients.remove(client)
            self.server.remove(client["socket"])
            return
        *lines, client["input"] = (client["input"] + got).split(b"\n")
        for line in lines:
            request = json.loads(line)
            answer = self._answer(client, request["method"], request.get("params") or {})
            line = (json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": answer}) + "\n").encode()
            if request["method"] == "record":
                frames, passed = socket.socketpair()
                with passed:
                    socket.send_fds(client["socket"], [line], [passed.fileno()])
                self.recordings.append((client, frames))
            else:
                client["socket"].sendall(line)

    def recorded(self, number, content, trouble=None):
        """Writes what a client gets of its recording, and tells it that this is all."""
        client, frames = self.recordings[number]
        with frames:
            frames.sendall(content)
        params = {"recording": number + 1, "sensor": self.sensors[0], "frames": 2, "missed": 0, "bytes": len(content), "seconds": 0.5, "trouble": trouble}
        client["socket"].sendall((json.dumps({"jsonrpc": "2.0", "method": "recorded", "params": params}) + "\n").encode())

    def _answer(self, client, method, params):
        if method == "version":
            return {"name": "slipd", "version": "0.1.0", "protocol": 1}
        if method == "sensors":
            return {"sensors": [{"name": name, "driver": "sim", "class": "wrench", "taxels": 1, "rate_hz": 100.0, "simulated": True}
                                for name in self.sensors]}
        if method == "gamma":
            return {"sensors": [self.message(name) for name in self.sensors], "grasps": [self.grasp(name) for name in self.grasps]}
        if method == "subscribe":
            client["events"] = tuple(params.get("events", ["estimate"]))
            return {"subscription": 1}
        if method == "record":
            return {"recording": len(self.recordings) + 1, "sensor": params["sensor"]}
        return {}


class Server:
    """The thread that serves FakeSlipds."""

    def __init__(self):
        self.selector = selectors.DefaultSelector()
        self.wake, self.woken = socket.socketpair()
        self.selector.register(self.woken, selectors.EVENT_READ, lambda: self.woken.recv(4096))
        self.ends = False
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def add(self, sock, handler):
        self.selector.register(sock, selectors.EVENT_READ, handler)
        self.wake.send(b"x")

    def remove(self, sock):
        try:
            self.selector.unregister(sock)
        except (KeyError, ValueError):
            pass
        sock.close()

    def close(self):
        self.ends = True
        self.wake.send(b"x")
        self.thread.join()

    def _run(self):
        while not self.ends:
            for key, _ in self.selector.select():
                try:
                    key.data()
                except OSError:
                    pass
