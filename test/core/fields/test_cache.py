"""Fields on disk: found again bit by bit, built again when anything about them is wrong."""

from __future__ import annotations

from pathlib import Path

import bodies
import numpy as np
import pytest

from cloth_core import Pose
from cloth_core.errors import MeshError, SettingError
from cloth_core.fields import Field, Solid, VoxelField, cache, make
from cloth_core.fields.build import build
from cloth_core.obstacles import Box, Capsule, Plane, Sphere

VOXEL = 0.05
BALL = Sphere(radius=0.3)


def same(one: Field, other: Field) -> bool:
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in zip(one.pool, other.pool, strict=True))


class Told(list):
    """Progress that says whether anything was built."""

    __call__ = list.append


def files(folder: Path) -> list[Path]:
    return sorted(folder.iterdir())


def test_the_second_time_nothing_is_built_and_every_bit_is_the_same(tmp_path):
    first, second = Told(), Told()
    one = make(bodies.torus(0.3, 0.1), VOXEL, folder=tmp_path, progress=first)
    other = make(bodies.torus(0.3, 0.1), VOXEL, folder=tmp_path, progress=second)
    assert first and not second
    assert same(one, other)
    assert len(files(tmp_path)) == 1


def test_everything_that_matters_has_a_file_of_its_own(tmp_path):
    surface = bodies.ball(0.3)
    for parts in (
        surface,
        [(surface, Pose((0.1, 0, 0)))],
        BALL,
        Sphere(radius=0.3, center=(0.1, 0, 0)),
        [BALL, surface],
    ):
        make(parts, VOXEL, folder=tmp_path)
    make(BALL, 0.06, folder=tmp_path)
    make(BALL, VOXEL, band=0.1, folder=tmp_path)
    make(BALL, VOXEL, query="tangent_plane", folder=tmp_path)
    assert len(files(tmp_path)) == 8


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:1000])


def emptied(path: Path) -> None:
    path.write_bytes(b"")


def foreign(path: Path) -> None:
    with path.open("wb") as file:
        np.savez(file, something=np.zeros(3))


