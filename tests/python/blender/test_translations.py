"""Each fixed text of the interface has a German entry. Each entry belongs to a text of the interface."""

import re

import bpy
import pytest
import scans
import ui_strings

from isimp import messages
from isimp.blender import translations
from isimp.blender.scene import store
from isimp.blender.texts import text
from isimp.language import said


def test_each_text_has_an_entry_and_no_entry_is_stale():
    known, wanted = set(translations.read("de")), ui_strings.all_strings()
    assert {"Even Out Borders", "Start Over", "Quick Start"} <= wanted
    assert sorted(wanted - known) == []
    assert sorted(known - wanted) == []


#: Sentences that no one reads in Blender's window, or that Blender translates itself
NO_MESSAGES = (
    *("The iSimp developers", "3D View > Sidebar > iSimp", "Turn dense scans into clean, editable n-gon meshes"),
    *("shown = bpy.context.window_manager.isimp", "texture(image, tint)", "FragColor = color; }"),
    *("{} of {}", "{} color", "{} normal", ", in degrees", "Step {}, {}: {}", "tuple[int, str, str] | None"),
    *("face {}", "{} faces", "{} px"),
)
#: Begin of patterns of the engine's reasons (messages.reason), and of code for the graphics card
BEGINS = ("the region of face", "face \\d+", "the regions of .*", "faces? .*", "the line does not cut", "proxies must")
BEGINS += ("all faces are in one",)
BEGINS += ("round parts can't be had with", "a cell of the round part", "the faces given determine")
BEGINS += (
    "the faces to erase",
    "there is nothing to paint: no face",
    "\\bfaces?",
    "face {} was left out by the repair",
    "there is no face (",
)
BEGINS += ("\nvoid main", "\n  if (gl_FragCoord", "\n  if ((gl_FragCoord", "\n  vec3 normal", "\n  FragColor")
BEGINS += ("void main",)


@pytest.mark.parametrize("path", ui_strings.sources(), ids=lambda path: path.stem)
def test_each_sentence_is_translated(path):
    unsaid = ui_strings.unsaid(path)
    assert [text for text in unsaid if text not in NO_MESSAGES and not text.startswith(BEGINS)] == []


def test_a_sentence_without_translation_is_found(tmp_path):
    source = tmp_path / "source.py"
    source.write_text(
        "def work(self, name):\n"
        "    self.report({'INFO'}, f'{name} was lost today')\n"
        "    self.report({'INFO'}, 'Something was lost')\n"
        "    self.report({'INFO'}, said('{name} was found', name=name))\n"
    )
    assert ui_strings.unsaid(source) == ["{} was lost today", "Something was lost"]
    assert ui_strings.said(source) == {"{name} was found"}


def test_entries_have_the_same_places_for_values():
    for english, german in translations.read("de").items():
        assert sorted(re.findall(r"{\w*}", english)) == sorted(re.findall(r"{\w*}", german)), english


def test_entries_keep_codes_bullets_and_line_breaks():
    """Names of keys that are the same, menu paths of code, bullets and line breaks; no full stop at the end."""
    for english, german in translations.read("de").items():
        assert german.strip() == german != "", english
        assert english.count("\n") == german.count("\n"), english
        assert english.count("•") == german.count("•"), english
        assert english.endswith(".") == german.endswith("."), english
        for code in re.findall(r"isimp\w*|examples/\S+|JSON|GPU|CAD|-1\b", english):
            assert code in german, english


@pytest.fixture
def german():
    """Blender's interface in German."""
    view = bpy.context.preferences.view
    before = view.language, view.use_translate_interface
    name = next((name for name in ("de_DE", "de") if name in bpy.app.translations.locales), None)
    if name is None:
        pytest.skip("this Blender has no languages")
    view.language, view.use_translate_interface = name, True
    yield
    view.language, view.use_translate_interface = before


def test_blender_shows_german(german):
    assert said("Merge Flat") == "Ebenes verschmelzen"
    assert said("No object is active: click the scan first").startswith("Kein Objekt")
    found = bpy.app.translations.pgettext("Even Out Borders", translations.CONTEXT)
    assert found == "Grenzen begradigen"
    assert bpy.app.translations.pgettext("Bound", translations.CONTEXT) == "Schranke"  # for Blender a sound
    assert bpy.types.ISIMP_OT_mesh.bl_rna.translation_context == translations.CONTEXT


def test_reports_and_lines_of_the_panel_are_german(german, capfd):
    scan = scans.dimple(scans.cube(cells=5))
    bpy.ops.isimp.partition(proxies=8)
    with pytest.raises(
        RuntimeError, match=r"Möglich sind höchstens 300 Regionen, eine für jedes Dreieck\. Nichts wurde"
    ):
        bpy.ops.isimp.partition(proxies=10**6)
    bpy.ops.isimp.add_proxy(face=0)
    numbers = store.numbers(scan)
    assert text.scan_lines(scan.data, numbers) == ("300 Dreiecke", "1 Teil · geschlossen")
    assert messages.line(store.load(scan).steps[0]) == "Partition in 8"
    bpy.ops.isimp.mesh()
    lines = [line for line, _ in text.report_lines(store.numbers(scan), "METRIC", 1.0)]
    assert lines[0] == "9 Polygone · geschlossen"
    assert not any(re.search(r"\b(the|of|with|than|off|at)\b", line) for line in lines)
    assert "8 Regionen -> 9 Regionen" in capfd.readouterr().out


def test_a_forwarded_report_has_one_error_prefix(german, tmp_path):
    scans.cube(cells=2)
    recipe = tmp_path / "recipe.json"
    recipe.write_text('{"isimp_recipe": 1, "steps": [{"step": "melt"}]}')
    with pytest.raises(RuntimeError, match=r"^Fehler: [Ss]chritt 1: 'melt' ist kein Schritt dieser Version"):
        bpy.ops.isimp.recipe_import(filepath=str(recipe))


def test_without_the_addon_messages_are_english(german):
    translations.unregister()
    try:
        assert messages.count(2, "region") == "2 regions"
    finally:
        translations.register()
    assert messages.count(2, "region") == "2 Regionen"
