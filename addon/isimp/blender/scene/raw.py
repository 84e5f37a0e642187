"""The add-on's own properties of a datablock as they lie in the file, whatever is in their place.

Where a value is of another type than its property, Blender drops it as soon as the property is read, and with it what a
later version may have meant. So they are read as they lie here, and moved aside before they are written.
"""

from idprop.types import IDPropertyGroup

_NAME = "isimp"
KEPT = f"{_NAME}.kept"  #: custom properties with foreign values that were in the place of the add-on's own
_TEXTS = frozenset({"user_color", "key", "scan_key", "scan_name", "made", "named", "placed", "unrendered"})


def _home(block):
    """The group that holds properties registered by add-ons: since 5.0 apart from the custom properties."""
    return block.bl_system_properties_get() if hasattr(block, "bl_system_properties_get") else block


def _found(block):
    home = _home(block)
    return None if home is None else home.get(_NAME)


def text(block, name: str) -> str:
    """A property that is text; empty where there is none."""
    group = _found(block)
    value = group.get(name, "") if isinstance(group, IDPropertyGroup) else ""
    return value if isinstance(value, str) else ""


def nodes(mesh) -> list | None:
    """The steps' groups of values, in order; None if something else is in their place.

    They are good until a node is added or removed, and no longer.
    """
    group = _found(mesh)
    found = [] if group is None else group.get("nodes", []) if isinstance(group, IDPropertyGroup) else None
    return found if _are_nodes(found) else None


def _are_nodes(value) -> bool:
    return isinstance(value, list) and all(isinstance(each, IDPropertyGroup) for each in value)


def make_way(block) -> None:
    """Moves foreign values out of the place of the add-on's properties, so that these can be written."""
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
    """The names of the custom properties with values that were moved aside."""
    names = block.keys()  # a datablock itself is no dictionary
    return [name for name in names if name == KEPT or name.startswith(f"{KEPT}.")]
