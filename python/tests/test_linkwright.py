"""The package against published numbers, NumPy and the command line's own files.  Run by `make test`."""
import json
import math
import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import linkwright as lw

EXAMPLES = Path(os.environ.get("LINKWRIGHT_EXAMPLES", Path(__file__).resolve().parents[2] / "examples"))


def fourbar(r1=4.0, r2=1.0, r3=3.0, r4=3.5):
    """A four-bar with the crank along x: lengths of frame, input, coupler, output."""
    d2 = (r1 - r2)**2
    x = r2 + (d2 + r3**2 - r4**2)/(2*(r1 - r2))
    y = math.sqrt(r3**2 - (x - r2)**2)
    return lw.Linkage.from_dict({
        "linkwright": 1, "links": ["ground", "crank", "coupler", "rocker"], "ground": "ground",
        "joints": [{"name": "O", "kind": "r", "links": ["ground", "crank"], "at": [0, 0]},
                   {"name": "A", "kind": "r", "links": ["crank", "coupler"], "at": [r2, 0]},
                   {"name": "B", "kind": "r", "links": ["coupler", "rocker"], "at": [x, y]},
                   {"name": "C", "kind": "r", "links": ["ground", "rocker"], "at": [r1, 0]}],
        "input": {"joint": "O"}, "tracers": [{"name": "P", "link": "coupler", "at": [x, y]}]})


def test_version():
    assert lw.__version__ == lw.version() and lw.version().count(".") == 2


@pytest.mark.parametrize("links, dof, count", [(6, 1, 2), (8, 1, 16), (10, 1, 230), (7, 2, 3), (9, 2, 35)])
def test_chains_are_counted_and_listed_alike(links, dof, count):          # published numbers of chains
    assert lw.count_chains(links, dof)[0] == count
    listed = list(lw.chains(links, dof))
    assert len(listed) == count == len(set(listed))
    assert all(chain.mobility == dof and chain.links == links for chain in listed)


def test_chains_that_fall_apart_at_a_link():
    assert [lw.count_chains(links, 2, fractionated=True)[0] for links in (7, 9)] == [1, 5]


def test_chains_can_be_left_early_and_stay_in_order():
    first = [chain.graph6 for chain, _ in zip(lw.chains(12), range(200))]
    again = [chain.graph6 for chain, _ in zip(lw.chains(12, jobs=1), range(200))]
    assert first == again and len(set(first)) == 200


def test_ground_links_of_the_six_bars():
    watt, stephenson = sorted(lw.chains(6), key=lambda chain: len(set(chain.orbits())))
    assert (len(watt.mechanisms()), len(stephenson.mechanisms())) == (2, 3)
    assert lw.count_chains(6) == (2, 5)
    assert {mechanism.ground for mechanism in watt.mechanisms()} <= set(range(6))


def test_texts_of_chains_come_back():
    for chain in lw.chains(8):
        for notation in ("graph6", "lam", "edges", "franke", "json"):
            assert lw.Chain.from_text(chain.to_text(notation)) == chain
        assert lw.Chain.from_joints(8, chain.joints) == chain


def test_path_of_a_four_bar_against_numpy():
    r1, r2, r3, r4 = 4.0, 1.0, 3.0, 3.5
    angle = np.linspace(0, 2*np.pi, 100)
    path = fourbar().kinematics().trace(angle)
    ax, ay = r2*np.cos(angle), r2*np.sin(angle)
    assert np.allclose(np.hypot(path.x - ax, path.y - ay), r3, rtol=0, atol=1e-13)
    assert np.allclose(np.hypot(path.x - r1, path.y), r4, rtol=0, atol=1e-13)
    assert np.all(path.margin > 0)


def test_derivatives_of_a_posture_against_differences():
    kinematics, h = lw.Linkage.load(EXAMPLES / "jansen.json").kinematics(), 1e-6
    here = kinematics.posture(1.0, order=1)
    ahead, behind = kinematics.posture(1.0 + h), kinematics.posture(1.0 - h)
    assert np.allclose(here.tracer[:, 1], (ahead.tracer[:, 0] - behind.tracer[:, 0])/(2*h), atol=1e-8)
    assert np.allclose(here.joint[:, 1], (ahead.joint[:, 0] - behind.joint[:, 0])/(2*h), atol=1e-8)


def test_trace_into_writes_into_the_given_arrays():
    kinematics = fourbar().kinematics()
    inputs, x, y = np.linspace(0, 1, 50), np.zeros(50), np.zeros(50)
    kinematics.trace_into(inputs, x, y)
    assert np.array_equal(x, kinematics.trace(inputs).x) and np.array_equal(y, kinematics.trace(inputs).y)
    with pytest.raises(ValueError):
        kinematics.trace_into(inputs, x[:10], y)


