"""Names of earlier versions, which work until the next one."""

import warnings
from collections.abc import Callable, Mapping
from importlib import import_module


def by_old_name(package: str, new: Mapping[str, str]) -> Callable[[str], object]:
    """The function `__getattr__` of a package. new: by old name the new one in isimp_engine, or its private place."""

    def thing(name: str) -> object:
        if name not in new:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, now = f"{__package__}.{new[name]}".rpartition(".")
        is_what = "is private from the next version on:" if "." in new[name] else "is now"
        warnings.warn(f"{package}.{name} {is_what} {module}.{now}", DeprecationWarning, stacklevel=2)
        found: object = getattr(import_module(module), now)
        return found

    return thing
