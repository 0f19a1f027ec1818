"""One question about a drive, and what an answer to it must be by itself."""

from typing import NamedTuple

from belt_ros.mechanics import DriveError
from belt_ros.mechanics.materials import belt_material
from belt_ros.mechanics.units import meant_millimetres
from belt_ros.parameter_table import SettingsError

Answer = float | str | bool | None


class Range(NamedTuple):
    """Unit and limits of a number: what is beyond them is in another unit."""

    unit: str
    low: float
    high: float


class Question(NamedTuple):
    """One question, and what an answer must be."""

    name: str
    text: str
    unit: str
    default: Answer
    choices: tuple[str, ...]
    needed: bool  # there is no default to go by
    detail: bool  # not asked on a terminal, a flag only
    number: bool
    signed: bool  # 1 or -1
    between: tuple[float, float]  # a number, unless signed

    @property
    def flag(self) -> str:
        """The flag of `belt init`."""
        return f"--{self.name.replace('_', '-')}"

    def check(self, value: object) -> Answer:
        """Return an answer in its type.

        Raises
        ------
        SettingsError
            If it is none.
        """
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise SettingsError(f"{self.flag} is {value!r}; it must be yes or no")
            return value
        if self.number:
            return self._number(value)
        return self._text(value)

    def _number(self, value: object) -> float:
        try:
            number = float(str(value))
        except ValueError:
            raise SettingsError(f"{self.flag} is {value!r}; it must be a number") from None
        if self.signed:
            if abs(number) != 1.0:
                raise SettingsError(f"{self.flag} is {number:g}; it must be 1 or -1")
            return number
        low, high = self.between
        if not low <= number <= high:
            unit = f" {self.unit}" if self.unit not in ("", "-") else ""
            hint = meant_millimetres(number, low, high) if self.unit == "m" else ""
            raise SettingsError(
                f"{self.flag} is {number:g}{unit}; it must lie between {low:g} and {high:g}{unit}"
                f"{hint}"
            )
        return number

    def _text(self, value: object) -> str:
        text = str(value).strip()
        if self.name == "belt":
            try:
                return belt_material(text).name
            except DriveError as error:
                raise SettingsError(f"{self.flag}: {error}") from error
        if not text or not text.isprintable():
            raise SettingsError(f"{self.flag} is {value!r}; it must be a name")
        if self.choices and text not in self.choices:
            raise SettingsError(
                f"{self.flag} is {text!r}; it must be one of {', '.join(self.choices)}"
            )
        return text