def test_dimensions_can_be_set():
    kinematics = fourbar().kinematics()
    assert kinematics.dimensions["r2"] == pytest.approx(1.0)
    kinematics.set_dimensions(r2=0.5)
    path = kinematics.trace(np.array([0.0]))
    assert np.hypot(path.x[0] - 0.5, path.y[0]) == pytest.approx(3.0)
    with pytest.raises(KeyError, match="r2"):
        kinematics.set_dimensions(length=1)


def test_ranges_and_curves_agree_with_the_class():
    linkage = fourbar()
    assert lw.classify(4, 1, 3, 3.5).symbol == "GCRR"
    assert [info["turns"] for info in linkage.kinematics().ranges()] == [True, True]
    curves = linkage.curves(50)
    assert len(curves) == 2 and all(curve.info["closed"] and curve.info["limits"] == 0 for curve in curves)


def test_mobility_by_moving():
    info = fourbar().analyse_mobility()
    assert (info["kind"], info["freedom"], info["count"]) == ("moves", 1, 1)


def test_files_and_pictures(tmp_path):
    linkage = lw.Linkage.load(EXAMPLES / "klann.json")
    linkage.save(tmp_path / "klann.svg")
    assert linkage.picture("png")[:4] == b"\x89PNG"
    assert linkage._repr_svg_().lstrip().startswith("<")
    again = lw.Linkage.from_dict(linkage.to_dict())
    assert json.loads(again.export("json")) == linkage.to_dict()
    assert "<svg" in next(lw.chains(6))._repr_svg_()


