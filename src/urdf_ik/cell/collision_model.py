"""CollisionModel: the collision shapes of an arm and of a world, and the pairs that must not touch."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping
from types import MappingProxyType
from typing import Any

from urdf_ik.cell import allowed_collisions, coal_shapes
from urdf_ik.cell.allowed_collisions import Table
from urdf_ik.cell.coal_check import ArmShapes, CoalCheck, LinkCheck
from urdf_ik.cell.collision_queries import CollisionQueries, Seen
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.cell.world import World
from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.model import srdf as srdf_reader
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted

Pair = tuple[str, str]

SAMPLES, MOST_SAMPLES = 200, 10**6
"""Random joint vectors by which pairs that always collide are found, and the most of them."""

ALWAYS = 0.95
"""A pair that collides in at least this share of the sampled joint vectors counts as always colliding."""

SEED = 0
"""Seed of these joint vectors: the same URDF gives the same pairs."""


class CollisionModel(CollisionQueries):
    """The collision shapes of a URDF and of a world, and the pairs that must not touch.

    Joints outside the chain stay at zero; a joint that mimics another follows it. Meshes are surfaces: a mesh wholly
    inside another one does not touch it. The answer for a joint vector does not depend on earlier queries.
    A model is immutable: :meth:`in_world`, :meth:`allow` and :meth:`check` return new ones, which share the shapes.
    The world may change; each query uses its present state. Any number of threads may use one model.

    Attributes:
        joint_names: joints of a joint vector, base to tip.
        world: the world, or None.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> model = CollisionModel(arm.model, arm.base, arm.tip)
        >>> model.in_collision([0.0] * 6)
        False
        >>> model
        <CollisionModel of joint_1, joint_2, joint_3, joint_4, joint_5, joint_6: 15 pairs checked>
    """

    def __init__(
        self,
        model: UrdfModel,
        base: str | None = None,
        tip: str | None = None,
        *,
        srdf: str | os.PathLike[str] | bytes | None = None,
        disabled: Collection[Pair] = (),
        samples: int = SAMPLES,
        seed: int = SEED,
        locked: Mapping[str, float] | None = None,
    ) -> None:
        """Read the collision shapes and decide which pairs to check.

        Args:
            model: the URDF as it was read; meshes come from its ``package_dirs`` only.
            base: base link; default: the root.
            tip: tip link; default: the end of the only movable chain.
            srdf: path or text of an SRDF whose ``disable_collisions`` are allowed pairs.
            disabled: pairs of an SRDF that was read already.
            samples: number of random joint vectors in the search for pairs that always collide; 0: no search.
            seed: seed of these joint vectors.
            locked: fixed values of joints outside the joint vector [rad or m].

        Raises:
            UrdfError: the SRDF is broken, or names a link that the URDF does not have.
            ChainError: base or tip is unknown, or the tip is ambiguous.
            ArgumentError: ``samples`` or ``seed`` is not a whole number, or out of range.
            UnsupportedArm: the chain has a joint with more than one degree of freedom.
        """
        held = inputs.mapping({} if locked is None else locked, "locked", "a value for each joint by name")
        samples = inputs.whole(samples, "samples", high=MOST_SAMPLES)
        seed = inputs.whole(seed, "seed", high=2**64)
        self._made_from = (model, base, tip, dict(held), samples, seed)
        self._reference = Reference(model, base, tip, locked=locked)
        self.joint_names = self._reference.joint_names
        self.world: World | None = None
        self._rank = {link: i for i, link in enumerate(model.links)}
        self._changes: dict[Pair, bool] = {}
        self._error: UrdfError | None = None
        self._seen: Seen | None = None
        self._link_check: LinkCheck | None = None
        # The last result of ``in_world``, as most callers use one world again and again.
        self._last: CollisionModel | None = None
        disabled = (*disabled, *(() if srdf is None else srdf_reader.disabled_pairs(srdf, model.links)))
        try:
            shapes = coal_shapes.build(model, self._reference.pin_model)
        except UrdfError as error:
            self._error = error
            return
        chain = from_urdf(model, base, tip).lock(locked or {})
        self._arm = ArmShapes(self._reference, chain, shapes)
        excused = {allowed_collisions.ordered(*pair, self._rank) for pair in disabled}
        self._allowed, self._pairs = allowed_collisions.among_links(self._arm, self._rank, excused)
        if samples:
            kept = [pair for pair in self._pairs if pair.names not in self._allowed]
            always = allowed_collisions.always_colliding(LinkCheck(self._arm, kept), ALWAYS, samples, seed)
            self._allowed.update(dict.fromkeys(always, allowed_collisions.ALWAYS_COLLIDE))

    def __reduce__(self) -> tuple[Callable[..., CollisionModel], tuple[Any, ...]]:
        allowed = None if self._error is not None else dict(self._allowed)
        return _restored, (*self._made_from, allowed, dict(self._changes), self.world)

    def __repr__(self) -> str:
        known = "without shapes" if self._error else f"{len(self.checked_pairs)} pairs checked"
        return f"<CollisionModel of {', '.join(self.joint_names)}: {known}>"

    @property
    def has_geometry(self) -> bool:
        """Whether the collision shapes were read; if not, every check raises, and ``missing`` says why."""
        return self._error is None

    @property
    def missing(self) -> str:
        """The reason why ``has_geometry`` is false, else ''."""
        return "" if self._error is None else str(self._error)

    @property
    def unchecked(self) -> str:
        """The same in a few words, such as '6 meshes missing'."""
        return "" if self._error is None else coal_shapes.why_unreadable(self._made_from[0])

    @property
    def allowed_pairs(self) -> Mapping[Pair, str]:
        """Pairs that may touch, in the URDF's order of links and the world's of obstacles, to the reason.

        Reasons are 'rigid', 'adjacent', 'srdf', 'always' and 'allowed'.
        """
        return MappingProxyType({}) if self._error else self._table().allowed

    @property
    def checked_pairs(self) -> tuple[Pair, ...]:
        """Pairs that must not touch, two links or a link and an obstacle."""
        return () if self._error else self._table().checked

    def table(self) -> Table:
        """The allowed-collision table, to be read and printed; :meth:`allow` and :meth:`check` change it.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> print(urdf_ik.load("planar_2r").cell.collisions.table())
            first      second
            base_link  link_2  checked
            base_link  link_1  allowed: adjacent
            link_1     link_2  allowed: adjacent
        """
        self._require_geometry()
        return self._table()

    def in_world(self, world: World | None) -> CollisionModel:
        """This model among the obstacles of a world, which may be changed later; itself where ``world`` is None.

        Every link that the joint vector moves against the base link is checked against every obstacle. The other links
        stand on the world, and may touch it ('rigid').

        Example:
            >>> import urdf_ik
            >>> world = urdf_ik.World()
            >>> world.add("floor", urdf_ik.HalfSpace((0, 0, 1)))
            >>> model = urdf_ik.load("planar_2r").cell.collisions
            >>> len(model.in_world(world).checked_pairs) - len(model.checked_pairs)
            2
        """
        if world is None or world is self.world:
            return self
        inputs.kind(world, "snapshot", "world", "a urdf_ik.World")
        last = self._last
        if last is None or last.world is not world:
            if self._error is None:
                self._links()  # made once for all worlds
            last = self._copy()
            last.world = world
            self._last = last
        return last

    def allow(self, first: str, second: str) -> CollisionModel:
        """This model with one more pair that may touch.

        Args:
            first: a link, or an obstacle of the world.
            second: another one.

        Raises:
            ArgumentError: there is no such link or obstacle, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> model = urdf_ik.load("zyyzyz_6r").cell.collisions
            >>> pair = model.checked_pairs[0]
            >>> model.allow(*pair).allowed_pairs[pair]
            'allowed'
        """
        return self._changed(first, second, False)

    def check(self, first: str, second: str) -> CollisionModel:
        """This model with a pair that must not touch, whatever allowed it to.

        Args:
            first: a link, or an obstacle of the world.
            second: another one.

        Raises:
            ArgumentError: there is no such link or obstacle, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> model = urdf_ik.load("zyyzyz_6r").cell.collisions
            >>> pair = next(iter(model.allowed_pairs))
            >>> pair in model.checked_pairs, pair in model.check(*pair).checked_pairs
            (False, True)
        """
        return self._changed(first, second, True)

    def checking(self, pairs: Collection[Pair]) -> CollisionModel:
        """This model, checking these pairs of links and no others.

        Raises:
            ArgumentError: there is no such link, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> model = urdf_ik.load("zyyzyz_6r").cell.collisions
            >>> model.checking(model.checked_pairs[:3]).checked_pairs == model.checked_pairs[:3]
            True
        """
        needed = "pairs of links' names"
        every = inputs.items(pairs, "pairs", needed)
        given = [inputs.items(each, "a pair", needed) for each in every]
        if any(len(each) != 2 or not all(isinstance(name, str) for name in each) for each in given):
            raise ArgumentError(f"pairs={quoted(pairs)} given; {needed} are needed")
        own, wanted, model = set(self.checked_pairs), {(first, second) for first, second in given}, self
        for pair in sorted(own - wanted):
            model = model.allow(*pair)
        for pair in sorted(wanted - own):
            model = model.check(*pair)
        return model

    @property
    def is_changed(self) -> bool:
        """Whether anything but the URDF decides what is checked: an SRDF, :meth:`allow` or :meth:`check`, a world."""
        is_special = self._changes or self.world or allowed_collisions.SRDF in self._allowed.values()
        return self._error is None and bool(is_special)

    def rebuilt(
        self, model: UrdfModel, base: str | None, tip: str | None, locked: Mapping[str, float] | None
    ) -> CollisionModel:
        """The model of a URDF that has this one's links and more, with this one's SRDF, changes and world.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> longer = arm.with_tool(urdf_ik.pose([0.0, 0.0, 0.1]), [urdf_ik.Sphere(0.02)], name="probe")
            >>> model = arm.cell.collisions.rebuilt(longer.model, longer.base, longer.tip, None)
            >>> any("probe" in pair for pair in model.checked_pairs)
            True
        """
        out = type(self)(model, base, tip, locked=locked)
        if out._error is None:
            out._allowed.update({pair: why for pair, why in self._allowed.items() if why == allowed_collisions.SRDF})
        out._changes, out.world = dict(self._changes), self.world
        return out

    def _copy(self) -> CollisionModel:
        out = object.__new__(type(self))
        out.__dict__.update(self.__dict__)
        out._seen = out._last = None
        return out

    def _changed(self, first: str, second: str, must_not: bool) -> CollisionModel:
        self._require_geometry()
        obstacles = () if self.world is None else self.world.names
        rank = self._ranks(obstacles)
        pair = allowed_collisions.named(first, second, rank, [*dict.fromkeys(self._arm.links), *obstacles])
        if pair[0] in obstacles:
            both = f"{quoted(first)} and {quoted(second)}"
            raise ArgumentError(f"{both} are both obstacles, which stand still; a pair has a link")
        out = self._copy()
        out._changes, out._link_check = {**self._changes, pair: must_not}, None
        return out

    def _ranks(self, obstacles: Iterable[str]) -> dict[str, int]:
        """Every link and then every obstacle, to its place."""
        return {name: i for i, name in enumerate((*self._rank, *obstacles))}

    def _table(self) -> Table:
        """The table of the world as it is, all pairs listed."""
        names = self._now().check.index.names()
        allowed, pairs = allowed_collisions.with_obstacles(self._arm, names)
        pairs += [pair.names for pair in self._pairs]
        return allowed_collisions.made({**self._allowed, **allowed}, pairs, self._changes, self._ranks(names))

    def _now(self) -> Seen:
        """The check for the world's present state."""
        seen, world = self._seen, self.world
        if seen is None or (world is not None and seen.version != world.version):
            version, index = (0, None) if world is None else world.snapshot()
            if index is not None and (same := next((link for link in self._rank if index.slots_of(link)), None)):
                raise ArgumentError(f"the obstacle {quoted(same)} has the name of a link of the arm; give it another")
            excepted, added = allowed_collisions.exceptions(self._arm, self._changes, self._rank)
            self._seen = seen = Seen(version, CoalCheck(self._links(), index, excepted, added))
        return seen

    def _links(self) -> LinkCheck:
        """The check of links against each other, which no world changes."""
        check = self._link_check
        if check is None:
            names = {pair.names for pair in self._pairs}
            checked = set(allowed_collisions.made(self._allowed, names, self._changes, self._rank).checked)
            kept = [pair for pair in self._pairs if pair.names in checked]
            self._link_check = check = LinkCheck(self._arm, kept)
        return check


def _restored(
    model: UrdfModel,
    base: str | None,
    tip: str | None,
    locked: dict[str, float],
    samples: int,
    seed: int,
    allowed: dict[Pair, str] | None,
    changes: dict[Pair, bool],
    world: World | None,
) -> CollisionModel:
    """A collision model as it was before it was pickled: coal's shapes are made again."""
    out = CollisionModel(model, base, tip, samples=0 if allowed is not None else samples, seed=seed, locked=locked)
    if allowed is not None:
        out._allowed = allowed
    out._made_from = (model, base, tip, locked, samples, seed)
    out._changes, out.world = changes, world
    return out
