"""Parts of pages that a script writes, between ``<!-- x: begin -->`` and ``<!-- x: end -->``."""


def split(page: str, name: str) -> tuple[str, str, str]:
    """A page before a part with its mark, the part, and the page after it with its mark.

    Raises
    ------
    ValueError
        The page has no such part.
    """
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    before, first, rest = page.partition(begin)
    inside, last, after = rest.partition(end)
    if not (first and last):
        raise ValueError(f"no place for {name} in the page")
    return before + first, inside, last + after


def filled(page: str, name: str, made: str) -> str:
    """A page with the lines of a part made anew; see `split` for what is raised."""
    before, _, after = split(page, name)
    return f"{before}\n{made}\n{after}"