def test_errors_carry_the_text_and_the_place(tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_text('{"linkwright": 1,\n "joints": 3}')
    with pytest.raises(lw.Error) as caught:
        lw.Linkage.load(bad)
    assert caught.value.status == "LW_E_NOTATION" and caught.value.line == 2 and str(bad) in str(caught.value)
    with pytest.raises(lw.Error):
        lw.classify(1, 1, 1, 10)
    with pytest.raises(TypeError, match="max_seconds"):
        lw.fit(lw.Target.load(EXAMPLES / "ellipse.csv"), seconds=1)


def test_models_of_any_size():
    n = 40
    joints = [{"name": "A0", "links": ["ground", "c0"], "at": [0, 0]}]
    for i in range(1, n + 1):
        joints += [{"name": f"A{i}", "links": ["ground", f"c{i}"], "at": [i, 0]},
                   {"name": f"B{i}", "links": [f"c{i - 1}", f"r{i}"], "at": [i - 1, 1]},
                   {"name": f"C{i}", "links": [f"r{i}", f"c{i}"], "at": [i, 1]}]
    model = lw.Model.from_dict({"linkwright": 1, "ground": "ground", "joints": joints,
                                "input": {"joint": "A0", "value": 0, "motion": "0.5*t"},
                                "tracers": [{"name": "P", "link": f"c{n}", "at": [n, 1]}]})
    with pytest.raises(lw.Error):
        model.linkage
    assert model.links == len(model.link_names) == 2*n + 2
    assert [j["name"] for j in model.joints] == [j["name"] for j in joints]
    assert model.inputs[0]["joint"] == 0 and model.tracers[0]["link"] == model.link_names.index(f"c{n}")
    run = model.simulate(to=1, n=4)
    assert run.link.shape == (5, 2*n + 2, 6)
    assert np.allclose(run.tracer[-1, 0], [n - math.sin(0.5), math.cos(0.5)], atol=1e-9)
    assert len(model.export("pmks").splitlines()) > 2*n           # one for each pin
    assert b"<svg" in model.picture("svg")


def test_pendulum_keeps_its_energy_and_obeys_a_force_of_ones_own():
    model = lw.Model.load(EXAMPLES / "pendulum.json")
    run = model.simulate(to=2, n=50)
    total = run.energy[:, 0] + run.energy[:, 1]
    assert len(run.t) == 51 and np.ptp(total) < 1e-9*np.abs(run.energy[:, 0]).max()
    assert any("energy error" in note for note in run.notes)
    pushed = model.simulate(to=2, n=50, force=lambda t, motion, load: load.__setitem__((1, 2), 0.0))
    assert np.allclose(pushed.link, run.link, atol=1e-7)
    held = model.simulate(to=0.1, n=10, force=lambda t, motion, load: load.__setitem__((1, 2), 5.0))
    assert not np.allclose(held.link, run.link[:11], atol=1e-3)
    with pytest.raises(ZeroDivisionError):
        model.simulate(to=1, n=10, force=lambda t, motion, load: 1/0)


def test_a_run_in_pieces_is_changed_saved_and_restored():
    model = lw.Model.load(EXAMPLES / "dynamics" / "servo-arm.json")
    run = model.simulate(to=0.3, n=3)
    assert "M.current" in model.states
    steps = lw.Stepper(model).advance(0.1).advance(0.2)
    saved = steps.save()
    assert np.allclose(steps.advance(0.3).link, run.link[-1], atol=1e-7) and steps.t == 0.3
    assert abs(steps.state["M.heat"] - run.state[-1, model.states.index("M.heat")]) < 1e-6
    bits = steps.link.tobytes()
    steps.restore(saved)
    steps.set_load(1, fy=50)
    assert not np.allclose(steps.advance(0.3).link, run.link[-1], atol=1e-5)
    assert lw.Stepper(model).restore(saved).advance(0.3).link.tobytes() == bits
    steps.set_state("M.current", 0)
    with pytest.raises(lw.Error):
        steps.set_state("M.voltage", 0)
    with pytest.raises(lw.Error, match="no saved run"):
        steps.restore(b"12345")
    rope = lw.Stepper(lw.Model.load(EXAMPLES / "dynamics" / "rope.json"), formulation="capture", tolerance=1e-6).advance(0.5)
    assert 0 < rope.report["place_off"] < 1e-2 and any("expect errors of up to about that size" in note for note in rope.notes)


def test_a_model_in_space_is_traced_against_its_closure():
    """Bennett's linkage: the coupler point keeps its distance from both ends of the coupler; rates by differences."""
    model = lw.SpatialModel.load(EXAMPLES / "space" / "bennett.json")
    assert model.links == ["ground", "crank", "coupler", "rocker"] and model.inputs == ["A"] and model.tracers == ["P"]
    info = model.analyse_mobility()
    assert (info["freedom"], info["count"], info["redundant"]) == (1, -2, 3)
    path = model.trace(2880)
    place, velocity = path.tracer.place[:, 0], path.tracer.velocity[:, 0]
    assert path.at[-1] == pytest.approx(2*np.pi) and place.shape == (2881, 3)
    slope = (place[2:] - place[:-2])/(path.at[2:] - path.at[:-2])[:, None]
    assert np.allclose(slope, velocity[1:-1], rtol=0, atol=3e-5) and np.allclose(place[0], place[-1], atol=1e-12)
    assert path.tracer.turn.shape == (2881, 1, 4)
    assert np.allclose(np.linalg.norm(path.tracer.turn, axis=2), 1, atol=1e-12)
    half = model.trace(10, over=(0, 1))
    assert half.at[-1] == 1 and np.array_equal(half.input[:, 0], half.at)
    with pytest.raises(ValueError):
        model.trace(10, over=(0, 1), time=(0, 1))
    with pytest.raises(lw.Error):
        model.drive("sin(")


def test_runs_in_space_against_the_balance_of_energy_and_momentum():
    model = lw.SpatialModel.load(EXAMPLES / "space" / "top.json")
    run = model.simulate(to=0.5, n=50)
    assert np.ptp(run.energy[:, 0] + run.energy[:, 1]) < 1e-9 and run.reaction.shape == (51, 1, 6)
    weight = run.link.acceleration[:, 1, 2] - run.reaction[:, 0, 2]          # of a top of 1 kg, over its mass
    assert np.allclose(weight, weight[0], atol=1e-9) and "<table>" in run._repr_html_()
    delta = lw.SpatialModel.load(EXAMPLES / "space" / "delta.json")
    run, path = delta.simulate(to=0.1, n=10), delta.trace(10, time=(0, 0.1))
    assert any("constraint residual" in note for note in run.notes)
    assert run.drive.shape == (11, 3) and np.allclose(path.tracer.place, run.tracer.place, atol=1e-12)
    assert np.allclose(path.tracer.place[-1, 0], (0.2, 0, -0.65), atol=1e-9)      # the motion in the file
    with pytest.raises(lw.Error, match="nope"):
        model.simulate(formulation="nope")
    with pytest.raises(TypeError, match="max_seconds"):
        model.simulate(seconds=1)


def test_control_c_ends_a_run_in_space():
    model = lw.SpatialModel.load(EXAMPLES / "space" / "top.json")
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        model.simulate(to=1e6, n=10)


def test_a_planar_file_is_no_model_in_space():
    with pytest.raises(lw.Error):
        lw.SpatialModel.load(EXAMPLES / "no-such-file.json")
    with pytest.raises(lw.Error):
        lw.SpatialModel.from_dict({"linkwright": 1, "joints": 3})


def test_fit_finds_a_four_bar_again():
    path = fourbar().trace(24)
    target = lw.Target(x=path.x, y=path.y, closed=True)
    results = lw.fit(target, rounds=4, seed=3)
    exact = min(range(len(results)), key=lambda k: results[k].error_max)        # the first row may be a smaller one
    assert results[exact].error_max < 1e-6 and results[exact].verified and results[0].error_max < 2e-3
    inputs = results.inputs(exact)
    found = results[exact].linkage.kinematics().trace(inputs)
    assert np.max(np.hypot(found.x - path.x, found.y - path.y)) < 1e-6
    assert "<table>" in results._repr_html_() and "<svg" in results.page().lower()


def test_progress_can_end_a_search_and_pass_an_exception():
    target = lw.Target.load(EXAMPLES / "figure-eight.csv")
    seen = []
    results = lw.fit(target, progress=lambda done, seconds, best: seen.append(done) or len(seen) < 3)
    assert len(seen) >= 3 and all(result.linkage.links >= 4 for result in results)

    def fail(done, seconds, best):
        raise LookupError("of mine")
    with pytest.raises(LookupError, match="of mine"):
        lw.fit(target, progress=fail)


def test_control_c_ends_a_search_and_keeps_what_was_found():
    target, begun = lw.Target.load(EXAMPLES / "figure-eight.csv"), threading.Event()

    def interrupt():
        begun.wait()
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(lw.Stopped) as caught:
        lw.fit(target, types="all", links=6, budget=1e12, rounds=10**6, progress=lambda *_: begun.set())
    assert isinstance(caught.value, KeyboardInterrupt) and len(caught.value.results) >= 0


def test_other_threads_run_while_the_library_works():
    """The interpreter's lock is released: a thread counts on during a count of chains."""
    ticks, end = [0], threading.Event()

    def tick():
        while not end.is_set():
            ticks[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=tick)
    thread.start()
    before = ticks[0]
    lw.count_chains(14, jobs=1)
    during = ticks[0] - before
    end.set()
    thread.join()
    assert during > 10


def test_catalogue_of_chains(tmp_path):
    with lw.Catalogue(tmp_path / "six.db", write=True) as catalogue:
        assert catalogue.add_chains(6) == 2
        catalogue.check()
        assert len(catalogue.query("links=6", list="chains")) == 2
        assert catalogue.sql("select count(*) as n from chain")[0]["n"] == 2
        with pytest.raises(lw.Error):
            catalogue.sql("delete from chain")


def test_nearest_curves_of_a_catalogue(tmp_path):
    with lw.Catalogue(tmp_path / "curves.db", write=True) as catalogue:
        catalogue.add_curves(2000)
        good = catalogue.nearest(lw.Target.load(EXAMPLES / "ellipse.csv"), count=5, turns=True, min_transmission=0.5)
        assert all(hit.turns and hit.transmission >= 0.5 for hit in good)
        hits = catalogue.nearest(lw.Target.load(EXAMPLES / "ellipse.csv"), count=5)
    assert len(hits) == 5 and all(a.distance <= b.distance for a, b in zip(hits, hits[1:]))
    assert hits[0].linkage.links == 4


@pytest.mark.parametrize("name", ["fit-a-path", "six-bars", "walker"])
def test_notebooks_run(name, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib").use("Agg")
    folder = Path(__file__).resolve().parents[1] / "notebooks"
    monkeypatch.chdir(folder)
    names = {}
    for cell in json.loads((folder / f"{name}.ipynb").read_text())["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]).replace("/tmp/", f"{tmp_path}/"), names)


def test_family():
    family = lw.Family(EXAMPLES / "families/loader.json")
    assert family.parameters[:2] == ["reach", "drop"] and "large" in family.configurations and "kinematic" in family.views
    assert family.variant(reach=3, drop="1600 mm").number("boom_length as mm") == pytest.approx(3400)   # hypot
    light, heavy = (family.variant(payload=p).model().simulate(to=1, n=20).drive[0, 0] for p in (400, 800))
    assert 0 < light < heavy
    with pytest.raises(lw.Error, match="stays above the ground"):
        family.variant(drop=2.2, pin_height=2).model()
    with pytest.raises(lw.Error, match="its unit is"):
        family.variant(reach="3 kg").model()


def test_servo():
    report = lw.simulate_servo(EXAMPLES / "drives/servo-axis.json")
    gone = report["heat"] + report["friction"] + report["transmission"] + report["stored"]
    assert report["electrical"] + report["work"] == pytest.approx(gone, rel=1e-6)
    assert 0 < report["error_peak"] < 0.01 and report["current_peak"] <= 25*(1 + 1e-9)


def test_files_of_models_in_space():
    model = lw.SpatialModel.load(EXAMPLES / "space" / "top.json")
    assert b'<joint type="ball" name="O"/>' in model.export("mjcf") and b"SPHERICAL" in model.export("adams")
    with pytest.raises(lw.Error, match="planar linkages only"):
        model.export("dxf")
