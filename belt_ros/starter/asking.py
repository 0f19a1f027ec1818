"""The questions on a terminal, one after another; a wrong answer is asked for again."""

from collections.abc import Mapping

from rich.console import Console
from rich.prompt import Confirm, Prompt

from belt_ros.parameter_table import SettingsError
from belt_ros.starter.answers import MOTOR_CURRENT, QUESTIONS, Answers, answers_from
from belt_ros.starter.beside import check_beside
from belt_ros.starter.question import Answer, Question

_LISTED = 6  # choices that are shown; of more, `?` shows them


def ask(given: Mapping[str, object], console: Console) -> Answers:
    """Ask what `given` does not answer.

    Parameters
    ----------
    given : mapping
        Answers by name, as from flags; None where there is none.
    console : Console
        A terminal.

    Raises
    ------
    SettingsError
        If `given` holds an answer that cannot be, or answers contradict each other.
    """
    said: dict[str, object] = {
        name: QUESTIONS[name].check(value) for name, value in given.items() if value is not None
    }
    console.print("Enter takes what is in brackets, or leaves open what nobody knows.", style="dim")
    for name, question in QUESTIONS.items():
        if name not in said and _matters(question, said):
            answer = _answer(question, said, console)
            if answer is not None:
                said[name] = answer
    return answers_from(said)


def _matters(question: Question, said: Mapping[str, object]) -> bool:
    name = question.name
    if name in {"driver_inertia", "driven_inertia"}:
        return name.replace("inertia", "mass") not in said
    if name in {"driver_joint", "driven_joint"}:
        return said.get("input") == "joint_state"
    if name == "torque_constant":
        return said.get("torque") == MOTOR_CURRENT
    if name == "tension_tolerance":
        return "tension" in said
    return not question.detail


def _answer(question: Question, said: Mapping[str, object], console: Console) -> Answer:
    unit = f" [{question.unit}]" if question.unit not in ("", "-") else ""
    text = f"{question.text}{unit}".replace("[", r"\[")
    if isinstance(question.default, bool):
        return Confirm.ask(text, console=console, default=question.default)
    if 0 < len(question.choices) <= _LISTED:
        text += f" ({', '.join(question.choices)})"
    elif question.choices:
        text += " (? lists them)"
    default = "" if question.default is None else f"{question.default}"
    while True:
        reply = Prompt.ask(text, console=console, default=default, show_default=bool(default))
        if reply.strip() == "?" and question.choices:
            console.print(", ".join(question.choices), highlight=False)
            continue
        needed = question.needed or question.name == "torque_constant"
        if not reply.strip() and not needed:
            return None
        try:
            answer = question.check(reply)
            check_beside(question.name, {**said, question.name: answer})
        except SettingsError as error:
            console.print(str(error), style="red", highlight=False, markup=False)
        else:
            return answer
