"""Which mesh files a URDF names for the looks of its links, and where they lie; they are not opened here."""

import os
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from ..pose import Pose
from ..robot import Mesh

_ZEROS, _ONES = "0 0 0", "1 1 1"


def meshes_of(link: ElementTree.Element, source: Path) -> tuple[Mesh, ...]:
    """Meshes of a link's visuals, in its frame; a visual that cannot be understood is passed over.

    Args:
        link: the URDF's element.
        source: the URDF.
    """
    return tuple(mesh for visual in link.findall("visual") for mesh in _mesh(visual, source))


def _mesh(visual: ElementTree.Element, source: Path) -> Iterator[Mesh]:
    element = visual.find("geometry/mesh")
    if element is None or not element.get("filename"):
        return
    origin = visual.find("origin")
    place = origin if origin is not None else ElementTree.Element("origin")
    try:
        pose = Pose.from_rpy(_three(place.get("xyz", _ZEROS)), _three(place.get("rpy", _ZEROS)))
        yield Mesh(_file(element.get("filename", ""), source), pose, _three(element.get("scale", _ONES)))
    except ValueError:  # looks are no reason to refuse a robot
        return


def _three(text: str) -> tuple[float, float, float]:
    x, y, z = map(float, text.split())
    return x, y, z


def _file(name: str, source: Path) -> str:
    """The file, or its name as written where it is not found.

    ``package://NAME/..`` is sought in the folders above the URDF and in those that ROS names by its environment.
    """
    places = _places(name, source.resolve().parent)
    return next((str(place) for place in places if place.is_file()), name)


def _places(name: str, folder: Path) -> Iterator[Path]:
    scheme, _, rest = name.partition("://")
    if not rest:
        yield folder / name
    elif scheme == "file":
        yield Path(rest)
    elif scheme in ("package", "model"):
        package, _, inside = rest.partition("/")
        for above in (folder, *folder.parents):
            yield above / package / inside
            if above.name == package:
                yield above / inside
        for root in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
            yield Path(root) / package / inside
            yield Path(root).parent / package / inside
        for root in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
            yield Path(root) / "share" / package / inside
