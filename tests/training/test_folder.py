"""The folder of a run: whose it is, what it says, and what of it is broken."""

import json
from dataclasses import replace

import pytest

from motorspace._errors import UserError
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Logged, Simulated
from motorspace.training.folder import (
    Description,
    claim,
    differences,
    finished,
    load_config,
    read_description,
    read_log,
)
from tests.tables import write_table

SCALES = ((10.0,) * 9, (1.0, 1.0), 6)


def described(config=None, **training):
    config = config or RunConfig()
    return Description(replace(config, training=replace(config.training, **training)), *SCALES)


def test_a_folder_says_what_it_was_claimed_for(tmp_path):
    claim(tmp_path, described(seed=3), resume=False)
    assert read_description(tmp_path) == described(seed=3)
    assert load_config(str(tmp_path)) == described(seed=3).config
    assert json.loads((tmp_path / "config.json").read_text())["format_version"] == 2
    claim(tmp_path, described(seed=3), resume=True)


@pytest.mark.parametrize(
    ("other", "names"),
    [
        (described(seed=4), "seed"),
        (described(epochs=10), "epochs"),
        (described(epochs=6000, learning_rate=1.0), "epochs, learning_rate"),
        (described(RunConfig(Simulated("holonomic"))), "agent"),
        (described(RunConfig(Simulated(layout="empty", horizon=2))), "horizon, layout"),
        (described(RunConfig(Derived(Simulated(), "oracle"))), "data"),
        (described(RunConfig(preset="best")), "encoder"),
        (replace(described(), motor_scale=(2.0, 1.0)), "motors"),
    ],
    ids=str,
)
def test_the_folder_of_another_run_is_refused_naming_what_differs(tmp_path, other, names):
    claim(tmp_path, described(), resume=False)
    before = (tmp_path / "config.json").read_bytes()
    with pytest.raises(UserError, match=rf"another configuration \(different: .*{names}"):
        claim(tmp_path, other, resume=True)
    with pytest.raises(UserError, match="already holds a run; continue it with --resume"):
        claim(tmp_path, other, resume=False)
    assert (tmp_path / "config.json").read_bytes() == before


def test_a_longer_run_claims_the_folder_and_is_not_finished(tmp_path):
    claim(tmp_path, described(), resume=False)
    (tmp_path / "weights.safetensors").write_bytes(b"")
    assert finished(tmp_path)
    claim(tmp_path, described(epochs=6000), resume=True)
    assert load_config(tmp_path).training.epochs == 6000 and not finished(tmp_path)


@pytest.mark.parametrize("derived", [False, True])
def test_a_log_is_known_by_its_content_wherever_it_lies(tmp_path, derived):
    table = write_table(tmp_path / "a.csv", rows=40)

    def run():
        log = Logged(table)
        return described(RunConfig(Derived(log, "oracle") if derived else log))

    claim(tmp_path, run(), resume=False)
    (tmp_path / "weights.safetensors").write_bytes(b"")
    table = table.rename(tmp_path / "b.csv")
    claim(tmp_path, run(), resume=True)
    assert "b.csv" in (tmp_path / "config.json").read_text() and finished(tmp_path)
    write_table(table, rows=41)
    with pytest.raises(UserError, match=r"\(different: sha256\)"):
        claim(tmp_path, run(), resume=True)


def test_what_differs_in_nested_dictionaries_is_named():
    one = {"a": 1, "b": {"kind": "x", "c": [1, 2], "d": None}}
    other = {"a": 1.0, "b": {"kind": "x", "c": [1, 3], "e": None}}
    assert differences(one, other) == {"b.c": ([1, 2], [1, 3])}
    assert list(differences(one, {"a": 1, "b": {"kind": "y"}})) == ["b"]
    assert list(differences(one, {"a": 2})) == ["a", "b"]
    assert differences(one, one) == {}


BROKEN = {
    "no JSON": b"{",
    "no object": b"[]",
    "binary": b"\xff\xfe\x00",
    "no version": b"{}",
    "no configuration": b'{"format_version": 2, "scaling": {"sensors": [], "motors": []}}',
}


@pytest.mark.parametrize("content", BROKEN.values(), ids=BROKEN)
def test_a_broken_configuration_is_one_sentence(tmp_path, content):
    (tmp_path / "config.json").write_bytes(content)
    with pytest.raises(UserError, match=r"config\.json: the run's configuration cannot be read"):
        load_config(tmp_path)


def test_where_no_run_is_a_sentence_says_so(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path, tmp_path / "nowhere", tmp_path / "file"):
        with pytest.raises(UserError, match="there is no run here"):
            load_config(place)


@pytest.mark.parametrize("content", [b"{", b"\xff\xfe", b"[1"])
def test_a_broken_log_is_one_sentence(tmp_path, content):
    assert read_log(tmp_path) == []
    (tmp_path / "log.jsonl").write_bytes(content)
    with pytest.raises(UserError, match=r"log\.jsonl: the run's log cannot be read"):
        read_log(tmp_path)


def test_a_description_holds_plain_numbers_whatever_it_is_made_of():
    run = described(RunConfig(training=TrainingConfig(epochs=3)))
    assert json.loads(json.dumps(run.as_json()))["scaling"]["sensors"] == [10.0] * 9
