"""A gel on a rigid base, pressed and dragged by a rigid object with friction: CalculiX's input, and what it has found.

Lengths mm, forces N, stresses MPa. The gel is a plate, much wider than the contact, bonded below. The object moves along x, so that
half of it is enough: y >= 0, mirrored at y = 0. Small displacements, linear elasticity; Coulomb friction with a penalty.
"""
from dataclasses import dataclass
from functools import cached_property

import numpy as np

THICKNESS = 4.0
YOUNG = 0.3  # only scales forces
POISSON = 0.45  # near rubber, and not so near that the elements lock


@dataclass(frozen=True)
class Object:
    name: str
    depth: float  # how far it is pressed in
    shift: float  # how far it is dragged after that
    friction: float = 0.5

    def height(self, r):
        """Of its surface over its lowest point."""
        if self.name == "sphere":
            return r**2 / (2 * 50.0)
        return np.maximum(0, r - 1.5) ** 2 / (2 * 2.0)  # a flat punch whose edge is rounded


OBJECTS = (Object("sphere", depth=0.08, shift=0.055), Object("punch", depth=0.03, shift=0.055))


@dataclass(frozen=True)
class Mesh:
    cell: float  # side of the elements near the contact
    reach: float = 3.0  # half the side of that part
    far: float = 16.0  # half the gel's width
    layers: int = 0  # even ones; 0: thin ones above, thicker ones below

    @property
    def near(self):
        """Small cells from the middle to the edge of their part."""
        return round(self.reach / self.cell)

    @property
    def first(self):
        """Index along x of the first of them."""
        return len(self.y) - 1 - self.near

    @cached_property
    def y(self):
        return np.concatenate([np.arange(self.near + 1) * self.cell, graded(self.reach, self.cell, self.far, 1.4)])

    @cached_property
    def x(self):
        return np.concatenate([-self.y[:0:-1], self.y])

    @cached_property
    def z(self):
        down = np.linspace(0, THICKNESS, self.layers + 1)[1:] if self.layers else graded(0, self.cell / 2, THICKNESS, 1.35)
        return -np.concatenate([[0], down])

    def node(self, i, j, k):
        return 1 + i + len(self.x) * (j + len(self.y) * k)

    def top_cells(self):
        """(i, j) of the elements below the part near the contact, all of them in one grid."""
        return [(self.first + i, j) for j in range(self.near) for i in range(2 * self.near)]


def graded(start, step, end, ratio):
    """Places after start, up to end, each step longer than the one before by about the ratio."""
    places = []
    at = start
    while at < end:
        at += step
        places.append(at)
        step *= ratio
    return start + (np.array(places) - start) * (end - start) / (places[-1] - start)


def hexahedron(node, i, j, below, above):
    return [node(i, j, below), node(i + 1, j, below), node(i + 1, j + 1, below), node(i, j + 1, below),
            node(i, j, above), node(i + 1, j, above), node(i + 1, j + 1, above), node(i, j + 1, above)]


def lines(keyword, rows):
    return keyword + "\n" + "".join(",".join(f"{each:.9g}" if isinstance(each, float) else str(each) for each in row) + "\n" for row in rows)


