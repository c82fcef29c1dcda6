"""The XML reader: a path, XML text or open file in, an XML tree with line numbers out; no entities, no network."""

import codecs
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from lxml import etree

from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.typing import Array

TEXT = "<text>"
XACRO_HINT = "for a xacro, end the file's name in .xacro, or give xacro_args (--xacro-arg NAME:=VALUE)"

_DECLARED_ENCODING = re.compile(rb"\s*<\?xml\s[^>]*?\bencoding\s*=\s*[\"']([\w.:-]+)[\"']", re.ASCII)
_DECLARATION = re.compile(r"\A\s*<\?xml\s.*?\?>", re.DOTALL)
_PROLOG_PART = re.compile(r"\s+|<\?.*?\?>|<!--.*?-->", re.DOTALL)
_XACRO_EXPRESSION = re.compile(r"\$[({]")


# What a file of another kind has to become.
_ROOT_HINTS = {
    "sdf": "this is SDF: write it as URDF first, or give the URDF or xacro that it was made from",
    "COLLADA": "this is a mesh: give the URDF that refers to it",
    "package": "this is a ROS package's manifest: give a file of its urdf folder",
    "launch": "this is a launch file: give the URDF or xacro that it names",
}


class Source(NamedTuple):
    """A URDF's text, how messages call it, and the file it came from, if any."""

    text: str
    name: str
    path: Path | None


def open_source(source: Any) -> Source:
    """The text of a path, of XML text, or of an open text or binary file."""
    if isinstance(source, str | bytes):
        text = _text(source, TEXT)
        if text.lstrip().startswith("<"):
            return Source(text, TEXT, None)
        if not text.strip():
            raise UrdfError("the text is empty", source=TEXT, hint="give a URDF's path or its XML text")
        if not isinstance(source, str):
            raise UrdfError(f"{source[:40]!r} is no XML", source=TEXT, hint="XML text begins with '<'")
    if isinstance(source, str | os.PathLike):
        return _open_path(os.fspath(source))
    named = getattr(source, "name", None)
    name = named if isinstance(named, str) and named else TEXT
    try:
        content = source.read()
    except (OSError, ValueError) as error:  # ValueError: a closed file; UnicodeDecodeError is one too
        raise UrdfError(f"cannot read the open file: {error}", source=name, hint="open it as UTF-8 or 'rb'") from None
    return Source(_text(content, name), name, None)


def parse(source: Source) -> Any:
    """The ``<robot>`` element of the text, parsed without entities and without the network."""
    # The text is decoded already, and its version changes nothing. Lines stay.
    text = _DECLARATION.sub(lambda found: "\n" * found[0].count("\n"), source.text, count=1)
    data = text.encode(errors="surrogatepass")  # the parser refuses halves of surrogate pairs, and says the line
    root = _tree(data, source.name)
    if root.getroottree().docinfo.internalDTD is not None:
        hint, line = "delete the DOCTYPE and write out its entities", text.count("\n", 0, text.index("<!DOCTYPE")) + 1
        raise UrdfError("a DOCTYPE is refused", source=source.name, line=line, element="<!DOCTYPE>", hint=hint)
    if tag(root) != "robot":
        element, hint = f"<{root.tag}>", _ROOT_HINTS.get(str(root.tag), "a URDF is one <robot name=...> element")
        problem = f"the root element is {element}, not <robot>"
        raise UrdfError(problem, source=source.name, line=root.sourceline, element=element, hint=hint)
    return root


def tag(element: Any) -> str:
    """Name of an element as URDF readers see it; '' for comments and for names with a namespace prefix."""
    if not isinstance(element.tag, str) or element.prefix is not None:
        return ""
    return element.tag.rpartition("}")[2]


def children(element: Any, name: str) -> Iterator[Any]:
    """Direct children called ``name``, in the file's order."""
    return (child for child in element.iterchildren("{*}" + name) if child.prefix is None)


def child(element: Any, name: str) -> Any:
    """First direct child called ``name``, or None."""
    return next(children(element, name), None)


def is_xacro(element: Any) -> bool:
    """Whether the element is a leftover of xacro that could have become part of the robot."""
    if not isinstance(element.tag, str):
        return False
    prefixed = element.prefix == "xacro" or element.tag.startswith("xacro:")
    return prefixed and written_tag(element) not in ("xacro:property", "xacro:arg")


def written_tag(element: Any) -> str:
    """Name of an element as its author wrote it, with the prefix."""
    name: str = element.tag.rpartition("}")[2]
    return f"{element.prefix}:{name}" if element.prefix is not None else name


