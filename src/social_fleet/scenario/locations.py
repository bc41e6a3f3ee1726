"""Where a scenario's map is: relative to the file, absolute, or ``package://social_fleet/…``, with or without ROS."""

import os

from social_fleet.errors import InvalidScenario

PACKAGE = "package://social_fleet/"


def package_folder() -> str:
    """The folder that holds ``maps`` and ``config``, in the source space and in an install space.

    Raises
    ------
    InvalidScenario
        When neither stands beside this Python package.
    """
    folder = os.path.dirname(os.path.realpath(__file__))
    while True:
        for candidate in (folder, os.path.join(folder, "share", "social_fleet")):
            if os.path.isdir(os.path.join(candidate, "maps")) and os.path.isdir(os.path.join(candidate, "config")):
                return candidate
        parent = os.path.dirname(folder)
        if parent == folder:
            raise InvalidScenario("the folders maps and config of the package social_fleet were not found beside "
                                  f"{__file__}; give the map by its absolute path")
        folder = parent


def resolve(name: str, relative_to: str) -> str:
    """The absolute path of `name` as written in a file in the folder `relative_to`.

    Raises
    ------
    InvalidScenario
        When `name` is in another package.
    """
    if name.startswith(PACKAGE):
        return os.path.join(package_folder(), name[len(PACKAGE):])
    if "://" in name:
        raise InvalidScenario(f"only {PACKAGE}… is understood, not {name!r}; "
                              "or give a path, absolute or relative to this file")
    return os.path.normpath(os.path.join(os.path.abspath(relative_to), os.path.expanduser(name)))


def refer(path: str, relative_to: str) -> str:
    """The name for `path` that a file in the folder `relative_to` should hold: `resolve`'s inverse.

    A map of the package is named by package, so that the file can be moved; any other relative to the file.
    """
    target = os.path.realpath(path)
    try:
        inside = os.path.relpath(target, os.path.realpath(package_folder()))
    except InvalidScenario:
        inside = os.pardir
    if not inside.startswith(os.pardir):
        return PACKAGE + inside.replace(os.sep, "/")
    return os.path.relpath(target, os.path.realpath(relative_to))
