"""Registers translations of the interface. Each language has a file with lines `English<tab>translation`."""

from pathlib import Path

import bpy

from .. import language

CONTEXT = "iSimp"  #: context of operators, menus and panels: Blender has other translations of their names
_FOLDER = Path(__file__).parents[1] / "translations"
_LOCALES = {"de": ("de", "de_DE")}  #: names of a language in the versions of Blender


def read(language: str) -> dict:
    """Return {English: translation} of a language's file."""
    lines = (_FOLDER / f"{language}.tsv").read_text(encoding="utf-8").splitlines()
    return dict(line.replace("\\n", "\n").split("\t") for line in lines if line)


def _said(text: str) -> str:
    return bpy.app.translations.pgettext_iface(text, CONTEXT)


def register() -> None:
    contexts = (CONTEXT, bpy.app.translations.contexts.default, bpy.app.translations.contexts.operator_default)
    known = {}
    for name, locales in _LOCALES.items():
        entries = {(context, english): own for english, own in read(name).items() for context in contexts}
        known |= dict.fromkeys(locales, entries)
    bpy.app.translations.register(__package__, known)
    language.speak(_said)


def unregister() -> None:
    language.speak(str)
    bpy.app.translations.unregister(__package__)
