# SPDX-License-Identifier: MIT
"""Counts answers and prints them: a confusion matrix and a calibration table, as Markdown."""

from collections import Counter

CLASSES = ["standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"]
BINS = [0.0, 0.6, 0.7, 0.8, 0.9, 0.95, 1.01]


def bin_of(confidence):
    return max(k for k in range(len(BINS) - 1) if confidence >= BINS[k])


def title_of(k):
    if k == len(BINS) - 2:
        return f"{BINS[k]:.2f} and more"
    return f"below {BINS[1]:.2f}" if k == 0 else f"{BINS[k]:.2f} to {BINS[k + 1]:.2f}"


def row(*cells):
    return "| " + " | ".join(str(c) for c in cells) + " |"


class Answers:
    """What was said about the samples of one set."""

    def __init__(self, title):
        self.title = title
        self.called = Counter()  # (class, said) -> how many
        self.sure = Counter()  # (bin, right) -> how many
        self.wrong = []
        self.count = 0

    def add(self, sample, said, confidence):
        right = sample.right(said)
        # An answer that is one of several right ones counts where it belongs.
        self.called[said if right else sample.kind, said] += 1
        self.sure[bin_of(confidence), right] += 1
        self.count += 1
        if not right:
            self.wrong.append((confidence, sample.name, sample.kind, said))

    def rights(self):
        return self.count - len(self.wrong)

    def confusion(self, classes=CLASSES):
        lines = [row("is \\ called", *classes), "|---|" + "---:|" * len(classes)]
        for kind in classes:
            counts = [self.called[kind, said] for said in classes]
            if sum(counts):
                lines.append(row(kind, *counts))
        return lines


class Sides(Answers):
    """Which way green points: undecided is no answer, and counted apart."""

    def __init__(self, title):
        super().__init__(title)
        self.undecided = 0

    def add(self, sample, said, confidence):
        if not said:
            self.undecided += 1
            return
        self.sure[bin_of(confidence), said == sample.y] += 1
        self.count += 1
        if said != sample.y:
            self.wrong.append((confidence, sample.name, sample.y, said))


def percent(part, whole):
    return f"{100 * part / whole:.1f} %" if whole else "-"


def overview(sets):
    lines = [row("set", "images", "right", "wrong", "wrong at 0.90 and more", "of so many at 0.90")]
    lines.append("|---|" + "---:|" * 5)
    for one in sets:
        sure = sum(n for (k, _), n in one.sure.items() if BINS[k] >= 0.9)
        bad = sum(n for (k, right), n in one.sure.items() if BINS[k] >= 0.9 and not right)
        share = percent(one.rights(), one.count)
        lines.append(row(one.title, one.count, share, len(one.wrong), bad, sure))
    return lines


def calibration(sets):
    lines = [row("confidence", *(s.title for s in sets)), "|---|" + "---:|" * len(sets)]
    for k in range(len(BINS) - 1):
        cells = []
        for one in sets:
            right, wrong = one.sure[k, True], one.sure[k, False]
            cells.append(f"{right} of {right + wrong}" if right + wrong else "-")
        lines.append(row(title_of(k), *cells))
    return lines


def sides_overview(sets):
    lines = [row("set", "images", "undecided", "right", "wrong", "wrong at 0.90 and more")]
    lines.append("|---|" + "---:|" * 5)
    for one in sets:
        bad = sum(n for (k, right), n in one.sure.items() if BINS[k] >= 0.9 and not right)
        all_of = one.count + one.undecided
        lines.append(row(one.title, all_of, one.undecided, one.rights(), len(one.wrong), bad))
    return lines
