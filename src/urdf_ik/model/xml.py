"""The hardened XML parser: a path, XML text or open file in, an XML tree with line numbers out."""

from __future__ import annotations

import codecs
import gzip
import io
import os
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree

from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.support import files
from urdf_ik.support.text import quoted

TEXT = "<text>"
MAX_BYTES = 8 * 2**20
"""Greatest size of a URDF: a tree of XML takes up to sixty times as much, and the greatest robots have one MiB."""
ENCODINGS = frozenset(
    [*(f"utf-{kind}" for kind in ("7", "8", "8-sig", "16", "16-le", "16-be", "32", "32-le", "32-be")), "ascii", "cp437"]
    + [f"iso8859-{k}" for k in (*range(1, 12), *range(13, 17))] + [f"cp125{k}" for k in range(9)]
    + ["koi8-r", "koi8-u", "gb2312", "gbk", "gb18030", "big5", "shift_jis", "cp932", "euc_jp", "iso2022_jp", "euc_kr"]
)  # fmt: skip
"""Codecs of the encodings that XML parsers know; Python's others do not encode text, or are slow."""
XACRO_HINT = "for a xacro, end the file's name in .xacro, or give xacro_args (--xacro-arg NAME:=VALUE)"

_GZIP = b"\x1f\x8b"
_TOO_LARGE = f"it is larger than {MAX_BYTES >> 20} MiB"
_BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARED_ENCODING = re.compile(rb"\s*<\?xml\s[^>]*?\bencoding\s*=\s*[\"']([\w.:-]+)[\"']", re.ASCII)
_DECLARATION = re.compile(r"\s*<\?xml\s.*?\?>", re.DOTALL)
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


def open_source(source: object) -> Source:
    """Get the text of a path, of XML text, or of an open text or binary file.

    Raises:
        UrdfError: there is nothing to read there, or it is no text.
    """
    if isinstance(source, str | bytes | bytearray):
        start = source.lstrip() if isinstance(source, str) else _without_bom(bytes(source)).lstrip()
        if start[:1] in ("<", b"<", "\ufeff") or (isinstance(start, bytes) and start.startswith(_GZIP)):
            return Source(_text(source, TEXT), TEXT, None)
        if not start:
            raise UrdfError("the text is empty", source=TEXT, hint="give a URDF's path or its XML text")
        if not isinstance(source, str):
            raise UrdfError(f"{quoted(start[:40])} is no XML", source=TEXT, hint="XML text begins with '<'")
        return _open_path(source)
    if isinstance(source, os.PathLike):
        return _open_path(os.fspath(source))
    if not hasattr(source, "read"):
        raise UrdfError(
            f"cannot read a URDF from {type(source).__name__} {quoted(source)}",
            source=TEXT,
            hint="give a path, XML text (str or bytes) or an open file",
        )
    named = getattr(source, "name", None)
    name = named if isinstance(named, str) and named else TEXT
    try:
        content = files.from_open(source, MAX_BYTES)
    except UrdfError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a closed file; UnicodeDecodeError is one too
        raise UrdfError(f"cannot read the open file: {error}", source=name, hint="open it as UTF-8 or 'rb'") from None
    if not isinstance(content, str | bytes):
        raise UrdfError(f"read() gave {type(content).__name__}", source=name, hint="it must give str or bytes")
    return Source(_text(content, name), name, None)


def parse(source: Source) -> Any:
    """Parse the text into a tree without a DOCTYPE, an entity or the network; gives the ``<robot>`` element.

    Raises:
        UrdfError: the XML is malformed, truncated or empty, has a DOCTYPE, or is no ``<robot>``.
    """
    text = _without_declaration(source.text)
    _refuse_doctype(text, source.name)
    try:
        data = text.encode()
    except UnicodeEncodeError as error:
        line = text.count("\n", 0, error.start) + 1
        raise UrdfError(f"not UTF-8: {error.reason}", source=source.name, line=line, hint="save as UTF-8") from None
    root = _tree(data, source.name)
    if root.getroottree().docinfo.internalDTD is not None:
        raise UrdfError("a DOCTYPE is refused", source=source.name, hint="delete the DOCTYPE and its entities")
    if tag(root) != "robot":
        raise UrdfError(
            f"the root element is <{root.tag}>, not <robot>",
            source=source.name,
            line=root.sourceline,
            element=f"<{root.tag}>",
            hint=_ROOT_HINTS.get(str(root.tag), "a URDF is one <robot name=...> element"),
        )
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


def has_xacro(value: str | None) -> bool:
    """Whether an attribute's value holds an unresolved ``$(...)`` or ``${...}``."""
    return value is not None and _XACRO_EXPRESSION.search(value) is not None


def _open_path(name: str | bytes) -> Source:
    label = os.fsdecode(name)
    path = Path(label)
    try:
        if path.is_file():
            if path.stat().st_size > MAX_BYTES:
                raise UrdfError(_TOO_LARGE, source=label, hint="a URDF holds no meshes")
            return Source(_text(_file_bytes(path), label), label, path.absolute())
        directory = path.is_dir()
    except UrdfError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        reason = getattr(error, "strerror", None) or str(error)
        name_shown = _shorten(label)
        raise UrdfError(f"cannot read: {reason}", source=name_shown, hint="check its path and rights") from None
    if directory:
        found = ", ".join(sorted(each.name for each in path.glob("*.urdf"))[:5])
        hint = f"choose one of its files: {found}" if found else "give the path of a .urdf file"
        raise UrdfError("a directory, not a file", source=label, hint=hint)
    raise UrdfError(
        "neither an existing file nor XML text", source=_shorten(label), hint="check the path; XML text begins with '<'"
    )


