"""Reads robot, actuators and scenarios of the project and makes the MuJoCo model of them.

Read again from the files' own meaning (URDF, TOML): nothing of the Rust program is used. A `Leg` is what the simulation steps:
MuJoCo's bodies with the actuators' attachments and numbers as arrays.
"""

import copy
import math
import pathlib
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

import mujoco
import numpy as np

import equations as eq

ASSETS = pathlib.Path(__file__).resolve().parents[2]
GRAVITY = 9.81


def read_toml(path):
    return tomllib.loads(pathlib.Path(path).read_text(encoding="utf-8"))


def merged(base, change):
    """Tables merged key by key."""
    result = copy.deepcopy(base)
    for key, value in change.items():
        result[key] = merged(result[key], value) if isinstance(value, dict) and isinstance(result.get(key), dict) else value
    return result


def spring_stiffness(spec, setting):
    """N/m of a moment-loaded beam in series with its clamp (published: k = EI/(h^2 l), sections 2-5-1, eq 2-9, 2-10)."""
    s = spec["spring"]
    if setting == "locked-out":
        return s["series_stiffness_n_m"]
    if setting == s["setting"] and "value" in spec["parameters"]["stiffness"]:
        return spec["parameters"]["stiffness"]["value"]
    youngs = {"titanium-6al-4v": 115e9}[s["material"]]
    second_moment = s["width_m"] * s["thickness_m"] ** 3 / 12.0
    length = s[f"{setting}_length_m"]
    beam = s["beam_scale"] * youngs * second_moment / (s["lever_arm_m"] ** 2 * length)
    return 1.0 / (1.0 / beam + 1.0 / s["series_stiffness_n_m"])


@dataclass
class Coefficients:
    """Numbers of one actuator, referred to the screw."""

    stiffness: float
    inertia: float
    damping: float
    force_constant: float
    sprung: float
    unsprung: float
    travel_per_rad: float

    @staticmethod
    def of(spec, setting):
        drive = spec["transmission"]
        r = drive["screw_lead_m"] / (2.0 * math.pi * drive["belt_ratio"])
        motor = spec["motor"]
        return Coefficients(
            stiffness=spring_stiffness(spec, setting),
            inertia=motor["rotor_inertia_kg_m2"] / r**2,
            damping=motor["rotor_damping_nm_s"] / r**2,
            force_constant=motor["torque_constant_nm_a"] / r,
            sprung=spec["sprung_mass_kg"],
            unsprung=spec["unsprung_mass_kg"],
            travel_per_rad=r,
        )

    def row(self):
        row = np.zeros(eq.COLUMNS)
        row[eq.STIFFNESS], row[eq.INERTIA], row[eq.DAMPING], row[eq.SPRUNG] = self.stiffness, self.inertia, self.damping, self.sprung
        row[eq.UNSPRUNG], row[eq.FORCE_CONSTANT] = self.unsprung, self.force_constant
        row[eq.STRIBECK_SPEED] = 1.0
        return row


@dataclass
class Leg:
    """MuJoCo's bodies and the actuators between them."""

    model: mujoco.MjModel
    joints: list
    names: list
    coefficients: list
    kind: np.ndarray
    ends: np.ndarray
    local: np.ndarray
    axis: np.ndarray
    dof: np.ndarray
    bars: np.ndarray
    stops: np.ndarray
    sole_body: int = 0
    sole: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    rail: bool = False
    slides: np.ndarray = None
    moves: np.ndarray = None

    def __post_init__(self):
        n = self.model.nv
        self.slides = np.array([t == mujoco.mjtJoint.mjJNT_SLIDE for t in self.model.jnt_type])
        self.moves = np.zeros((self.model.nbody, n), dtype=np.bool_)
        for body in range(1, self.model.nbody):
            ancestor = body
            while ancestor > 0:
                for j in range(n):
                    self.moves[body, j] |= self.model.jnt_bodyid[j] == ancestor
                ancestor = self.model.body_parentid[ancestor]

    def arrays(self):
        return self.kind, self.ends, self.local, self.axis, self.dof, self.bars


def numbers(text):
    return [float(part) for part in text.split()]


