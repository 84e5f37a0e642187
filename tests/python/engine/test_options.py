"""The options' classes: keywords, fields, words of refusal, repr, equality, copies; no field of a header is missing."""

import copy
import pickle
import re

import numpy as np
import pytest

import isimp_engine as engine
from headers import enumerators, struct_fields

CLASSES = {
    engine.PartitionOptions: "partition/options.h",
    engine.MeshingOptions: "meshing/options.h",
    engine.CleanOptions: "mesh/clean.h",
}


@pytest.mark.parametrize("kind", CLASSES)
def test_every_field_of_the_header_is_a_keyword_and_documented(kind):
    fields = struct_fields(CLASSES[kind], kind.__name__)
    assert list(kind().as_dict()) == fields
    for field in fields:
        assert getattr(kind, field).__doc__.strip().endswith(".")


@pytest.mark.parametrize("kind", CLASSES)
def test_each_value_can_be_given_read_and_set(kind):
    for name, value in kind().as_dict().items():
        changed = (
            1
            if value is None
            else value
            if isinstance(value, str)
            else not value
            if isinstance(value, bool)
            else value + 1
        )
        options = kind(**{name: changed})
        assert getattr(options, name) == changed
        setattr(options, name, value)
        assert options == kind()


@pytest.mark.parametrize("kind", CLASSES)
def test_equality_copies_and_pickles(kind):
    name, value = next((n, v) for n, v in kind().as_dict().items() if isinstance(v, float))
    options = kind(**{name: value + 0.5})
    assert options != kind()
    assert options != 3
    for twin in (copy.copy(options), copy.deepcopy(options), pickle.loads(pickle.dumps(options))):  # noqa: S301
        assert twin == options
        assert twin is not options


def test_repr_can_be_evaluated():
    options = engine.PartitionOptions(proxies=7, method="lloyd", leave_out=0.5)
    assert repr(options).startswith("PartitionOptions(proxies=7, ")
    assert eval(repr(options), vars(engine)) == options  # noqa: S307


@pytest.mark.parametrize("kind", CLASSES)
def test_an_unknown_keyword_lists_the_fields(kind):
    name, fields = kind.__name__, ", ".join(kind().as_dict())
    with pytest.raises(TypeError, match=re.escape(f"{name} has no field 'colour'; its fields are {fields}")):
        kind(colour=3)
    with pytest.raises(AttributeError):
        kind().colour = 3


@pytest.mark.parametrize("name", ["method", "seeding"])
def test_an_unknown_name_lists_the_known_ones(name):
    known = getattr(engine.PartitionOptions(), name)
    with pytest.raises(engine.InvalidInput, match=rf"^PartitionOptions.{name} must be one of .*'{known}'.*, got 'x'$"):
        engine.PartitionOptions(**{name: "x"})
    with pytest.raises(engine.InvalidInput, match=r", got 3$"):
        engine.PartitionOptions(**{name: 3})


@pytest.mark.parametrize(("name", "enum"), [("method", "Method"), ("seeding", "Seeding")])
def test_every_enumerator_of_the_header_has_its_name(name, enum):
    names = enumerators("partition/options.h", enum)
    assert len(names) >= 2
    for value in names:
        assert getattr(engine.PartitionOptions(**{name: value}), name) == value
    with pytest.raises(engine.InvalidInput) as caught:
        engine.PartitionOptions(**{name: "x"})
    assert set(re.findall(r"'(\w+)'", str(caught.value))) == {*names, "x"}


@pytest.mark.parametrize("bad", [2.5, 7.0, "7", True, [7], np.float64(7), np.array([1, 2])])
def test_an_integer_field_takes_integers_only(bad):
    with pytest.raises(engine.InvalidInput, match=r"^PartitionOptions.proxies must be an integer, got "):
        engine.PartitionOptions(proxies=bad)
    options = engine.PartitionOptions()
    for value in (bad, None):
        with pytest.raises(engine.InvalidInput, match="must be an integer"):
            options.iterations = value
    assert options == engine.PartitionOptions()


@pytest.mark.parametrize(
    ("name", "bad", "range_"),
    [
        ("proxies", 2**31, "[-2147483648, 2147483647]"),
        ("proxies", 10**30, "[-2147483648, 2147483647]"),
        ("seed", -1, "[0, 18446744073709551615]"),
        ("seed", 2**64, "[0, 18446744073709551615]"),
    ],
)
def test_an_integer_out_of_its_type_names_the_range(name, bad, range_):
    with pytest.raises(engine.InvalidInput, match=re.escape(f"{name} must be an integer in {range_}, got {bad}")):
        engine.PartitionOptions(**{name: bad})


def test_numpy_numbers_are_numbers():
    options = engine.PartitionOptions(proxies=np.int64(9), seed=np.uint64(2**63), leave_out=np.float32(0.25))
    assert (options.proxies, options.seed, options.leave_out) == (9, 2**63, 0.25)
    assert engine.PartitionOptions(leave_out=0).leave_out == 0.0


@pytest.mark.parametrize("bad", ["x", None, True, [0.5], 1j])
def test_a_number_field_takes_numbers_only(bad):
    with pytest.raises(engine.InvalidInput, match=r"^PartitionOptions.leave_out must be a number, got "):
        engine.PartitionOptions(leave_out=bad)


def test_a_text_field_takes_text_only():
    with pytest.raises(engine.InvalidInput, match=r"^PartitionOptions.backend must be a string, got 3"):
        engine.PartitionOptions(backend=3)


@pytest.mark.parametrize("kind", CLASSES)
def test_the_table_has_the_range_of_each_field_and_the_engine_keeps_to_it(kind, cube):
    def use(**values):
        options = kind(**values)
        if kind is engine.CleanOptions:
            return engine.clean(cube.vertices, cube.triangles, options)
        part = engine.partition(
            cube, options if kind is engine.PartitionOptions else engine.PartitionOptions(proxies=6)
        )
        return part if kind is engine.PartitionOptions else engine.polygonize(cube, part, options)

    assert [field["name"] for field in kind.fields()] == list(kind().as_dict())
    for field in kind.fields():
        name = field["name"]
        assert field["default"] == getattr(kind(), name)
        assert field["about"].endswith(".")
        assert getattr(kind, name).__doc__.startswith(field["about"])
        if "choices" in field:
            assert field["default"] in field["choices"]
            continue
        step = 1 if "int" in field["type"] else 0.5
        for end, outside in (("least", -step), ("most", step)):
            if end not in field or (field["range"] == "" or name == "seed"):  # seeds are held by their type
                continue
            with pytest.raises(engine.InvalidInput, match=rf"^{name} must be "):
                use(**{name: type(step)(field[end] + outside)})
