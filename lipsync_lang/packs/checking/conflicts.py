"""Find contradictions between the constraints, priorities and contacts of a pose set."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import combinations

from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs.models import AtMost, BankPack, Character, PoseSet, Threshold
from lipsync_lang.packs.models.pose_models import NO_THRESHOLD
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.source import Loc

SUM_TOLERANCE = 1e-9
"""Tolerance for sums of floats: 0.9 + 0.8 must not exceed 1.7."""


def conflicts(poseset: Pack[PoseSet], banks: Iterable[BankPack] | None = None) -> Iterator[Fault]:
    """Yield faults that make constraints impossible or hide contacts.

    `banks` are the pose set's banks; None if one cannot be loaded, which skips the checks of
    thresholds that no curve reaches.
    """
    yield from _pairs(poseset)
    yield from _circles(poseset)
    yield from _outranked(poseset)
    yield from _together(poseset)
    yield from _contacts(poseset)
    yield from unprepared(poseset, poseset.model)
    if banks is not None:
        yield from _unreached(poseset, banks)


def _rank(model: PoseSet, pose: str) -> int:
    """Return a pose's index in `priority`; unlisted poses rank above all others."""
    return model.priority.index(pose) if pose in model.priority else len(model.priority)


def _threshold(model: PoseSet, one: str, other: str) -> tuple[float, Loc]:
    """Return the largest sum of two poses, and its place."""
    for index, pair in enumerate(model.constraints.pairs):
        if isinstance(pair, Threshold) and set(pair.between) == {one, other}:
            return pair.threshold, ("constraints", "pairs", index, "threshold")
    return model.constraints.default, ("constraints", "default")


def _unlisted(model: PoseSet, poses: Iterable[str]) -> list[tuple[str, str]]:
    """Return the pairs of the given poses that have the default threshold."""
    pairs = model.constraints.pairs
    listed = {frozenset(p.between) for p in pairs if isinstance(p, Threshold)}
    return [pair for pair in combinations(poses, 2) if frozenset(pair) not in listed]


def _pairs(poseset: Pack[PoseSet]) -> Iterator[Fault]:
    """Check that no pair is constrained twice or with itself, and that one of its poses yields."""
    model = poseset.model
    seen: dict[tuple[object, ...], int] = {}
    for index, pair in enumerate(model.constraints.pairs):
        loc = ("constraints", "pairs", index)
        threshold = isinstance(pair, Threshold)
        one, other = pair.between if isinstance(pair, Threshold) else (pair.pose, pair.at_most)
        key = (threshold, *(sorted((one, other)) if threshold else (one, other)))
        if one == other:
            what = f"'{one}' is constrained with itself"
            yield poseset.fault(loc, "P216", what, "name two poses")
        elif key in seen:
            line = poseset.where(("constraints", "pairs", seen[key])).line
            what = f"'{one}' and '{other}' are constrained twice"
            yield poseset.fault(loc, "P216", what, f"first in line {line}; keep one of the two")
        elif (
            isinstance(pair, Threshold)
            and pair.threshold < NO_THRESHOLD
            # unknown names are faults of their own, and rank like unlisted poses
            and {one, other} <= set(model.poses)
            and _rank(model, one) == _rank(model, other)
        ):
            what = f"'{one}' and '{other}' have equal priority, so neither yields"
            yield poseset.warning(loc, "W302", what, "name the pose that yields under `priority`")
        seen.setdefault(key, index)
    level = [pose for pose in model.poses if pose not in model.priority]
    tied = dict.fromkeys(pose for pair in _unlisted(model, level) for pose in pair)
    limited = model.constraints.default < NO_THRESHOLD and set(model.priority) <= set(model.poses)
    if tied and limited:
        what = f"none of {', '.join(map(repr, tied))} yields: `priority` names none of them"
        hint = "name those that yield in `priority`, or raise `default`"
        yield poseset.warning(("constraints", "default"), "W302", what, hint)


def _circles(poseset: Pack[PoseSet]) -> Iterator[Fault]:
    """Check that `at_most` constraints form no circle."""
    rules = [
        (index, pair.pose, pair.at_most)
        for index, pair in enumerate(poseset.model.constraints.pairs)
        if isinstance(pair, AtMost) and pair.pose != pair.at_most
    ]
    waits = grouped((pose, other) for _, pose, other in rules)
    for index, pose, other in rules:
        path = path_between(waits, other, pose)
        if path:
            what = f"constraints form a circle: {' -> '.join((pose, *path))}"
            hint = "a pose cannot depend on itself; remove one"
            yield poseset.fault(("constraints", "pairs", index), "P206", what, hint)


