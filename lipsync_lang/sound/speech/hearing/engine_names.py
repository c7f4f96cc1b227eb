"""Names of aligners and recognisers, alone or with their model: `NAME:MODEL`."""

from lipsync_lang.base.errors import SpeechError


def engine_and_model(
    named: str | None, stated: str | None, model: str | None = None
) -> tuple[str | None, str | None]:
    """Return the name of an engine and its model; None for a missing name or model.

    Parameters
    ----------
    named : what the user names, which comes first
    stated : what the language's pack states
    model : the pack's model, for the engine that it states

    Raises
    ------
    SpeechError
        Nothing stands before or after the colon.

    Examples
    --------
    >>> engine_and_model("mfa:german_mfa", "warp")
    ('mfa', 'german_mfa')
    >>> engine_and_model("mfa", "mfa:german_mfa")
    ('mfa', 'german_mfa')
    """
    name, own = _parted(named)
    default, default_model = _parted(stated)
    if name is None or name == default:
        name, model = default, own or default_model or model
    else:
        model = own
    return name, model


def _parted(spelling: str | None) -> tuple[str | None, str | None]:
    if spelling is None:
        return None, None
    name, colon, model = (part.strip() for part in spelling.partition(":"))
    if not name or (colon and not model):
        raise SpeechError(f"'{spelling}': write NAME, or NAME:MODEL")
    return name, model or None
