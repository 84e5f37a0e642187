"""Reads the add-on's properties of a datablock as stored in the file, without Blender's conversion of types.

If a stored value has another type than its property, Blender drops the value when the property is read, and with it
data of a later version. So this module reads stored values, and moves foreign ones before properties are written.
"""

from idprop.types import IDPropertyGroup

_NAME = "isimp"
KEPT = f"{_NAME}.kept"  #: custom properties with moved foreign values
_TEXTS = frozenset({"user_color", "key", "scan_key", "scan_name", "made", "named", "placed", "unrendered"})


def _home(block):
    """Return the group with properties registered by add-ons. Since 5.0 it is separate from custom properties."""
    return block.bl_system_properties_get() if hasattr(block, "bl_system_properties_get") else block


def _found(block):
    home = _home(block)
    return None if home is None else home.get(_NAME)


def text(block, name: str) -> str:
    """Return a text property; empty if there is none."""
    group = _found(block)
    value = group.get(name, "") if isinstance(group, IDPropertyGroup) else ""
    return value if isinstance(value, str) else ""


def nodes(mesh) -> list | None:
    """Return the steps' groups of values, in order; None if another value is in their place.

    The groups are invalid after a node is added or removed.
    """
    group = _found(mesh)
    found = [] if group is None else group.get("nodes", []) if isinstance(group, IDPropertyGroup) else None
    return found if _are_nodes(found) else None


def _are_nodes(value) -> bool:
    return isinstance(value, list) and all(isinstance(each, IDPropertyGroup) for each in value)


def move_foreign(block) -> None:
    """Moves foreign values out of the add-on's properties, so that these can be written."""
    group = _found(block)
    if group is None:
        return
    if not isinstance(group, IDPropertyGroup):
        _keep(block, group)
        del _home(block)[_NAME]
        return
    for name in list(group.keys()):
        value = group[name]
        if (name in _TEXTS and not isinstance(value, str)) or (name == "nodes" and not _are_nodes(value)):
            _keep(block, {name: value})
            del group[name]


def _keep(block, value) -> None:
    names = kept(block)
    number = next(number for number in range(1, len(names) + 2) if _numbered(number) not in names)
    block[_numbered(number)] = value


def _numbered(number: int) -> str:
    return KEPT if number == 1 else f"{KEPT}.{number}"


def kept(block) -> list:
    """Return the names of the custom properties with moved values."""
    names = block.keys()  # a datablock itself is not iterable
    return [name for name in names if name == KEPT or name.startswith(f"{KEPT}.")]