def path_between(waits: Mapping[str, Collection[str]], start: str, goal: str) -> tuple[str, ...]:
    """Return the nodes on a path from `start` to `goal`; empty if there is none."""
    came: dict[str, str] = {start: ""}
    todo = [start]
    while todo:
        pose = todo.pop()
        if pose == goal:
            path = [pose]
            while came[path[-1]]:
                path.append(came[path[-1]])
            return tuple(reversed(path))
        # sorted, because the order of a set differs from run to run, and the message names the path
        for other in sorted(waits.get(pose, ())):
            if other not in came:
                came[other] = pose
                todo.append(other)
    return ()


def _floors(model: PoseSet) -> dict[str, tuple[float, str]]:
    """Map each pose with a floor to its highest floor and the contact that sets it."""
    floors: dict[str, tuple[float, str]] = {}
    for name, contact in model.contacts.items():
        for pose, floor in contact.floor.items():
            if floor > 0 and floor > floors.get(pose, (0.0, ""))[0]:
                floors[pose] = floor, name
    return floors


def _outranked(poseset: Pack[PoseSet]) -> Iterator[Fault]:
    """Check that no pose has a floor above its threshold with a pose that it yields to.

    A pose that outranks a contact pose makes room for its floor, as far as the threshold lets it.
    """
    model = poseset.model
    # an unlisted pose may be the one that a misspelt name means, and would seem to outrank all
    misspelt = not set(model.priority) <= set(model.poses)
    ranked = [pose for pose in model.poses if pose in model.priority or not misspelt]
    for pose, (floor, name) in _floors(model).items():
        loc = ("contacts", name, "floor", pose)
        for other in (one for one in ranked if _rank(model, one) > _rank(model, pose)):
            threshold = _threshold(model, pose, other)[0]
            if threshold < floor - SUM_TOLERANCE:
                above = f"above {threshold:g}, but its floor is {floor:g}"
                what = f"'{pose}' yields to '{other}' {above}"
                hint = f"put '{pose}' after '{other}' in `priority`, or raise the threshold"
                yield poseset.fault(loc, "P207", what, hint, key=True)
    for pair in model.constraints.pairs:
        if not isinstance(pair, AtMost):
            continue
        for name, contact in model.contacts.items():
            if contact.floor.get(pair.pose, 0) > contact.floor.get(pair.at_most, 0):
                loc = ("contacts", name, "floor", pair.pose)
                what = f"'{pair.pose}' never passes '{pair.at_most}', which is not held as high"
                hint = f"remove the constraint, or hold '{pair.at_most}' as well"
                yield poseset.fault(loc, "P207", what, hint, key=True)


def _together(poseset: Pack[PoseSet]) -> Iterator[Fault]:
    """Check that no phoneme demands two floors that exclude each other.

    Contacts of different phonemes may exclude each other: a lip cannot press the other lip and meet
    the teeth. Where both are held, the later one in the pack wins, so it must have the priority.
    """
    model = poseset.model
    contacts, places = model.contacts, list(model.contacts)
    for (one, (low, some)), (other, (high, others)) in combinations(_floors(model).items(), 2):
        threshold, loc = _threshold(model, one, other)
        if threshold >= min(NO_THRESHOLD, low + high - SUM_TOLERANCE):
            continue
        if some == others or set(contacts[some].phonemes) & set(contacts[others].phonemes):
            what = (
                f"'{one}' and '{other}' may add up to {threshold:g}, "
                f"but their contacts need {low + high:g}"
            )
            yield poseset.fault(loc, "P208", what, "raise the threshold, or lower the floors")
            continue
        ahead = _rank(model, one) - _rank(model, other)
        # Opposite signs: the contact with the priority is not the one that is held last.
        if ahead * (places.index(some) - places.index(others)) < 0:
            first, last = (others, some) if ahead > 0 else (some, others)
            what = f"contacts '{first}' and '{last}' exclude each other, and '{first}' is held last"
            hint = f"put '{last}', whose pose has the priority, after '{first}'"
            yield poseset.warning(("contacts", last), "W316", what, hint, key=True)


