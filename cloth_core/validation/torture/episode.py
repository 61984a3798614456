"""Episodes: a cloth, what it is made of, how it is computed, what stands around it, and who abuses it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from cloth_core.config import INTEGRATORS, SolverConfig
from cloth_core.fields import Compound
from cloth_core.material import PRESETS, Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Plane, Sphere
from cloth_core.pose import Pose
from cloth_core.solver import ClothSolver
from cloth_core.state import State
from cloth_core.validation.geometry import irregular_sheet
from cloth_core.validation.torture.abuse import ABUSES

DEFAULT_INTEGRATOR = SolverConfig().integrator
SMALLEST, LARGEST = 10, 50  # vertices a side
START = Pose((0.0, 0.0, 1.0))  # flat, above most obstacles

STOOL = Compound(
    voxel=0.005,
    parts={
        "seat": Box(extents=(0.3, 0.3, 0.04)),
        "post": Capsule(radius=0.03, length=0.3, center=(0.0, 0.0, -0.17)),
        "foot": Ellipsoid(radii=(0.12, 0.15, 0.02), center=(0.0, 0.0, -0.34)),
    },
)
"""A distance field, hollow where the post meets the seat."""

# Each part of an episode draws from a stream of its own, so that fixing one part leaves the others as they are.
CLOTH, FABRIC, CONFIG, OBSTACLES, SUPPORT, ABUSE, FIRST_ABUSER = range(7)


@dataclass(frozen=True)
class Episode:
    """All that a play needs; ``seed`` and ``number`` determine it.

    Args:
        seed: of the series.
        number: in the series, from 1.
        cloth: what ``mesh`` is, in words.
        mesh: the cloth.
        fabric: what ``material`` is, in words.
        material: always damped, for undamped cloth may rightly swing for ever.
        config: step and integrator.
        obstacles: by name.
        support: what keeps the cloth from falling for ever, in words.
        pinned: vertices.
        abuses: names out of ``ABUSES``.
        steps: how long they go on.
    """

    seed: int
    number: int
    cloth: str
    mesh: ClothMesh
    fabric: str
    material: Material
    config: SolverConfig
    obstacles: MappingProxyType[str, Obstacle]
    support: str
    pinned: np.ndarray
    abuses: tuple[str, ...]
    steps: int

    @property
    def strict(self) -> bool:
        """Whether the stretch limit is part of the contract: for the default integrator it is."""
        return self.config.integrator == DEFAULT_INTEGRATOR

    def __str__(self) -> str:
        around = ", ".join(self.obstacles)
        return (
            f"{self.cloth} of {self.fabric}, {self.support}, among {around}; {self.config.integrator}, "
            f"dt {self.config.dt:.4g} s; {' + '.join(self.abuses)} for {self.steps} steps"
        )

    def stage(self) -> tuple[ClothSolver, State]:
        """The solver, with what is pinned, and the state to begin with."""
        solver = ClothSolver(self.mesh, self.material, self.config, obstacles=self.obstacles)
        solver.pin(self.pinned)
        return solver, solver.initial_state(START)

    def abuser(self, name: str) -> np.random.Generator:
        """The random numbers of one abuser: the same whoever else is about."""
        return _stream(self.seed, self.number, FIRST_ABUSER + list(ABUSES).index(name))


def draw(
    seed: int, number: int, *, integrator: str | None = None, abuses: Sequence[str] = (), largest: int = LARGEST
) -> Episode:
    """Episode ``number`` of the series ``seed``; ``integrator`` and ``abuses`` overrule what the dice say.

    No cloth has more than ``largest`` vertices a side.
    """
    config = _config(_stream(seed, number, CONFIG), integrator)
    cloth, mesh = _cloth(_stream(seed, number, CLOTH), config.dt, largest)
    fabric, material = _fabric(_stream(seed, number, FABRIC))
    support, pinned = _support(_stream(seed, number, SUPPORT), mesh, config.integrator)
    names, steps = _abuses(_stream(seed, number, ABUSE), config.dt)
    return Episode(
        seed=seed,
        number=number,
        cloth=cloth,
        mesh=mesh,
        fabric=fabric,
        material=material,
        config=config,
        obstacles=_obstacles(_stream(seed, number, OBSTACLES), floor=len(pinned) == 0),
        support=support,
        pinned=pinned,
        abuses=tuple(abuses) or names,
        steps=steps,
    )


def _stream(seed: int, number: int, part: int) -> np.random.Generator:
    return np.random.default_rng([seed, number, part])


def _config(random: np.random.Generator, integrator: str | None) -> SolverConfig:
    """The default integrator three times in four, dt 20 ms every other time."""
    others = [name for name in INTEGRATORS if name != DEFAULT_INTEGRATOR]
    drawn = DEFAULT_INTEGRATOR if random.random() < 0.75 else str(random.choice(others))
    dt = float(random.choice([0.02, 0.02, 0.02, 0.001, 0.1, 10.0 ** random.uniform(-3.0, -1.0)]))
    return SolverConfig(integrator=integrator or drawn, dt=dt)


def _cloth(random: np.random.Generator, dt: float, largest: int) -> tuple[str, ClothMesh]:
    """A grid, an irregular sheet or a chain of 10 to ``largest`` vertices a side."""
    # A second of small steps is many steps: smaller cloths there, or one episode would eat the time of all others.
    most = min(largest, int(np.clip(LARGEST * np.sqrt(dt / 0.01), 15, LARGEST)))
    kind = random.choice(["grid", "irregular", "chain"], p=[0.6, 0.25, 0.15])
    across, along = (int(n) for n in random.integers(min(SMALLEST, most), most + 1, 2))
    width, height = (float(size) for size in random.uniform(0.3, 1.5, 2))
    if kind == "grid":
        return f"grid {across} x {along}", ClothMesh.grid(width=width, height=height, columns=across, rows=along)
    if kind == "irregular":
        sheet = irregular_sheet(max(width, height), min(width, height), across - 1, seed=int(random.integers(10_000)))
        return f"irregular sheet of {sheet.vertex_count} vertices", sheet
    return _chain(random, along, height)


def _chain(random: np.random.Generator, vertices: int, length: float) -> tuple[str, ClothMesh]:
    stiffness, mass = 10.0 ** random.uniform(1.0, 6.0), 10.0 ** random.uniform(-4.0, -2.0)
    place = np.zeros((vertices, 3))
    place[:, 1] = np.linspace(0.0, -length, vertices)
    pairs = np.stack([np.arange(vertices - 1), np.arange(1, vertices)], axis=1)
    chain = ClothMesh.from_springs(place, pairs, stiffness=stiffness, mass=mass)
    return f"chain of {vertices} x {mass:.1g} kg, {stiffness:.1g} N/m", chain


def _fabric(random: np.random.Generator) -> tuple[str, Material]:
    """The default, a preset, one a thousand times as stiff, or a very soft one; damped, of any friction."""
    name = str(random.choice(["default", "default", *PRESETS]))
    values = {} if name == "default" else dict(PRESETS[name])
    kind = random.choice(["as it is", "stiff", "soft"], p=[0.6, 0.2, 0.2])
    if kind == "stiff":
        plain = Material(**values)
        values |= {key: 1000.0 * getattr(plain, key) for key in ("stretch_warp", "stretch_weft", "shear", "bend")}
        name = f"{name}, 1000 x as stiff"
    elif kind == "soft":
        values |= dict(stretch_warp=10.0, stretch_weft=5.0, shear=1.0, bend=1e-6)
        name = f"{name}, very soft"
    values |= dict(damping=float(random.uniform(1.5, 4.0)), friction=float(random.choice([0.0, 0.3, 1.0])))
    return name, Material(**values)


def _support(random: np.random.Generator, mesh: ClothMesh, integrator: str) -> tuple[str, np.ndarray]:
    """Nothing but the floor, or pins.

    Under the paper's eq. (5), which knows the wind alone, nothing brakes a free cloth that a storm has carried off:
    those of other integrators than the default are always pinned.
    """
    ways = ["free", "one corner pinned", "two corners pinned", "an edge pinned"]
    way = str(random.choice(ways if integrator == DEFAULT_INTEGRATOR else ways[1:]))
    x, y, _ = mesh.rest_position.T
    pinned = {
        "free": np.zeros(0, int),
        "one corner pinned": np.array([np.argmax(x + y)]),
        "two corners pinned": np.unique([np.argmax(x + y), np.argmax(y - x)]),
        "an edge pinned": np.flatnonzero(y > y.max() - 1e-9),
    }
    return way, pinned[way]


def _obstacles(random: np.random.Generator, *, floor: bool) -> MappingProxyType[str, Obstacle]:
    """One at least; ``floor`` says that the ground must be among them."""
    chosen = {name for name, dice in zip(("floor", "ball", "box", "rod"), random.random(4), strict=True) if dice < 0.4}
    chosen |= {"floor"} if floor or not chosen else set()
    places = random.uniform([-0.4, -0.4, 0.0], [0.4, 0.4, 0.4], (3, 3)).tolist()
    turns = random.normal(size=(3, 4))
    turns = (turns / np.linalg.norm(turns, axis=1, keepdims=True)).tolist()
    radius, extents = float(random.uniform(0.05, 0.4)), tuple(random.uniform(0.05, 0.6, 3))
    shapes: dict[str, Obstacle] = {
        "floor": Plane(),
        "ball": Sphere(radius=radius, center=places[0], orientation=turns[0]),
        "box": Box(extents=extents, center=places[1], orientation=turns[1]),
        "rod": Capsule(radius=0.4 * radius, length=float(extents[0]), center=places[2], orientation=turns[2]),
    }
    if random.random() < 0.3:
        x, y, z = random.uniform([-0.4, -0.4, 0.0], [0.4, 0.4, 0.4])
        turn = random.normal(size=4)
        shapes["stool"] = replace(STOOL, center=(x, y, z), orientation=tuple(turn / np.linalg.norm(turn)))
        chosen |= {"stool"}
    return MappingProxyType({name: shape for name, shape in shapes.items() if name in chosen})


def _abuses(random: np.random.Generator, dt: float) -> tuple[tuple[str, ...], int]:
    """One to three names, and for how many steps: at most 4 s, or a storm would carry cloths off for hours."""
    count = random.choice([1, 2, 3], p=[0.5, 0.3, 0.2])
    names = tuple(str(name) for name in random.choice(list(ABUSES), count, replace=False))
    return names, min(int(random.integers(40, 120)), round(4.0 / dt))
