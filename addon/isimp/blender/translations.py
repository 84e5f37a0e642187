"""Translations of the interface: for each language a file with lines `English<tab>translation`."""

from pathlib import Path

import bpy

CONTEXT = "iSimp"  #: of operators, menus and panels: their names are words that Blender translates otherwise
_FOLDER = Path(__file__).parents[1] / "translations"
_LOCALES = {"de": ("de", "de_DE")}  #: what Blender calls a language, by version


def read(language: str) -> dict:
    """{English: translation} of a language's file."""
    lines = (_FOLDER / f"{language}.tsv").read_text(encoding="utf-8").splitlines()
    return dict(line.replace("\\n", "\n").split("\t") for line in lines if line)


def register() -> None:
    contexts = (CONTEXT, bpy.app.translations.contexts.default, bpy.app.translations.contexts.operator_default)
    known = {}
    for language, locales in _LOCALES.items():
        entries = {(context, english): own for english, own in read(language).items() for context in contexts}
        known |= dict.fromkeys(locales, entries)
    bpy.app.translations.register(__package__, known)


def unregister() -> None:
    bpy.app.translations.unregister(__package__)
