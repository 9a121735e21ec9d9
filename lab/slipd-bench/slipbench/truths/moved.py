"""What the two generators of motion share: when an alarm is in time."""
from ..recording import Slip, Truth


def judged(kind, contact_s, end_s, onset_s, told_s, options):
    """told_s: of several limits of motion, when each was passed; the first counts."""
    if kind == "still":
        return Truth(quiet=[(contact_s, end_s)], held=[(contact_s, end_s)])
    if kind != "slip" or onset_s is None:
        return Truth()
    passed = min(t for t in (*told_s, end_s) if t is not None)
    slip = Slip(onset_s - options["early_s"], max(passed, onset_s) + options["late_s"], onset_s)
    return Truth(slips=[slip], unsafe=[(passed, passed + options["late_s"])])