def mujoco_leg(scenario, links_extra=None):
    """The leg of a scenario (a dict as in its file). `links_extra`: additional point masses, link -> (kg, place in the link)."""
    robot = scenario["robot"]
    tree = ET.parse(ASSETS / "robots" / f"{robot}.urdf")
    root = tree.getroot()
    placement = read_toml(ASSETS / "robots" / f"{robot}.actuators.toml")["actuator"]
    sole_link, sole = sole_points(root)
    for link in root.findall("link"):
        for tag in ("visual", "collision"):
            for element in link.findall(tag):
                link.remove(element)
    base = scenario.get("base", {"kind": "fixed"})
    rail = base["kind"] == "rail"
    ET.SubElement(root, "link", name="stand")
    joint = ET.SubElement(root, "joint", name="rail", type="prismatic" if rail else "fixed")
    ET.SubElement(joint, "parent", link="stand")
    ET.SubElement(joint, "child", link="base")
    ET.SubElement(joint, "origin", xyz=f"0 0 {0.0 if rail else base.get('height_m', 0.0)}")
    if rail:
        ET.SubElement(joint, "axis", xyz="0 0 1")
        ET.SubElement(joint, "limit", lower="-10", upper="10", effort="1", velocity="1")
    ET.SubElement(ET.SubElement(root, "mujoco"), "compiler", fusestatic="false", balanceinertia="false")
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    if rail:
        spec.body("base").mass += base.get("carriage_mass_kg", 0.0)

    rows = {key: [] for key in ("kind", "ends", "local", "axis", "dof", "bars", "coefficients")}
    masses = [(link, kg, place) for link, (kg, place) in (links_extra or {}).items()]
    for a in placement:
        actuator = read_toml(ASSETS / "actuators" / f"{a['actuator']}.toml")
        setting = scenario.get("actuators", {}).get("spring", a["spring"])
        setting = scenario.get("actuator", {}).get(a["name"], {}).get("spring", setting)
        c = Coefficients.of(actuator, setting)
        linkage = a["kind"] == "hoekens"
        # The sprung mass is carried by link 2's attachment of a rod, by the mount of a linkage.
        masses.append((a["link_1"], c.sprung, a["point_1_m"]) if linkage else (a["link_2"], c.sprung, a["point_2_m"]))
        bars = np.zeros(8)
        if linkage:
            l = actuator["linkage"]
            bars[:] = [l["crank_m"], l["ground"], l["coupler"], l["rocker"], l["tracer"],
                       a["crank_angle_at_zero_rad"], a["sign"], a["length_mid_m"]]
        rows["kind"].append(eq.LINKAGE if linkage else eq.ROD)
        rows["ends"].append((a["link_1"], a["link_2"]))
        rows["local"].append([a["point_1_m"], a.get("point_2_m", [0.0, 0.0, 0.0])])
        rows["axis"].append(a.get("axis_1", [0.0, 0.0, 0.0]))
        rows["dof"].append(a.get("joint"))
        rows["bars"].append(bars)
        rows["coefficients"].append(c)
    for link, kg, place in masses:
        add_point_mass(spec, link, kg, place)
    only_bodies(spec, scenario.get("gravity_m_s2", GRAVITY))
    model = spec.compile()
    names = [model.joint(i).name for i in range(model.njnt)]
    body = {model.body(i).name: i for i in range(model.nbody)}
    law = {"stiffness_nm_rad": 3000.0, "damping_nm_s_rad": 15.0} | scenario.get("stops", {})
    stops = np.zeros((model.nv, 4))
    for j, name in enumerate(names):
        limited = name != "rail"
        stops[j] = [*(model.jnt_range[j] if limited else (-np.inf, np.inf)), law["stiffness_nm_rad"], law["damping_nm_s_rad"]]
    return Leg(
        model=model, joints=names, names=[a["name"] for a in placement], coefficients=rows["coefficients"],
        kind=np.array(rows["kind"]), ends=np.array([[body[l] for l in pair] for pair in rows["ends"]]),
        local=np.array(rows["local"]), axis=np.array(rows["axis"]),
        dof=np.array([names.index(j) if j else -1 for j in rows["dof"]]), bars=np.array(rows["bars"]),
        stops=stops, sole_body=body[sole_link], sole=sole, rail=rail)


def sole_points(root):
    """The lower corners of the foot's collision box: link and points in its frame."""
    parents = {j.find("parent").get("link") for j in root.findall("joint")}
    for link in root.findall("link"):
        box = link.find("collision/geometry/box")
        if box is not None and link.get("name") not in parents:
            centre = numbers(link.find("collision/origin").get("xyz"))
            half = [0.5 * s for s in numbers(box.get("size"))]
            corners = [[centre[0] + i * half[0], centre[1] + j * half[1], centre[2] - half[2]] for i in (-1, 1) for j in (-1, 1)]
            return link.get("name"), np.array(corners)
    raise ValueError("the robot has no foot with a box")


def add_point_mass(spec, link, kg, place):
    """A body welded to a link, so small that its own inertia does not count (1e-9 kg m^2)."""
    spec.body(link).add_body(pos=place, mass=kg, inertia=[1e-9] * 3, ipos=[0, 0, 0], iquat=[1, 0, 0, 0], explicitinertial=True)


def only_bodies(spec, gravity):
    """MuJoCo's own constraints, contacts and passive forces are off: every force is ours."""
    spec.option.gravity = [0.0, 0.0, -gravity]
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_CONTACT)


def mujoco_pendulum(setting, arm_m=0.0725, length_m=0.300, mass_kg=4.0):
    """The moving-output bench (section 3-4-5): spring side held, screw on a lever with a mass that hangs."""
    spec = mujoco.MjSpec()
    only_bodies(spec, GRAVITY)
    link = spec.worldbody.add_body(name="link", mass=mass_kg, ipos=[0, 0, -length_m], inertia=[1e-9] * 3, iquat=[1, 0, 0, 0],
                                   explicitinertial=True)
    link.add_joint(name="joint", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0])
    bars = np.zeros((1, 8))
    bars[0, 0] = arm_m
    actuator = read_toml(ASSETS / "actuators" / "thor-linear.toml")
    return Leg(
        model=spec.compile(), joints=["joint"], names=["thor"], coefficients=[Coefficients.of(actuator, setting)],
        kind=np.array([eq.LEVER]), ends=np.array([[0, 1]]), local=np.zeros((1, 2, 3)), axis=np.zeros((1, 3)), dof=np.array([0]),
        bars=bars, stops=np.array([[-np.inf, np.inf, 0.0, 0.0]]))
