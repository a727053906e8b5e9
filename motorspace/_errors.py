"""The one exception that means «the input is wrong», not «the program is»."""


class UserError(Exception):
    """Bad input, told in one sentence: what is wrong, where, and what to do.

    The command line prints it without a traceback and exits with code 2.
    """

    def __init__(self, what: str, *, where: object = None, remedy: str = "") -> None:
        self.what = what
        self.where = None if where is None else str(where)
        self.remedy = remedy
        place = "" if where is None else f"{where}: "
        advice = f"; {remedy}" if remedy else ""
        super().__init__(f"{place}{what}{advice}.")