def _contacts(poseset: Pack[PoseSet]) -> Iterator[Fault]:
    """Check that each contact has an effect, and that none holds up what another keeps down.

    Contacts of different phonemes may do so, such as those of a hinge that opens and shuts.
    """
    contacts = poseset.model.contacts
    for name, contact in contacts.items():
        for pose, top in contact.ceiling.items():
            for other, raising in contacts.items():
                both = set(contact.phonemes) & set(raising.phonemes)
                if both and raising.floor.get(pose, 0.0) > top:
                    loc = ("contacts", name, "ceiling", pose)
                    what = f"'{pose}' gets a ceiling here, but contact '{other}' holds it up"
                    hint = f"remove it from one of the two; both have {', '.join(sorted(both))}"
                    yield poseset.fault(loc, "P209", what, hint, key=True)
        if not any(contact.floor.values()) and all(top == 1 for top in contact.ceiling.values()):
            what = f"contact '{name}' has no effect: no floor above 0, no ceiling below 1"
            hint = "state a `floor` above 0 or a `ceiling` below 1, or remove the contact"
            yield poseset.warning(("contacts", name), "W312", what, hint, key=True)


def unprepared(pack: Pack[PoseSet] | Pack[Character], poseset: PoseSet) -> Iterator[Fault]:
    """Check that a pack's target of a phoneme meets the floors and ceilings of its contacts."""
    targets = pack.model.targets
    for name, contact in poseset.contacts.items():
        for phoneme in (label for label in contact.phonemes if label in targets):
            for pose in (p for p in contact.floor | contact.ceiling if p in poseset.poses):
                heights = [step.weights.get(pose, 0.0) for step in targets[phoneme]]
                floor, top = contact.floor.get(pose, 0.0), contact.ceiling.get(pose, 1.0)
                if max(heights) < floor:
                    reached, limit = f"gets to {max(heights):g}", floor
                elif min(heights) > top:
                    reached, limit = f"stays at {min(heights):g}", top
                else:
                    continue
                what = f"'{pose}' {reached}, but contact '{name}' is at {limit:g}"
                hint = "change the target or the contact, so that a draft satisfies it"
                yield pack.warning(("targets", phoneme), "W314", what, hint, key=True)


def _unreached(poseset: Pack[PoseSet], banks: Iterable[BankPack]) -> Iterator[Fault]:
    """Check that the largest weights of two poses in targets, banks and floors pass thresholds."""
    model, constraints = poseset.model, poseset.model.constraints
    units = (
        unit for bank in banks for some in (bank.bigrams, bank.trigrams) for unit in some.values()
    )
    weights: list[Mapping[str, float]] = [
        *(target.weights for steps in model.targets.values() for target in steps),
        *({pose: max(v for _, v in curve) for pose, curve in u.curves.items()} for u in units),
        *(contact.floor for contact in model.contacts.values()),
    ]
    reach: dict[str, float] = {}
    for some in weights:
        for pose, weight in some.items():
            reach[pose] = max(weight, reach.get(pose, 0.0))
    for index, pair in enumerate(constraints.pairs):
        if isinstance(pair, Threshold) and set(pair.between) <= set(reach):
            one, other = pair.between
            together = reach[one] + reach[other]
            if together <= pair.threshold < NO_THRESHOLD and one != other:
                what = (
                    f"'{one}' and '{other}' never add up to more than {pair.threshold:g}: "
                    f"they reach {reach[one]:g} and {reach[other]:g}"
                )
                loc = ("constraints", "pairs", index, "threshold")
                yield poseset.warning(loc, "W313", what, "lower the threshold, or drop the pair")
    pairs = _unlisted(model, model.poses) if constraints.default < NO_THRESHOLD else ()
    if pairs and {p for pair in pairs for p in pair} <= set(reach):
        one, other = max(pairs, key=lambda pair: reach[pair[0]] + reach[pair[1]])
        if reach[one] + reach[other] <= constraints.default:
            what = f"'{one}' and '{other}' never add up to more than {reach[one] + reach[other]:g}"
            hint = "no other pair without a threshold of its own does; lower `default`, or drop it"
            yield poseset.warning(("constraints", "default"), "W313", what, hint)
