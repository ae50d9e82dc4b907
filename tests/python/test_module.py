"""What docs/python.md says of each call."""
import logging
import pathlib
import threading
import warnings

import numpy as np
import pytest

import fumarole

SAMPLES = pathlib.Path(__file__).parents[2] / "vdb_samples"
SMOKE = str(SAMPLES / "smoke_seq" / "smoke_0006.vdb")


def cube(**changed):
    return fumarole.from_density(np.ones((4, 4, 4), np.float32), voxel_size=0.5, size=(16, 9), **changed)


def test_arrays_have_their_shapes_and_rows_come_from_the_top():
    density = np.zeros((8, 4, 4))  # of another type, and z first
    density[6:] = 50  # all of it is up
    picture = fumarole.render(fumarole.from_density(density, size=(24, 16)), bounces=0, preset="default")
    for name in ("composite", "scattering", "transmittance", "surface", "surface_lit"):
        assert picture[name].shape == (16, 24, 3) and picture[name].dtype == np.float32
    assert picture["depth"].shape == (16, 24)
    through = picture["transmittance"][..., 0]
    assert through[:8].min() < 0.1 and through[8:].min() > 0.9


def test_settings_change_the_picture_and_are_checked():
    scene = cube(g=0.5)
    march = fumarole.render(scene, bounces=0)["composite"]
    froxels = fumarole.render(scene, mode="froxel", bounces=0)["composite"]
    assert 0 < fumarole.compare(froxels, march)["relmse"] < 0.05
    mean, errors = fumarole.flip(froxels, march)
    assert errors.shape == (9, 16) and abs(errors.mean() - mean) < 1e-5
    for wrong in ({"steps": 0}, {"no_such": 1}, {"mode": "other"}, {"preset": "other"}):
        with pytest.raises(fumarole.Error):
            fumarole.render(scene, **wrong)
    with pytest.raises(fumarole.Error, match="three dimensions"):
        fumarole.from_density(np.ones((4, 4)))
    with pytest.raises(fumarole.Error, match="no such file"):
        fumarole.load("none.vdb")
    with pytest.raises(RuntimeError):  # which it is
        fumarole.compare(march, march[:4])
    for measure in (fumarole.compare, fumarole.flip):
        with pytest.raises(fumarole.Error, match="one shape"):
            measure(march, march.transpose(1, 0, 2))


def test_a_grid_is_what_the_file_holds(tmp_path):
    values, world_from_index, first = fumarole.load_grid(SMOKE)
    assert values.ndim == 3 and values.max() > 0 and values.min() == 0
    assert world_from_index.shape == (4, 4) and world_from_index[3, 3] == 1
    assert len(first) == 3
    scene = fumarole.load(SMOKE, size=(16, 9))
    assert scene.size == [16, 9] and '"media"' in scene.json()
    scene.position = (0, -30, 5)
    scene.look_at = (0, 0, 2)
    picture = fumarole.render(scene, bounces=0)["composite"]
    fumarole.save(picture, str(tmp_path / "x.exr"))
    fumarole.save(picture, str(tmp_path / "x.png"))
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(fumarole.Error, match="no such folder"):
        fumarole.save(picture, str(tmp_path / "none" / "x.exr"))


def test_a_thread_has_a_context_of_its_own():
    scene, pictures = cube(), {}

    def draw(name):
        pictures[name] = fumarole.render(scene, bounces=0)["composite"]

    threads = [threading.Thread(target=draw, args=(i,)) for i in range(1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    draw("here")
    assert np.array_equal(pictures[0], pictures["here"])


def test_what_the_library_says_is_heard(tmp_path, caplog):
    scene = tmp_path / "fine.json"
    scene.write_text('''{"resolution": [8, 6], "world_radiance": [0, 0, 0], "lights": [], "surfaces": [],
        "camera": {"position": [0, -8, 1], "look_at": [0, 0, 1], "up": [0, 0, 1], "vfov_deg": 30, "near": 0.1,
                   "far": 100, "projection": "perspective"},
        "media": [{"type": "box", "min": [-1, -1, 0], "max": [1, 1, 2], "profile": "noise",
                   "noise": {"feature_size": 0.002, "octaves": 1}, "sigma_s": [1, 1, 1], "sigma_a": [0, 0, 0]}]}''')
    with caplog.at_level(logging.INFO, logger="fumarole"):
        fumarole.render(fumarole.load(str(scene)), bounces=0, steps=4)
    assert any("a grid of it would be too large" in record.getMessage() for record in caplog.records)


def test_a_settings_old_name_is_taken_with_a_warning():
    with pytest.warns(FutureWarning, match="skip is now called empty_space_skipping"):
        old = fumarole.render(cube(), bounces=0, skip=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        new = fumarole.render(cube(), bounces=0, empty_space_skipping=False)
        with pytest.raises(FutureWarning):
            fumarole.render(cube(), shadow_cache=0)
    assert np.array_equal(old["composite"], new["composite"])
