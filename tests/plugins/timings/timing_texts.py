"""The words of timings, as tests compare them."""


def spoken(schedule):
    """The words, each with its labels."""
    return [(w.text, schedule.labels[w.first : w.stop]) for w in schedule.words]