def turned(path: Path) -> None:
    """A bit of the data is another."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))


def exchanged(path: Path) -> None:
    """The file of another field, whole."""
    make(BALL, 0.07, folder=path.parent / "other")
    path.write_bytes(files(path.parent / "other")[0].read_bytes())


def altered(path: Path) -> None:
    """A readable file with one number changed."""
    with np.load(path) as file:
        content = dict(file)
    content["coarse"][0] += 1
    with path.open("wb") as file:
        np.savez(file, **content)


@pytest.mark.parametrize("damage", [cut, emptied, foreign, turned, exchanged, altered])
def test_a_file_that_is_not_what_was_written_is_built_again(tmp_path, damage):
    field = make(BALL, VOXEL, folder=tmp_path)
    (path,) = files(tmp_path)
    whole = path.read_bytes()
    damage(path)
    assert path.read_bytes() != whole
    told = Told()
    assert same(make(BALL, VOXEL, folder=tmp_path, progress=told), field)
    assert told
    again = Told()
    assert same(make(BALL, VOXEL, folder=tmp_path, progress=again), field)
    assert not again


def test_a_build_that_is_broken_off_leaves_nothing(tmp_path, monkeypatch):
    def full(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    assert same(make(BALL, VOXEL, folder=tmp_path), build(Solid.of_shape(BALL), VOXEL))
    assert files(tmp_path) == []


def test_a_folder_that_cannot_be_made_keeps_nothing(tmp_path):
    (tmp_path / "file").write_text("in the way")
    field = make(BALL, VOXEL, folder=tmp_path / "file")
    assert field.reach == pytest.approx(0.3 * np.sqrt(3))


def test_the_folder_comes_from_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.FOLDER_VARIABLE, str(tmp_path / "mine"))
    make(BALL, VOXEL)
    assert len(files(tmp_path / "mine")) == 1
    monkeypatch.setenv(cache.FOLDER_VARIABLE, "")
    assert cache.default_folder() is None
    monkeypatch.delenv(cache.FOLDER_VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    assert cache.default_folder() == tmp_path / "home" / "cloth_core" / "fields"


def test_a_compound_is_the_least_of_its_parts(tmp_path):
    """A table of boxes, a rod through its top and a torus on it, some of them turned."""
    torus = bodies.torus(0.15, 0.04, 48)
    parts = [
        Box(extents=(0.8, 0.6, 0.04), center=(0.0, 0.0, 0.7)),
        *(Box(extents=(0.05, 0.05, 0.7), center=(x, y, 0.35)) for x in (-0.35, 0.35) for y in (-0.25, 0.25)),
        Capsule(radius=0.03, length=0.5, center=(0.1, 0.0, 0.7), orientation=(0.3, 0.1, 0.0, 0.9)),
        (torus, Pose((0.0, 0.0, 0.76), (0.1, 0.0, 0.0, 1.0))),
    ]
    field = make(parts, 0.02, folder=tmp_path)
    points = np.random.default_rng(0).uniform([-0.45, -0.35, -0.05], [0.45, 0.35, 0.9], (20000, 3))
    solids = [
        Solid.of_surface(*p) if isinstance(p, tuple) and isinstance(p[1], Pose) else Solid.of_shape(p) for p in parts
    ]
    exact = np.min([solid.measure(points)[0] for solid in solids], axis=0)
    within = np.abs(exact) < field.band
    assert field.distance(points)[0][within] == pytest.approx(exact[within], abs=0.3 * 0.02)


def test_a_compound_needs_parts_with_an_end(tmp_path):
    with pytest.raises(MeshError, match="without parts"):
        make([], VOXEL, folder=tmp_path)
    with pytest.raises(MeshError, match="a plane has no end"):
        make([BALL, Plane()], VOXEL, folder=tmp_path)
    with pytest.raises(SettingError, match="query: 'nearest' is not one of trilinear, tangent_plane"):
        make(BALL, VOXEL, query="nearest", folder=tmp_path)
    assert files(tmp_path) == []


def test_a_mesh_file_is_an_obstacle(tmp_path, monkeypatch):
    """In millimetres, as STL often is."""
    monkeypatch.setenv(cache.FOLDER_VARIABLE, str(tmp_path / "fields"))
    bodies.as_trimesh(bodies.box(100.0, 200.0, 300.0)).export(tmp_path / "block.stl")
    settings = {"path": str(tmp_path / "block.stl"), "scale": 0.001, "voxel": 0.02, "center": [1.0, 0.0, 0.0]}
    block = VoxelField.from_mapping(settings)
    assert block.reach == pytest.approx(np.linalg.norm([0.1, 0.2, 0.3]))
    assert block.field.distance(np.array([[0.11, 0.0, 0.0]]))[0] == pytest.approx(0.01, abs=0.002)
    assert VoxelField.from_mapping(block.as_mapping()) == block


def test_an_obstacle_needs_one_mesh_and_a_voxel_in_range(tmp_path):
    ball = bodies.ball(0.3)
    for wrong in ({}, {"path": "a.stl", "surface": ball}):
        with pytest.raises(SettingError, match="either a mesh file or a surface"):
            VoxelField(voxel=0.02, **wrong)
    with pytest.raises(SettingError, match=r"voxel: 1e-05 is out of range"):
        VoxelField(voxel=1e-5, surface=ball)
    with pytest.raises(SettingError, match="query: 'near' is not one of trilinear, tangent_plane"):
        VoxelField(voxel=0.02, surface=ball, query="near")
    with pytest.raises(MeshError, match=r"lost\.stl"):
        VoxelField(voxel=0.02, path=str(tmp_path / "lost.stl")).made(folder=tmp_path)


def test_an_open_mesh_file_is_refused_or_repaired(tmp_path):
    ball = bodies.ball(0.3)
    bodies.as_trimesh(ball._replace(triangles=ball.triangles[1:])).export(tmp_path / "open.ply")
    settings = dict(path=str(tmp_path / "open.ply"), voxel=VOXEL)
    with pytest.raises(MeshError, match=r"open\.ply: not watertight: 1 hole"):
        VoxelField(**settings).made(folder=tmp_path)
    with pytest.warns(UserWarning, match=r"open\.ply: 1 hole of 3 edges .* filled"):
        field = VoxelField(**settings, repair=True).made(folder=tmp_path)
    assert field.distance(np.array([[0.0, 0.0, 0.4]]))[0] == pytest.approx(0.1, abs=0.06)
