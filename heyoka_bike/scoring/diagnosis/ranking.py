"""Ranking of causes: causes that the file cannot distinguish are in one class."""

from collections.abc import Sequence
from math import log

from heyoka_bike.scoring.diagnosis.claims import explains, left_over
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis, log_odds_before
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.program import apply, differences
from heyoka_bike.scoring.diagnosis.seen_file import FileUnderTest
from heyoka_bike.scoring.ratios import CLEARLY


def ranked(
    file: FileUnderTest, found: Sequence[Hypothesis], starts: Sequence[Hypothesis] = ()
) -> tuple[tuple[Hypothesis, ...], ...]:
    """Rank likely hypotheses in classes that the file cannot distinguish.

    The result is empty if the best hypothesis does not explain the file.
    """
    all_of_them = (*_likelier(file, found), *starts)
    worth = [h for h in all_of_them if h.is_possible and h.log_odds > THRESHOLDS.report_log_odds]
    count = len({n for h in worth for n, _ in h.after})
    worth.sort(
        key=lambda h: (
            THRESHOLDS.independent_values * count * log(h.gain) + log_odds_before(h.mistakes)
        ),
        reverse=True,
    )
    classes: list[list[Hypothesis]] = []
    for h in worth:
        if classes and (
            file.log_odds(classes[0][0], h) > THRESHOLDS.drop_log_odds
            # A hypothesis that adds a further cause to the best hypothesis is not a different
            # answer.
            or classes[0][0].parts < h.parts
        ):
            continue
        if classes and file.log_odds(classes[-1][0], h) < THRESHOLDS.report_log_odds:
            classes[-1].append(h)
        else:
            classes.append([h])
    explain = [[h for h in c if explains(h, file.residual)] for c in classes]
    return _different(file, [tuple(c) for c in explain if c]) if classes and explain[0] else ()


def _different(
    file: FileUnderTest, classes: Sequence[tuple[Hypothesis, ...]]
) -> tuple[tuple[Hypothesis, ...], ...]:
    """Drop classes whose first cause changes the same values as the likeliest cause.

    For example, g = 9.8 as a usual mistake and as a fitted value is one cause in two wordings.
    """

    def changed(hypotheses: tuple[Hypothesis, ...]) -> set[str]:
        mistakes = hypotheses[0].mistakes
        is_of_model = all(m.kind == "model" for m in mistakes)
        return differences(apply(file.program, mistakes), file.program) if is_of_model else set()

    first = changed(classes[0])
    return tuple(c for i, c in enumerate(classes) if i == 0 or not first or changed(c) != first)


def singles_by_code(found: Sequence[Hypothesis]) -> dict[str, Hypothesis]:
    """Return the hypotheses of a single mistake, by its code."""
    return {h.codes[0]: h for h in found if len(h.mistakes) == 1}


def _likelier(file: FileUnderTest, found: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return single mistakes, and the pairs that are likelier than each of their mistakes alone."""
    alone = singles_by_code(found)

    def is_likelier(h: Hypothesis) -> bool:
        each = [alone[code] for code in h.codes if code in alone]
        # If an error remains with the pair, there is a further cause. Then the pair must reduce the
        # error clearly more than each of its mistakes alone.
        least = 1.0 if h.is_exhaustive or left_over(h, file.residual) is None else CLEARLY
        return all(
            file.log_odds(h, one) > THRESHOLDS.report_log_odds and h.gain > least * one.gain
            for one in each
        )

    pairs = [h for h in found if len(h.mistakes) > 1]
    return [*alone.values(), *filter(is_likelier, pairs)]