def numbers_text(values: Iterable[float]) -> str:
    """Numbers as an attribute holds them, to all digits; no negative zero."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def origin_attributes(T: Array) -> dict[str, str]:
    """A pose (4, 4) [m] as the attributes of an ``<origin>``."""
    return {"xyz": numbers_text(T[:3, 3]), "rpy": numbers_text(to_rpy(T))}


def floats(element: Any, name: str, otherwise: tuple[float, ...] = ()) -> tuple[float, ...]:
    """The numbers of an attribute of a URDF that was read, or ``otherwise``."""
    return tuple(map(float, (element.get(name) or "").split())) or otherwise


def origin_of(element: Any) -> Array:
    """The pose (4, 4) [m] of a shape of a URDF that was read, by its ``<origin>``."""
    origin, zero = element.find("origin"), (0.0, 0.0, 0.0)
    return np.eye(4) if origin is None else pose(floats(origin, "xyz", zero), rpy=floats(origin, "rpy", zero))


def has_xacro(value: str | None) -> bool:
    """Whether an attribute's value holds an unresolved ``$(...)`` or ``${...}``."""
    return value is not None and _XACRO_EXPRESSION.search(value) is not None


def _open_path(name: str | bytes) -> Source:
    label = os.fsdecode(name)
    path = Path(label)
    try:
        directory, data = path.is_dir(), path.read_bytes() if path.is_file() else None
    except OSError as error:
        raise UrdfError(f"cannot read: {error.strerror}", source=label, hint="check its path and rights") from None
    if data is not None:
        return Source(_text(data, label), label, path.absolute())
    if directory:
        there = ", ".join(sorted(file.name for file in path.glob("*.urdf"))[:5])
        hint = f"choose one of its files: {there}" if there else "give the path of a .urdf file"
        raise UrdfError("a directory, not a file", source=label, hint=hint)
    hint = "check the path; XML text begins with '<'"
    raise UrdfError("neither an existing file nor XML text", source=label, hint=hint)


def _text(content: str | bytes, name: str) -> str:
    """Text as it is; bytes as their byte order mark or their XML declaration says, else as UTF-8."""
    if isinstance(content, str):
        return content.removeprefix("\ufeff")
    declared = _DECLARED_ENCODING.match(content)
    encoding = declared[1].decode() if declared else "utf-8-sig"
    if content.startswith(codecs.BOM_UTF8):
        encoding = "utf-8-sig"
    elif content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        problem = f"not {encoding.removesuffix('-sig')} text: byte 0x{content[error.start]:02x}"
        hint = "save the file as UTF-8, or declare its encoding in <?xml ... encoding=...?>"
        line = content.count(b"\n", 0, error.start) + 1
        raise UrdfError(problem, source=name, line=line, hint=hint) from None
    except LookupError as error:
        raise UrdfError(f"unusable encoding: {error}", source=name, line=1, hint="save the file as UTF-8") from None


def prolog_end(text: str) -> int:
    """Where the text's DOCTYPE or first element begins: behind white space, comments and instructions."""
    end = 0
    while (part := _PROLOG_PART.match(text, end)) is not None:
        end = part.end()
    return end


def _parser(recover: bool) -> Any:
    return etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False, recover=recover, encoding="utf-8")


def _tree(data: bytes, name: str) -> Any:
    """Parse strictly, except for slips that every URDF reader forgives and that lose nothing."""
    parser = _parser(recover=False)
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        if _first_fatal(parser.error_log) is None and len(parser.error_log):
            forgiving = _parser(recover=True)
            root = etree.fromstring(data, forgiving)
            if root is not None and _first_fatal(forgiving.error_log) is None:
                return root
        worst = _first_fatal(parser.error_log)
        problem, line = (worst.message, worst.line) if worst else (error.msg or "unreadable", error.lineno)
    if not data.strip():
        raise UrdfError("empty: it holds no XML", source=name, line=1, hint="a URDF is one <robot> element") from None
    early = b"<robot" in data and b"</robot" not in data
    hint = "the text ends early: </robot> is missing" if early else "correct the XML at this line"
    raise UrdfError(f"malformed XML: {problem}", source=name, line=line, hint=hint) from None


def _first_fatal(log: Any) -> Any:
    return next(
        (entry for entry in log if entry.level_name == "FATAL" and entry.type_name != "ERR_HYPHEN_IN_COMMENT"), None
    )


def require_name(name: Any, owner: str) -> None:
    """That ``name`` can stand in a URDF, as that of what is added to one."""
    if not isinstance(name, str) or not name:
        raise ArgumentError(f"name={name!r} given; {owner} needs a name, a text that is not empty")
    try:
        etree.Element("link", name=name)
    except ValueError as error:
        raise ArgumentError(f"name={name!r} cannot be written into a URDF: {error}") from None