def _file_bytes(path: Path) -> bytes:
    """The file, up to a little more than the size that is read at all: what it says of its size may change."""
    with files.opened(path) as file:
        return file.read(MAX_BYTES + 1)


def _shorten(label: str) -> str:
    """A source's name, cut where it is long, on one line."""
    line = " ".join(label.split())
    return line if len(line) <= 120 else line[:117] + "..."


def _without_bom(data: bytes) -> bytes:
    for bom, encoding in _BOMS:
        if data.startswith(bom):
            return data[:400].decode(encoding, errors="ignore").encode() or data[len(bom) :]
    return data


def _text(content: str | bytes | bytearray, name: str) -> str:
    if len(content) > MAX_BYTES:
        raise UrdfError(_TOO_LARGE, source=name, hint="a URDF holds no meshes")
    if isinstance(content, str):
        return content.removeprefix("\ufeff")
    data = _unpacked(bytes(content), name)
    encoding = next((encoding for bom, encoding in _BOMS if data.startswith(bom)), None)
    if encoding is None:
        declared = _DECLARED_ENCODING.match(data)
        encoding = declared[1].decode() if declared else "utf-8"
    try:
        if codecs.lookup(encoding).name not in ENCODINGS:
            raise LookupError(f"{encoding} is none that XML parsers know")
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise UrdfError(
            f"not {encoding} text: byte 0x{data[error.start]:02x}",
            source=name,
            line=data.count(b"\n", 0, error.start) + 1,
            hint="save the file as UTF-8, or declare its encoding in <?xml ... encoding=...?>",
        ) from None
    except (LookupError, ValueError) as error:
        raise UrdfError(f"unusable encoding: {error}", source=name, line=1, hint="save the file as UTF-8") from None


def _unpacked(data: bytes, name: str) -> bytes:
    """Gzip data unpacked, up to the greatest size that is read; other data unchanged."""
    if not data.startswith(_GZIP):
        return data
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
            unpacked = stream.read(MAX_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise UrdfError(f"damaged gzip data: {error}", source=name, hint="compress the file again") from None
    if len(unpacked) > MAX_BYTES:
        raise UrdfError(f"it unpacks to more than {MAX_BYTES >> 20} MiB", source=name, hint="a URDF holds no meshes")
    return unpacked


def _without_declaration(text: str) -> str:
    """Blank the XML declaration: the text is decoded already, and its version changes nothing. Lines stay."""
    found = _DECLARATION.match(text)
    return "\n" * found[0].count("\n") + text[found.end() :] if found else text


def prolog_end(text: str) -> int:
    """Where the text's DOCTYPE or first element begins: behind white space, comments and instructions."""
    end = 0
    while (part := _PROLOG_PART.match(text, end)) is not None:
        end = part.end()
    return end


def _refuse_doctype(text: str, name: str) -> None:
    """Refuse a DOCTYPE before the parser sees it, so that no entity is ever expanded."""
    end = prolog_end(text)
    if text.startswith("<!DOCTYPE", end):
        raise UrdfError(
            "a DOCTYPE is refused",
            source=name,
            line=text.count("\n", 0, end) + 1,
            element="<!DOCTYPE>",
            hint="delete the DOCTYPE and write out what its entities stand for",
        )


def _parser(recover: bool) -> Any:
    return etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False, recover=recover, encoding="utf-8")


def _tree(data: bytes, name: str) -> Any:
    """Parse strictly, except for slips that every URDF reader forgives and that lose nothing.

    These are an undeclared namespace prefix (old Gazebo tags) and a double hyphen in a comment; when the
    parser's log holds nothing worse, its recovered tree is complete.
    """
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
    raise UrdfError(
        f"malformed XML: {problem}",
        source=name,
        line=line,
        hint="the text ends early: </robot> is missing" if early else "correct the XML at this line",
    ) from None


def _first_fatal(log: Any) -> Any:
    return next(
        (entry for entry in log if entry.level_name == "FATAL" and entry.type_name != "ERR_HYPHEN_IN_COMMENT"), None
    )


def require_name(name: Any, owner: str) -> None:
    """That ``name`` can stand in a URDF, as that of what is added to one.

    Raises:
        ArgumentError: it is no text, or empty, or holds what XML does not.

    Example:
        >>> require_name("", "the tool's link")
        Traceback (most recent call last):
        urdf_ik.errors.ArgumentError: name='' given; the tool's link needs a name, a text that is not empty
    """
    if not isinstance(name, str) or not name:
        raise ArgumentError(f"name={quoted(name)} given; {owner} needs a name, a text that is not empty")
    try:
        etree.Element("link", name=name)
    except ValueError as error:
        raise ArgumentError(f"name={quoted(name)} cannot be written into a URDF: {error}") from None
