"""Each fixed text of the interface has a German entry. Each entry belongs to a text of the interface."""

import re

import bpy
import pytest
import ui_strings

from isimp.blender import text, translations

pytestmark = pytest.mark.usefixtures("scene")


def test_each_text_has_an_entry_and_no_entry_is_stale():
    known, wanted = set(translations.read("de")), ui_strings.all_strings()
    assert {"Even Out Borders", "Partition Anew", "Quick Start"} <= wanted
    assert sorted(wanted - known) == []
    assert sorted(known - wanted) == []


def test_entries_keep_what_is_no_language():
    """Names of keys that are the same, menu paths of code, bullets and line breaks; no full stop at the end."""
    for english, german in translations.read("de").items():
        assert german.strip() == german != "", english
        assert english.count("\n") == german.count("\n"), english
        assert english.count("•") == german.count("•"), english
        assert english.endswith(".") == german.endswith("."), english
        for code in re.findall(r"isimp\w*|examples/\S+|JSON|GPU|CAD|-1\b", english):
            assert code in german, english


def test_blender_shows_german(monkeypatch):
    view = bpy.context.preferences.view
    before = view.language, view.use_translate_interface
    name = next((name for name in ("de_DE", "de") if name in bpy.app.translations.locales), None)
    if name is None:
        pytest.skip("this Blender has no languages")
    view.language, view.use_translate_interface = name, True
    try:
        assert text.said("Select Divided Regions") == "Geteilte Regionen auswählen"
        assert text.said("No object is active: click the scan first").startswith("Kein Objekt")
        said = bpy.app.translations.pgettext("Even Out Borders", translations.CONTEXT)
        assert said == "Grenzen begradigen"
        assert bpy.app.translations.pgettext("Bound", translations.CONTEXT) == "Schranke"  # for Blender a sound
        assert bpy.types.ISIMP_OT_mesh.bl_rna.translation_context == translations.CONTEXT
    finally:
        view.language, view.use_translate_interface = before