def gel_part(mesh):
    x, y, z = mesh.x, mesh.y, mesh.z
    nodes = [(mesh.node(i, j, k), float(x[i]), float(y[j]), float(z[k]))
             for k in range(len(z)) for j in range(len(y)) for i in range(len(x))]
    last = len(z) - 1
    named = [(i, j, k) for k in (0, last - 1) for i, j in mesh.top_cells()]  # first: element n is cell n - 1 of them
    taken = set(named)
    others = [(i, j, k) for k in range(last) for j in range(len(y) - 1) for i in range(len(x) - 1)]
    cells = named + [cell for cell in others if cell not in taken]
    elements = [[number + 1, *hexahedron(mesh.node, i, j, k + 1, k)] for number, (i, j, k) in enumerate(cells)]
    return (lines("*NODE", nodes) + lines("*ELEMENT,TYPE=C3D8I,ELSET=GEL", elements) +
            lines("*ELSET,ELSET=TOP,GENERATE", [(1, len(named) // 2)]) + lines("*ELSET,ELSET=BOTTOM,GENERATE", [(len(named) // 2 + 1, len(named))]) +
            lines("*NSET,NSET=SURFACE", [(mesh.node(i, j, 0),) for j in range(len(y)) for i in range(len(x))]) +
            lines("*NSET,NSET=BASE", [(mesh.node(i, j, last),) for j in range(len(y)) for i in range(len(x))]) +
            lines("*NSET,NSET=MIRROR", [(mesh.node(i, 0, k),) for k in range(last) for i in range(len(x))]) +
            f"*MATERIAL,NAME=GEL\n*ELASTIC\n{YOUNG},{POISSON}\n*SOLID SECTION,ELSET=GEL,MATERIAL=GEL\n"
            "*BOUNDARY\nBASE,1,3\nMIRROR,2,2\n"), len(nodes), len(elements)


def object_part(mesh, what, first_node, first_element):
    """A rigid shell of its lower surface, a little larger than the part of the gel with small cells, and past the mirror."""
    along, across = np.arange(-mesh.reach - mesh.cell, mesh.reach + 1.5 * mesh.cell, mesh.cell), np.arange(-mesh.cell, mesh.reach + 1.5 * mesh.cell, mesh.cell)

    def node(i, j, k):
        return first_node + i + len(along) * (j + len(across) * k)

    nodes = [(node(i, j, k), float(along[i]), float(across[j]), float(what.height(np.hypot(along[i], across[j])) + 0.5 * k))
             for k in range(2) for j in range(len(across)) for i in range(len(along))]
    cells = [(i, j) for j in range(len(across) - 1) for i in range(len(along) - 1)]
    elements = [[first_element + n, *hexahedron(node, i, j, 0, 1)] for n, (i, j) in enumerate(cells)]
    handle = first_node + len(nodes)
    stiffness = YOUNG / mesh.cell
    return (lines("*NODE,NSET=OBJECT", nodes) + lines("*NODE", [(handle, 0.0, 0.0, 1.0), (handle + 1, 0.0, 0.0, 1.0)]) +
            lines("*ELEMENT,TYPE=C3D8,ELSET=OBJECT", elements) +
            "*MATERIAL,NAME=STEEL\n*ELASTIC\n1000,0.3\n*SOLID SECTION,ELSET=OBJECT,MATERIAL=STEEL\n"
            f"*RIGID BODY,NSET=OBJECT,REF NODE={handle},ROT NODE={handle + 1}\n" +
            lines("*SURFACE,NAME=GEL,TYPE=ELEMENT", [(n + 1, "S2") for n in range(len(mesh.top_cells()))]) +
            lines("*SURFACE,NAME=OBJECT,TYPE=ELEMENT", [(each[0], "S1") for each in elements]) +
            f"*SURFACE INTERACTION,NAME=CONTACT\n*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR\n{50 * stiffness}\n"
            f"*FRICTION\n{what.friction},{10 * stiffness}\n*CONTACT PAIR,INTERACTION=CONTACT,TYPE=SURFACE TO SURFACE\nGEL,OBJECT\n"
            f"*BOUNDARY\n{handle + 1},1,3\n{handle},1,2\n*NSET,NSET=HANDLE\n{handle},\n"), handle


PRINTED = "*NODE PRINT,NSET=SURFACE\nU\n*NODE PRINT,NSET=HANDLE\nRF\n*EL PRINT,ELSET=TOP\nS\n"


def dragged(mesh, what, presses=8, drags=12):
    """Input: the object is pressed in, then dragged along x."""
    part, nodes, elements = gel_part(mesh)
    rigid, handle = object_part(mesh, what, nodes + 1, elements + 1)
    down = f"*BOUNDARY\n{handle},3,3,{-what.depth}\n"
    return (part + rigid + f"*STEP,INC=1000\n*STATIC\n{1 / presses},1,1e-5,{1 / presses}\n{down}{PRINTED}*END STEP\n"
            f"*STEP,INC=1000\n*STATIC\n{1 / drags},1,1e-5,{1 / drags}\n{down}{handle},1,1,{what.shift}\n{PRINTED}*END STEP\n")


def loaded(mesh, tractions):
    """Input: the gel under given tractions: (node, forces along x, y, z), N."""
    part, _, _ = gel_part(mesh)
    rows = [(node, axis + 1, float(force)) for node, forces in tractions for axis, force in enumerate(forces) if force]
    return part + "*STEP\n*STATIC\n" + lines("*CLOAD", rows) + "*NODE PRINT,NSET=SURFACE\nU\n*EL PRINT,ELSET=BOTTOM\nS\n*END STEP\n"


@dataclass
class Found:
    """One moment of CalculiX's answer, on the grid of small cells, both halves: axis 0 along x, axis 1 along y."""
    time: float
    moved: np.ndarray  # ux, uy, uz at the cells' middles
    traction: np.ndarray  # tx, ty, p of cells: on the surface, or, of `loaded`, at the base
    normal: float = 0.0  # P and Q, of the whole object
    shear: float = 0.0


def moments_of(path, mesh):
    """Reads CalculiX's .dat: what Found has, for each increment."""
    near, first, named = mesh.near, mesh.first, len(mesh.top_cells())
    tables = {}
    current = None
    for line in open(path, encoding="ascii"):
        words = line.split()
        if not words:
            continue
        if "and time" in line:
            current = tables.setdefault(float(words[-1]), {}).setdefault(words[0], [])
        elif current is not None:
            current.append([float(word) for word in words])
    found = []
    for time, parts in sorted(tables.items()):
        moved = {int(row[0]): row[1:4] for row in parts["displacements"]}
        nodes = np.array([[moved[mesh.node(first + i, j, 0)] for j in range(near + 1)] for i in range(2 * near + 1)])
        cells = (nodes[1:, 1:] + nodes[:-1, 1:] + nodes[1:, :-1] + nodes[:-1, :-1]) / 4
        traction = np.zeros((2 * near, near, 3))
        of_base = int(parts["stresses"][0][0]) > named
        for number, point, _, _, szz, _, sxz, syz in parts["stresses"]:
            j, i = divmod((int(number) - 1) % named, 2 * near)
            stress = np.array([sxz, syz, -szz])
            if of_base:  # continued along the line through both layers of points, 1/sqrt(3) of an element apart
                traction[i, j] += stress / 4 * ((1 - np.sqrt(3)) / 2 if point > 4 else (1 + np.sqrt(3)) / 2)
            elif point > 4:  # the upper four points of integration
                traction[i, j] += stress / 4
        mirror = np.array([1, -1, 1])
        whole = [np.concatenate([half[:, ::-1] * mirror, half], axis=1) for half in (cells, traction)]
        one = Found(time, *whole)
        if "forces" in parts:
            _, shear, _, normal = parts["forces"][0]
            one.normal, one.shear = -2 * normal, 2 * shear
        found.append(one)
    return found
